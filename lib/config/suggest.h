#pragma once
/// Suggestions for unknown keys and names.
#include <set>
#include <string>
#include <vector>

namespace surveymc::config {

/// Units are the ending of a key: `total_nT`.
enum class UnitFault { none, missing, unknown, unwanted };

/// What is wrong with the unit of the name `given` if `known` is meant.
UnitFault unit_fault(const std::string& given, const std::string& known);
std::string describe(UnitFault fault);

/// True if two words differ by few typing errors for their length: one, two from six letters on, three from nine. Small
/// and capital letters are the same.
bool resembles(const std::string& a, const std::string& b);

/// What may be meant by `word`, "a" or "a or b": the names with the fewest typing errors, of those that resemble it;
/// else those that begin with it, if they are few. "" if there is none.
std::string nearest(const std::string& word, const std::vector<std::string>& names);

/// The end of a message that refuses `word`: `; did you mean "a"?`, or "".
std::string suggestion(const std::string& word, const std::vector<std::string>& names);

/// `"smal" is none of small, large; did you mean "small"?`
std::string none_of(const std::string& word, const std::vector<std::string>& names);

/// Why `name` (in the table `path`) is not a key, with the nearest of the known full keys.
std::string unknown_key_rule(const std::string& path, const std::string& name, const std::set<std::string>& known);

}  // namespace surveymc::config
