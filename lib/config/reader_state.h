#pragma once
/// What a ConfigReader works on: one point, one table inside it, and which keys were asked for. Internal to the module.
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/config_document.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// One point as its readers see it.
struct ConfigPoint {
  std::shared_ptr<ConfigDocument> doc;
  std::size_t index = 0;
  TomlNode root;
  std::set<std::string> asked;                   // full keys
  std::set<std::string> whole;                   // tables whose every entry was read
  std::set<std::string> arrays;                  // arrays of tables that were taken apart
  std::map<std::string, std::string> unmatched;  // elements that are for other points, and the key that says so
  std::map<std::string, TomlNode> defaults;

  /// True if a key inside the table or array `key` was asked for.
  bool asked_below(const std::string& key) const;
};

/// Keys are relative to `table`; full keys begin with `path`.
struct ConfigReader::State {
  std::shared_ptr<ConfigPoint> point;
  const TomlNode* table = nullptr;  // in point->root
  std::string path;                 // "published[1]", or empty at the root

  struct Found {
    const TomlNode* node = nullptr;
    std::string key;                        // for messages; of a name given as a string, the key of that string
    const TomlNode* not_a_table = nullptr;  // what stands at `key`, where a table is needed; `node` is null then
    explicit operator bool() const { return node != nullptr; }
  };

  struct UnknownKey {
    const TomlNode* node;
    std::string key, rule;
  };

  std::string full_key(const std::string& key) const { return join_key(path, key); }
  /// For messages about keys that are absent: the line of an element of an array of tables, else the file.
  const std::string& place() const { return path.empty() ? point->doc->label : table->place; }

  /// The value of a key. Does not make it known.
  Found look_up(const std::string& key) const;
  /// The value of a key, which is known from now on. Nothing if it is absent.
  Found find(const std::string& key);
  /// Throws InputError if the key is absent.
  Found need(const std::string& key);
  /// The same, but if the key is absent and has a fallback: nothing, and the fallback is remembered. `is_value`: see
  /// use_default().
  template <class T>
  Found need_or(const std::string& key, const std::optional<T>& fallback, bool is_value) {
    if (!fallback) return need(key);
    const Found found = find(key);
    if (!found) use_default(key, node_of(*fallback), is_value);
    return found;
  }
  /// For a string: if its table is written out, `[estimator] name = ...` asked for as `estimator`, the name, which is
  /// known from now on.
  Found its_name(const Found& found);
  /// The name if `found` is a table with a name, else `found`.
  static Found name_or_self(const Found& found);

  /// Tells the log, if there is one, what a getter asks for. `rule`: without "must be". `sample`: a value that it
  /// takes.
  void log_use(const std::string& key, const std::string& type, const std::string& rule = "",
               const std::string& sample = "") const;
  bool has_log() const { return point->doc->log != nullptr; }
  void log_choices(const std::string& key, const std::vector<std::string>& allowed) const;
  /// Before log_use(): a use without it is that of a key that must be there.
  void log_default(const std::string& key, const TomlNode& value, bool is_value) const;
  /// The same, if there is a fallback.
  template <class T>
  void log_fallback(const std::string& key, const std::optional<T>& fallback, bool is_value) const {
    if (has_log() && fallback) log_default(key, node_of(*fallback), is_value);
  }

  /// Remembers a default. `is_value`: false if the getter's rule would refuse it.
  void use_default(const std::string& key, const TomlNode& value, bool is_value);

  /// True if the point has the values in `table`, the value of the full key `where` (see matches_point()).
  /// `name`: the dotted key of `table` inside it.
  bool entries_match(const std::string& where, const TomlNode& table, const std::string& name) const;

  /// Keys below `at`, whose full key is `at_key`, that nobody asked for.
  void find_unknown(const TomlNode& at, const std::string& at_key, std::vector<UnknownKey>& out) const;

 private:
  [[noreturn]] void refuse_missing(const std::string& key) const;
  /// The point's value of a full key, or the default that was read for it. Null if there is neither.
  const TomlNode* value_or_default(const std::string& key) const;
  bool entry_matches(const std::string& where, const std::string& name, const TomlNode& expected) const;
  bool is_for_other_point(const std::string& element) const;
};

}  // namespace surveymc::config
