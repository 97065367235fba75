#include "render/text.h"

#include <algorithm>

#include <fmt/format.h>

#include "store/stored_form.h"

namespace surveymc::render {
namespace {

/// Bytes of the character at `at` of UTF-8 text, if it does not show itself but changes how others are shown: control
/// characters (to U+009F), ends of lines (U+2028, U+2029), and the marks and embeddings of the direction of writing.
/// Else 0.
std::size_t control_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : static_cast<unsigned char>(0);
  };
  const unsigned char a = byte(0), b = byte(1), c = byte(2);
  if (a < 0x20 || a == 0x7F) return 1;
  if (a == 0xC2 && b >= 0x80 && b < 0xA0) return 2;  // U+0080 to U+009F
  if (a == 0xD8 && b == 0x9C) return 2;              // U+061C, Arabic letter mark
  if (a != 0xE2) return 0;
  const bool turns = (b == 0x80 && (c == 0x8E || c == 0x8F || (c >= 0xA8 && c <= 0xAE))) ||  // U+200E, U+2028 to U+202E
                     (b == 0x81 && c >= 0xA6 && c <= 0xA9);                                  // U+2066 to U+2069
  return turns ? 3 : 0;
}

}  // namespace

/// Notes and names come from config files: a line break would break the row, an escape sequence the terminal, and a
/// mark that turns the direction of writing would show another text than the one that is there.
std::string printable(std::string text) {
  if (std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; })) return text;
  text = store::canonical_text(text);  // a byte that is no UTF-8 may be an escape sequence, too
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = control_length(text, at);
    if (length == 0)
      out += text[at];
    else
      out += ' ';
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string escaped_controls(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = control_length(text, at);
    const auto bits = [&](std::size_t i, unsigned mask) { return static_cast<unsigned char>(text[at + i]) & mask; };
    if (length == 0) out += text[at];
    if (length == 1) out += fmt::format("\\u{:04x}", bits(0, 0x7F));
    if (length == 2) out += fmt::format("\\u{:04x}", bits(0, 0x1F) << 6 | bits(1, 0x3F));
    if (length == 3) out += fmt::format("\\u{:04x}", bits(0, 0x0F) << 12 | bits(1, 0x3F) << 6 | bits(2, 0x3F));
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string folded(const std::string& text, std::size_t widest, std::size_t indent) {
  std::size_t at = std::min(text.find_first_not_of(' '), text.size()), used = at;
  std::string out = text.substr(0, at);
  for (bool first = true; at < text.size(); first = false) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!first && used + 1 + width(word) > widest) {
      out += '\n' + std::string(indent, ' ');
      used = indent;
    } else if (!first) {
      out += ' ';
      ++used;
    }
    out += word;
    used += width(word);
    at = std::min(text.find_first_not_of(' ', end), text.size());
  }
  return out;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    longest = std::max(longest, end - begin);
    begin = end + 1;
  }
  return longest;
}

}  // namespace surveymc::render
