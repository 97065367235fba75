#pragma once
/// The values of a config as a tree: dotted keys, setting values, messages about a value, printing. Internal to the
/// module.
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace surveymc::config {

/// A TOML value that remembers where it was written. Own type instead of toml::node, because values move between the
/// file, --set and the sweep and must keep their place, and because the order of keys must be that of the alphabet.
struct TomlNode {
  enum class Kind { boolean, integer, real, text, date, array, table };
  Kind kind = Kind::table;
  bool flag = false;
  std::int64_t integer = 0;
  double real = 0;
  std::string text{};  // of a text or a date
  std::vector<TomlNode> items{};
  std::map<std::string, TomlNode> entries{};
  bool is_inline = false;  // a table written in braces
  std::string place{};     // "thesis.toml:8" or "--set field.dip_deg=95"
  int line = 0;            // 0 if not from the file

  bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
  bool is_text() const { return kind == Kind::text; }
  bool is_table() const { return kind == Kind::table; }
  bool is_array() const { return kind == Kind::array; }
  bool is_tables() const {
    return is_array() && !items.empty() &&
           std::all_of(items.begin(), items.end(), [](const TomlNode& x) { return x.is_table(); });
  }
  double as_double() const { return kind == Kind::integer ? static_cast<double>(integer) : real; }
  /// The value of one key of a table; null if there is none.
  const TomlNode* entry(const std::string& key) const {
    const auto it = entries.find(key);
    return it == entries.end() ? nullptr : &it->second;
  }
};

TomlNode node_of(bool x);
TomlNode node_of(std::int64_t x);
TomlNode node_of(double x);
TomlNode node_of(const std::string& x);
TomlNode node_of(const std::vector<double>& x);

// ---- keys

/// How deep tables and lists may stand inside each other, and the rule in messages.
inline constexpr std::size_t kDeepestNesting = 256;
inline constexpr const char* kTooDeep = "tables and lists must be nested at most 256 deep";

/// A name that needs no quotes in TOML. Only such names can be asked for.
bool is_bare_key(std::string_view name);
/// A name as TOML: with quotes if it needs them.
std::string key_text(const std::string& name);
/// "path.key"; `key` if the path is empty.
std::string join_key(const std::string& path, const std::string& key);
std::vector<std::string> split_key(std::string_view key);
/// The key as "a.b.c" if it is a dotted key that a reader can ask for ("a . b" is, "a..b" is not, nor is one of more
/// than kDeepestNesting parts).
std::optional<std::string> clean_key(std::string_view key);
/// Why clean_key() gives nothing, for the end of a message.
std::string no_key_rule(std::string_view key);

// ---- setting values

/// Puts `value` at a dotted key and makes the tables on the way. A string on the way, or a string put onto a table, is
/// that table's name. Throws InputError if something else is in the way.
void assign(TomlNode& root, const std::string& key, const TomlNode& value);
/// The same for the default of a key that may hold indices ("published[1].note"). Does nothing if the way is blocked.
void assign_default(TomlNode& root, const std::string& key, const TomlNode& value);

// ---- printing

/// TOML that reads back to the same kind and the same bits.
std::string toml_text(const TomlNode& n);
/// For people: 51000, not 51000.0.
std::string plain_text(const TomlNode& n);
/// One line of a table.
std::string toml_line(const std::string& name, const TomlNode& value);
/// A whole document. Keys in alphabetical order: first the values of a table, then its sub-tables.
std::string toml_document(const TomlNode& root);

// ---- errors: InputError "place: key = value: rule"

[[noreturn]] void refuse(const std::string& place, const std::string& key, const std::string& rule);
/// "key = value", or only the key of a table.
std::string shown_key(const TomlNode& n, const std::string& key);
/// Shows the value, unless it is a table.
[[noreturn]] void refuse(const TomlNode& n, const std::string& key, const std::string& rule);
/// The kind is wrong, so show it: 10000.0 is not an integer, 10000 would be.
[[noreturn]] void refuse_kind(const TomlNode& n, const std::string& key, const std::string& rule);

/// TOML text as a tree, strictly: NaN and infinity are errors wherever they stand. Throws InputError "label:line:
/// rule".
TomlNode parse_document(const std::string& text, const std::string& label);

/// The value of a --set argument: TOML, or else a bare word. Throws InputError "place: key: rule".
TomlNode parse_value(const std::string& value, const std::string& key, const std::string& place);

}  // namespace surveymc::config
