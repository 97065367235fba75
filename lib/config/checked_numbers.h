#pragma once
/// Numbers out of config values, checked against a Range, and { from, to, step } lists. Internal to the module.
/// `key` is the full key of the value, for messages. All throw InputError "place: key = value: rule".
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

double checked_number(const TomlNode& n, const std::string& key, const Range& range);
/// Of the items of an array.
std::vector<double> checked_numbers(const TomlNode& n, const std::string& key, const Range& range);

/// True for a table that is meant to be { from, to, step }, or another range.
bool is_steps(const TomlNode& n);
/// { from, to, step } as a function of the number of a value: never empty, strictly monotone, both ends included when
/// they fit. If from and step are decimals of few digits, so is every value, exactly rounded: the third value of 0,
/// 0.1, ... is 0.3 and not 0.30000000000000004, so it equals a published `at` and prints well.
struct Steps {
  double from = 0, to = 0, step = 0;
  double decimals = 0;  ///< a power of ten that makes integers of from and step; 0 if there is none
  std::uint64_t count = 0;
  bool ends_at_to = false;

  double value(std::uint64_t i) const;
};
/// `most`: values that are allowed.
Steps steps_of(const TomlNode& n, const std::string& key, const Range& range, double most);
/// All values of steps_of(), 1e7 at most.
std::vector<double> expand_steps(const TomlNode& n, const std::string& key, const Range& range);

}  // namespace surveymc::config
