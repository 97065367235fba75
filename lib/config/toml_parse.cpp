#include "config/toml_tree.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <string_view>

#include <toml++/toml.h>

#include "base/error.h"

namespace surveymc::config {
namespace {

struct Source {
  std::string label;
  bool is_file = true;  // else an argument: the label is the whole place
};

template <class T>
std::string printed(const T& x) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << x;
  return out.str();
}

/// Where a node is, as a chain to the root: its key is written for messages only.
struct NodePath {
  const NodePath* parent = nullptr;
  std::string_view name;  // of an entry of a table
  std::size_t index = 0;  // of an item of an array, where `name` is empty
  bool is_item = false;

  std::string text() const {
    const std::string head = parent ? parent->text() : "";
    return is_item  ? fmt::format("{}[{}]", head, index)
           : parent ? join_key(head, key_text(std::string(name)))
                    : std::string(name);
  }
};

TomlNode convert(const toml::node& t, const Source& source, const NodePath& path) {
  TomlNode n;
  if (const auto* table = t.as_table()) {
    n.is_inline = table->is_inline();
    for (const auto& [k, v] : *table) {
      n.entries.emplace(k.str(), convert(v, source, {&path, k.str()}));
    }
  } else if (const auto* array = t.as_array()) {
    n.kind = TomlNode::Kind::array;
    n.items.reserve(array->size());
    for (std::size_t i = 0; i < array->size(); ++i)
      n.items.push_back(convert(*array->get(i), source, {&path, {}, i, true}));
  } else if (const auto* text = t.as_string()) {
    n = node_of(text->get());
  } else if (const auto* flag = t.as_boolean()) {
    n = node_of(flag->get());
  } else if (const auto* integer = t.as_integer()) {
    n = node_of(integer->get());
  } else if (const auto* real = t.as_floating_point()) {
    n = node_of(real->get());
  } else {
    n.kind = TomlNode::Kind::date;
    if (const auto* date = t.as_date()) n.text = printed(date->get());
    if (const auto* time = t.as_time()) n.text = printed(time->get());
    if (const auto* both = t.as_date_time()) n.text = printed(both->get());
  }
  n.line = source.is_file ? static_cast<int>(t.source().begin.line) : 0;
  n.place = source.label;
  if (n.line > 0) n.place += ":" + std::to_string(n.line);
  if (n.kind == TomlNode::Kind::real && !std::isfinite(n.real)) refuse(n, path.text(), "must be a finite number");
  return n;
}

/// What a line that is no TOML may have meant, for the end of a message; "" where nothing is near.
std::string meant_by(std::string_view text, std::size_t line) {
  for (std::size_t n = 1; n < line; ++n) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return "";
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find('\n'));
  const std::size_t sign = text.find('=');
  if (sign == std::string_view::npos) return "";
  constexpr std::string_view kBlank = " \t\r";
  std::string_view value = text.substr(sign + 1);
  if (const std::size_t first = value.find_first_not_of(kBlank); first != std::string_view::npos)
    value.remove_prefix(first);
  if (value.starts_with('"'))
    return value.find('\\') == std::string_view::npos
               ? ""
               : R"(; in "..." a \ begins an escape: write a path with /, or in '...')";
  value = value.substr(0, value.find('#'));
  value = value.substr(0, value.find_last_not_of(kBlank) + 1);
  if (value.empty()) return "";
  if (value.starts_with("\xE2\x80"))  // quotes of a word processor
    return "; a text stands in straight quotes: \"...\"";
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t comma = value.find(',');
  if (comma != std::string_view::npos && value.find_first_not_of("+-0123456789,") == std::string_view::npos &&
      comma > 0 && comma + 1 < value.size() && value.find(',', comma + 1) == std::string_view::npos)
    return fmt::format("; the decimal mark is a point: {}.{}", value.substr(0, comma), value.substr(comma + 1));
  const bool is_word = kDigits.find(value[0]) == std::string_view::npos &&
                       value.find_first_of("\"'[]{}=,") == std::string_view::npos && value[0] != '+' && value[0] != '-';
  return is_word ? fmt::format("; a text stands in quotes: \"{}\"", value) : "";
}

}  // namespace

TomlNode parse_document(const std::string& text, const std::string& label) {
  try {
    return convert(toml::parse(std::string_view(text), std::string_view(label)), {label, true}, {});
  } catch (const toml::parse_error& e) {
    const auto line = static_cast<std::size_t>(e.source().begin.line);
    throw InputError(fmt::format("{}:{}: {}{}", label, line, e.description(), meant_by(text, line)));
  }
}

TomlNode parse_value(const std::string& value, const std::string& key, const std::string& place) {
  require(!value.empty(), "{}: {}: the value is missing", place, key);
  const bool one_line = std::none_of(value.begin(), value.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F;
  });
  require(one_line, "{}: {}: the value must be one line of text", place, key);
  TomlNode word = node_of(value);
  word.place = place;
  try {
    const auto table = toml::parse(std::string_view("value = " + value));
    TomlNode n = convert(*table.get("value"), {place, false}, {nullptr, key});
    return n.kind == TomlNode::Kind::date ? word : n;  // no key is a date, but a title may look like one
  } catch (const toml::parse_error& e) {
    // Quotes and brackets are no part of a word: TOML was meant.
    require(value.find_first_of("\"'[]{}") == std::string::npos, "{}: {}: {}", place, key, e.description());
  }
  return word;
}

}  // namespace surveymc::config
