#include "config/toml_tree.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "base/error.h"
#include "config/text.h"

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

/// The end of the string that begins at `at`: behind its closing quotes, or at the end of its line or of the text.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool is_long = text.substr(at, 3) == three;
  for (at += is_long ? 3 : 1; at < text.size(); ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (!is_long && (text[at] == quote || text[at] == '\n')) {
      return text[at] == quote ? at + 1 : at;
    } else if (is_long && text.substr(at, 3) == three) {
      at += 3;
      while (at < text.size() && text[at] == quote) ++at;  // """a "quote"""": the last of five belong to the string
      return at;
    }
  }
  return text.size();
}

/// Where tables and lists stand more than kDeepestNesting deep inside each other: the beginning of that line. Counted
/// on the text, because parsers and whatever walks or destroys a tree call themselves once a level.
std::optional<std::size_t> nested_too_deep(std::string_view text) {
  struct Level {
    bool is_list;
    std::size_t around;     // levels around it
    std::size_t parts = 1;  // of the key that is read, where it is a table
    bool is_in_key = true;
    std::size_t depth() const { return around + (is_list ? 1 : parts); }
  };
  std::vector<Level> open{{false, 0}};
  std::size_t line = 0;
  bool is_header = false;
  for (std::size_t at = 0; at < text.size();) {
    Level& now = open.back();
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    ++at;
    if (c == '\n') {
      line = at;
      if (open.size() == 1) now = {false, is_header ? now.depth() : now.around};
      is_header = false;
    } else if (c == '[' && open.size() == 1 && now.is_in_key) {
      // A header counts from the root; in [[a.b]] the list is a level, too.
      now = {false, is_header ? std::size_t{1} : std::size_t{0}};
      is_header = true;
    } else if (c == '[' || c == '{') {
      open.push_back({c == '[', now.depth()});
    } else if ((c == ']' || c == '}') && open.size() > 1) {
      open.pop_back();
    } else if (c == '=') {
      now.is_in_key = false;
    } else if (c == ',' && !now.is_list && open.size() > 1) {
      now = {false, now.around};
    } else if (c == '.' && now.is_in_key) {
      ++now.parts;
    }
    if (open.back().depth() > kDeepestNesting) return line;
  }
  return std::nullopt;
}

}  // namespace

TomlNode parse_document(const std::string& text, const std::string& label) {
  if (const auto at = nested_too_deep(text)) {
    const std::string_view line = std::string_view(text).substr(*at, text.find_first_of("\r\n", *at) - *at);
    throw InputError(fmt::format("{}:{}: {}: {}", label,
                                 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(*at), '\n'),
                                 shortened(trimmed(line)), kTooDeep));
  }
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
  if (nested_too_deep("value = " + value))
    throw InputError(fmt::format("{}: {} = {}: {}", shortened(place), key, shortened(value), kTooDeep));
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
