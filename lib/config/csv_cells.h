#pragma once
/// Cells of a line of a user's CSV file. Internal to the module.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace surveymc::config {

/// Splits a line into cells. Quotes must be around whole cells, and doubled inside; any others would change a number.
/// Throws InputError "place: rule".
std::vector<std::string> split_cells(std::string_view line, const std::string& place);

/// True for a blank line or a comment, which begins with #. A first cell such as #N/A or #REF! is no comment:
/// spreadsheets write it for a missing value, and its row must not vanish.
bool is_no_row(std::string_view line);

/// True for a row of empty cells, as spreadsheets write.
template <class Cell>
bool is_empty_row(const std::vector<Cell>& cells) {
  return std::all_of(cells.begin(), cells.end(), [](const Cell& cell) { return cell.empty(); });
}

/// True for a cell that another program would take for several.
inline bool has_other_separator(std::string_view cell) { return cell.find_first_of(";\t") != std::string_view::npos; }
inline constexpr const char* kDecimalHint = "decimal points and commas between cells are required";

/// Removes empty cells behind the first `width`: spreadsheets write them where another row is longer.
template <class Cell>
void remove_empty_end(std::vector<Cell>& cells, std::size_t width) {
  while (cells.size() > width && cells.back().empty()) cells.pop_back();
}

}  // namespace surveymc::config
