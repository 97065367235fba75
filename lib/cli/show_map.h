#pragma once
/// One map of a result on standard output. Values are read in pieces: a map need not fit into memory.
#include <string>

#include "store/result_file.h"

namespace surveymc::cli {

/// "61 x 46".
std::string shape_text(const store::Map& map);

void print_map(const store::MapSource& source);       ///< axes, range, what is infinite or missing
void print_map_csv(const store::MapSource& source);   ///< one line a value: coordinates, then the value
void print_map_json(const store::MapSource& source);  ///< an object with the values in one list, the last axis fastest

}  // namespace surveymc::cli
