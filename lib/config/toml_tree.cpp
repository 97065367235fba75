#include "config/toml_tree.h"

#include <charconv>
#include <utility>

#include "base/error.h"
#include "config/config.h"
#include "config/text.h"

namespace surveymc::config {

using Kind = TomlNode::Kind;

TomlNode node_of(bool x) { return {.kind = Kind::boolean, .flag = x}; }
TomlNode node_of(std::int64_t x) { return {.kind = Kind::integer, .integer = x}; }
TomlNode node_of(double x) { return {.kind = Kind::real, .real = x}; }
TomlNode node_of(const std::string& x) { return {.kind = Kind::text, .text = x}; }
TomlNode node_of(const std::vector<double>& x) {
  TomlNode n{.kind = Kind::array};
  for (const double v : x) n.items.push_back(node_of(v));
  return n;
}

// -------------------------------------------------------------------------------------------------------------- keys

bool is_bare_key(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string key_text(const std::string& name) { return is_bare_key(name) ? name : in_quotes(name); }

std::string join_key(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

std::vector<std::string> split_key(std::string_view key) {
  std::vector<std::string> parts;
  for (;;) {
    const auto dot = key.find('.');
    parts.emplace_back(key.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    key.remove_prefix(dot + 1);
  }
}

std::optional<std::string> clean_key(std::string_view key) {
  const std::vector<std::string> parts = split_key(key);
  if (parts.size() > kDeepestNesting) return std::nullopt;
  std::string out;
  for (const auto& part : parts) {
    const std::string name(trimmed(part));
    if (!is_bare_key(name)) return std::nullopt;
    out = join_key(out, name);
  }
  return out;
}

std::string no_key_rule(std::string_view key) {
  if (split_key(key).size() > kDeepestNesting) return kTooDeep;
  return fmt::format("{} is not a key", in_quotes(shortened(key)));
}

// ---------------------------------------------------------------------------------------------------- setting values

namespace {

/// assign(), but returns the key of what is in the way; `root` is unchanged then.
std::optional<std::string> try_assign(TomlNode& root, const std::string& key, const TomlNode& value) {
  const auto parts = split_key(key);
  TomlNode* at = &root;
  std::string path;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    path = join_key(path, parts[i]);
    auto [it, is_new] = at->entries.try_emplace(parts[i]);
    TomlNode& next = it->second;
    if (is_new) {
      next.place = value.place;
      next.line = value.line;
    } else if (next.is_text()) {
      TomlNode name = std::exchange(next, TomlNode{});
      next.place = name.place;
      next.line = name.line;
      next.entries["name"] = std::move(name);
    } else if (!next.is_table()) {
      return path;
    }
    at = &next;
  }
  const auto [it, is_new] = at->entries.try_emplace(parts.back(), value);
  TomlNode& target = it->second;
  if (is_new) return std::nullopt;
  if (target.is_table() && value.is_text()) {
    target.entries["name"] = value;
  } else {
    target = value;
  }
  return std::nullopt;
}

}  // namespace

void assign(TomlNode& root, const std::string& key, const TomlNode& value) {
  if (const auto blocked = try_assign(root, key, value)) {
    refuse(value, key, fmt::format("{} is not a table", *blocked));
  }
}

void assign_default(TomlNode& root, const std::string& key, const TomlNode& value) {
  const auto bracket = key.find('[');
  if (bracket == std::string::npos) {
    try_assign(root, key, value);
    return;
  }
  TomlNode* at = &root;
  for (const auto& part : split_key(std::string_view(key).substr(0, bracket))) {
    const auto it = at->entries.find(part);
    if (it == at->entries.end()) return;
    at = &it->second;
  }
  const auto close = key.find(']', bracket);
  std::size_t i = 0;
  std::from_chars(key.data() + bracket + 1, key.data() + close, i);
  if (i < at->items.size()) assign_default(at->items[i], key.substr(close + 2), value);  // behind "]."
}

// ---------------------------------------------------------------------------------------------------------- printing

namespace {

std::string text_of(const TomlNode& n, bool exact) {
  switch (n.kind) {
    case Kind::boolean:
      return n.flag ? "true" : "false";
    case Kind::integer:
      return fmt::format("{}", n.integer);
    case Kind::real: {
      std::string s = format_number(n.real);
      if (exact && s.find_first_of(".en") == std::string::npos) s += ".0";  // or it reads back as an integer
      return s;
    }
    case Kind::text:
      return in_quotes(n.text);
    case Kind::date:
      return n.text;
    case Kind::array: {
      std::string s = "[";
      for (const auto& x : n.items) s += (s.size() > 1 ? ", " : "") + text_of(x, exact);
      return s + "]";
    }
    case Kind::table: {
      std::string s = "{";
      for (const auto& [k, v] : n.entries) {
        s += fmt::format("{}{} = {}", s.size() > 1 ? ", " : " ", key_text(k), text_of(v, exact));
      }
      return s + (s.size() > 1 ? " }" : "}");
    }
  }
  return {};
}

bool has_header(const TomlNode& n) { return n.is_table() || n.is_tables(); }

/// `header` is the table's own key.
void append_table(std::string& out, const TomlNode& table, const std::string& header) {
  for (const auto& [k, v] : table.entries) {
    if (!has_header(v)) out += toml_line(k, v);
  }
  for (const auto& [k, v] : table.entries) {
    const std::string key = join_key(header, key_text(k));
    if (v.is_table()) {
      const bool only_tables = !v.entries.empty() && std::all_of(v.entries.begin(), v.entries.end(),
                                                                 [](const auto& e) { return has_header(e.second); });
      if (!only_tables) out += fmt::format("\n[{}]\n", key);
      append_table(out, v, key);
    } else if (v.is_tables()) {
      for (const auto& item : v.items) {
        out += fmt::format("\n[[{}]]\n", key);
        for (const auto& [name, value] : item.entries) out += toml_line(name, value);
      }
    }
  }
}

}  // namespace

std::string toml_text(const TomlNode& n) { return text_of(n, true); }

std::string plain_text(const TomlNode& n) { return text_of(n, false); }

std::string toml_line(const std::string& name, const TomlNode& value) {
  return fmt::format("{} = {}\n", key_text(name), toml_text(value));
}

std::string toml_document(const TomlNode& root) {
  std::string out;
  append_table(out, root, "");
  return out;
}

// ------------------------------------------------------------------------------------------------------------ errors

void refuse(const std::string& place, const std::string& key, const std::string& rule) {
  throw InputError(fmt::format("{}: {}: {}", place, key, rule));
}

std::string shown_key(const TomlNode& n, const std::string& key) {
  return has_header(n) ? key : fmt::format("{} = {}", key, shortened(plain_text(n)));
}

void refuse(const TomlNode& n, const std::string& key, const std::string& rule) {
  refuse(n.place, shown_key(n, key), rule);
}

void refuse_kind(const TomlNode& n, const std::string& key, const std::string& rule) {
  if (n.kind == Kind::real) refuse(n.place, fmt::format("{} = {}", key, toml_text(n)), rule);
  refuse(n, key, rule);
}

}  // namespace surveymc::config
