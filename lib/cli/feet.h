#pragma once
/// Tables in feet, for readers of wells that are measured in feet. Files always hold metres.
#include "store/table.h"

namespace surveymc::cli {

/// The table with lengths in feet and areas in square feet (exactly 0.3048 m): columns with unit m or m2, whose names
/// then end in _ft and _ft2; and in rows whose column `unit` says m or m2, the values "in the row's unit" with their
/// intervals.
store::Table in_feet(store::Table table);

}  // namespace surveymc::cli
