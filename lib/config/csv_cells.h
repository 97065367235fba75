#pragma once
/// Cells of a line of a user's CSV file. Internal to the module.
#include <string>
#include <string_view>
#include <vector>

namespace surveymc::config {

/// Quotes are around whole cells, and doubled inside; any others would make a number that is not what the file says.
/// Throws InputError "place: rule".
std::vector<std::string> split_cells(std::string_view line, const std::string& place);

}  // namespace surveymc::config
