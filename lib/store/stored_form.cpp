#include "store/stored_form.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <variant>

#include <fmt/format.h>

#include "base/units.h"

namespace surveymc::store {
namespace {

/// Length of the UTF-8 sequence at `at` (RFC 3629, section 4); 0 if it is none, and for NUL.
std::size_t utf8_length(const std::string& s, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < s.size() ? static_cast<unsigned char>(s[i]) : 0u; };
  const unsigned lead = byte(at), second = byte(at + 1);
  if (lead < 0x80) return lead == 0 ? 0 : 1;
  if (lead < 0xC2 || lead >= 0xF5) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second >= 0xA0;
  const bool too_large = lead == 0xF4 && second >= 0x90;
  return overlong || surrogate || too_large ? 0 : length;
}

}  // namespace

void for_each_stored(std::span<const double> values, const std::function<void(std::span<const double>)>& use) {
  constexpr std::size_t kPiece = std::size_t{1} << 15;
  std::vector<double> changed;
  for (std::size_t at = 0; at < values.size(); at += kPiece) {
    std::span<const double> piece = values.subspan(at, std::min(kPiece, values.size() - at));
    bool is_changed = false;
    for (const double x : piece)
      is_changed |= std::isnan(x) && std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(kNaN);
    if (is_changed) {
      changed.assign(piece.begin(), piece.end());
      std::replace_if(
          changed.begin(), changed.end(), [](double x) { return std::isnan(x); }, kNaN);
      piece = changed;
    }
    use(piece);
  }
}

bool is_canonical(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string canonical_text(const std::string& text) {
  if (is_canonical(text)) return text;
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0)
      out += "\xEF\xBF\xBD";
    else
      out.append(text, at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string link_name(const std::string& name, std::set<std::string>& taken) {
  std::string link = canonical_text(name);
  for (char& c : link) {
    if (c == '/' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '_';
  }
  while (link.ends_with(' ')) link.pop_back();
  if (link.empty() || link[0] == '.' || link[0] == ' ') link.insert(0, "_");
  std::string unique = link;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = fmt::format("{}_{}", link, i);
  return unique;
}

std::string input_group_name(const std::string& path, std::set<std::string>& taken) {
  std::string stem = canonical_text(std::filesystem::path(path).stem().string());
  for (char& c : stem) {
    const auto u = static_cast<unsigned char>(c);
    const bool letter = (u | 0x20) >= 'a' && (u | 0x20) <= 'z';
    const bool digit = u >= '0' && u <= '9';
    if (u < 0x80 && !letter && !digit && c != '-' && c != '.') c = '_';
  }
  return link_name(stem.empty() ? "input" : stem, taken);
}

std::size_t axis_size(const Axis& axis) {
  return std::visit([](const auto& v) { return v.size(); }, axis.values);
}

}  // namespace surveymc::store
