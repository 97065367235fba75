#pragma once
/// One point of a config as its readers see it: its values, and which keys were asked for. Internal to the module.
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/config_document.h"
#include "config/config_value.h"
#include "config/toml_tree.h"

namespace surveymc::config {

struct ConfigReader::Point {
  std::shared_ptr<ConfigDocument> doc;
  std::size_t index = 0;
  TomlNode root;
  std::set<std::string> asked;                   // full keys
  std::set<std::string> whole;                   // tables whose every entry was read
  std::set<std::string> arrays;                  // arrays of tables that were taken apart
  std::map<std::string, std::string> unmatched;  // elements that are for other points, and the key that says so
  std::map<std::string, TomlNode> defaults;      // by full key
  std::shared_ptr<Mistakes> mistakes;            // null: the first one ends the reading

  struct UnknownKey {
    const TomlNode* node;
    std::string key, rule;
  };

  /// The value of a dotted key in `table`, whose full key is `path`. Does not make it known.
  ConfigValue look_up(const TomlNode& table, const std::string& path, const std::string& key) const;
  /// True if a key inside the table or array `key` was asked for.
  bool asked_below(const std::string& key) const;
  /// Keys below `at`, whose full key is `at_key`, that nobody asked for.
  void find_unknown(const TomlNode& at, const std::string& at_key, std::vector<UnknownKey>& out) const;
  /// True if the point has the values in `expected`, the value of the full key `where`
  /// (ConfigReader::matches_point()). `name`: the dotted key of `expected` inside it.
  bool has_values(const std::string& where, const TomlNode& expected, const std::string& name = "") const;

 private:
  bool has_value(const std::string& where, const std::string& name, const TomlNode& expected) const;
  /// The point's value of a full key, or the default that was read for it. Null if there is neither.
  const TomlNode* value_or_default(const std::string& key) const;
  bool is_for_other_point(const std::string& element) const;
};

}  // namespace surveymc::config
