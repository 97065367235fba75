#pragma once
/// Numbers out of config values, checked against a Range, and { from, to, step } lists. Internal to the module.
/// `key` is the full key of the value, for messages. All throw InputError "place: key = value: rule".
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

/// True for a table that is meant to be { from, to, step }.
bool is_steps(const TomlNode& n);
/// Values of { from, to, step }: never empty, strictly monotone, both ends included when they fit.
/// If from and step are decimals of few digits, so is every value, exactly rounded: the third value of 0, 0.1, ... is
/// 0.3 and not 0.30000000000000004, so it equals a published `at` and prints well.
std::vector<double> expand_steps(const TomlNode& n, const std::string& key, const Range& range);

}  // namespace surveymc::config
