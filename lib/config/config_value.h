#pragma once
/// A value of a config beside its key, and the checks that getters share. Internal to the module.
#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// False for NaN and infinity, too.
bool is_in(const Range& range, double x);

/// "must be in [0, 90]".
std::string rule_of(const Range& range);

/// { from, to, step } as a function of the number of a value: never empty, strictly monotone, both ends included when
/// they fit. If from and step are decimals of few digits, so is every value, exactly rounded: the third value of 0,
/// 0.1, ... is 0.3 and not 0.30000000000000004, so it equals a published `at` and prints well.
struct Steps {
  double from = 0, to = 0, step = 0;
  double decimals = 0;  ///< a power of ten that makes integers of from and step; 0 if there is none
  std::uint64_t count = 0;
  bool ends_at_to = false;

  double value(std::uint64_t i) const;
  /// All values; at most kMostListed.
  std::vector<double> values() const;
};
/// More values in a list than this are a typing error in `step`, and would fill the memory.
inline constexpr double kMostListed = 1e7;

/// True for a table that is meant to be { from, to, step }, or another range.
bool is_steps(const TomlNode& n);

/// The value at a key. Every check throws InputError "place: key = value: rule".
struct ConfigValue {
  const TomlNode* node = nullptr;
  std::string key;          ///< the full key, for messages; of a name written as a string, the key of that string
  bool is_blocked = false;  ///< `node` stands above the key, where a table is needed: the key is absent

  explicit operator bool() const { return node != nullptr && !is_blocked; }
  [[noreturn]] void fail(const std::string& rule) const { refuse(*node, key, rule); }
  /// The same for a value of the wrong type.
  [[noreturn]] void fail_type(const std::string& rule) const { refuse_kind(*node, key, rule); }

  double number(const Range& range) const;
  /// Of the items of a list.
  std::vector<double> numbers(const Range& range) const;
  /// Of a table { from, to, step }. `most`: so many values are allowed.
  Steps steps(const Range& range, double most = kMostListed) const;
  /// The item `i` of a list, and the entry `name` of a table, which must be there.
  ConfigValue item(std::size_t i) const;
  ConfigValue entry(const std::string& name) const;
};

}  // namespace surveymc::config
