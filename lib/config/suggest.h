#pragma once
/// Suggestions for unknown keys and names.
#include <set>
#include <string>

namespace surveymc::config {

/// Units are the ending of a key: `total_nT`.
enum class UnitFault { none, missing, unknown, unwanted };

/// What is wrong with the unit of the name `given` if `known` is meant.
UnitFault unit_fault(const std::string& given, const std::string& known);
std::string describe(UnitFault fault);

/// True if two words differ by few typing errors for their length: one, two from six letters on, three from nine.
bool resembles(const std::string& a, const std::string& b);

/// Why `name` (in the table `path`) is not a key, with the nearest of the known full keys.
std::string unknown_key_rule(const std::string& path, const std::string& name, const std::set<std::string>& known);

}  // namespace surveymc::config
