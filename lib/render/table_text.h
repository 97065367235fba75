#pragma once
/// Tables as aligned text for a terminal.
#include <cstddef>
#include <limits>
#include <string>

#include "store/table.h"

namespace surveymc::render {

/// The first and the last `count` rows together, as a table that is held.
store::Table first_and_last(const store::Table& table, std::size_t count);

/// How format_table() lays a table out.
struct TableFormat {
  std::size_t width = 160;  ///< letters in a line, if the table can be made as narrow
  bool split = false;       ///< columns that do not fit go to blocks below, which repeat the columns that name the row
  bool fold = false;        ///< title and notes are folded at the width
  std::size_t most_rows =
      std::numeric_limits<std::size_t>::max();  ///< the first and the last so many, if there are more
  std::size_t left_out = 0;                     ///< rows that are missing behind the first half: first_and_last()
};

/// Aligned text for a terminal: a title line, column names with units, one line a row. Numbers have 6 significant
/// digits, NaN is "-". Columns without any value are left out; x_ci_low and x_ci_high become one column "interval"
/// behind x; `verdict` and `expected` stand behind the columns that name the row, and a verdict that is not the
/// `expected` one is marked "(!)". If the rows get too wide, counts and margins that are the same in all rows go to a
/// line of their own and sentences become footnotes, but for those that name the row. In a split table, names that take
/// more than half of the width stand in lines of their own above the rows that have them.
/// The table must be held.
std::string format_table(const store::Table& table, const TableFormat& format = {});

}  // namespace surveymc::render
