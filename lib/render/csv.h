#pragma once
#include <string>

#include "store/table.h"

namespace surveymc::render {

/// RFC 4180 text, but with lines that end in LF: names in the first line, numbers with the fewest digits that read back
/// to the same bits, NaN as an empty cell.
std::string to_csv(const store::Table& table);

}  // namespace surveymc::render
