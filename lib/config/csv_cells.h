#pragma once
/// Cells of a line of a user's CSV file. Internal to the module.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace surveymc::config {

/// Quotes are around whole cells, and doubled inside; any others would make a number that is not what the file says.
/// Throws InputError "place: rule".
std::vector<std::string> split_cells(std::string_view line, const std::string& place);

/// Blank, or a comment: its first character is #. A first cell such as #N/A or #REF! is no comment but what a
/// spreadsheet writes for a value that it does not have: its row must not vanish.
bool is_no_row(std::string_view line);

/// A row of empty cells, as spreadsheets write between others.
template <class Cell>
bool is_empty_row(const std::vector<Cell>& cells) {
  return std::all_of(cells.begin(), cells.end(), [](const Cell& cell) { return cell.empty(); });
}

/// A text in one cell that another program takes for several.
inline bool has_other_separator(std::string_view cell) { return cell.find_first_of(";\t") != std::string_view::npos; }
inline constexpr const char* kDecimalHint = "decimal points and commas between cells are required";

/// Takes off the empty cells behind `width` others: spreadsheets write them where another row is longer.
template <class Cell>
void remove_empty_end(std::vector<Cell>& cells, std::size_t width) {
  while (cells.size() > width && cells.back().empty()) cells.pop_back();
}

}  // namespace surveymc::config
