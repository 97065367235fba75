#pragma once
/// One map of a result on standard output. Values are read in pieces: a map need not fit into memory.
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "store/result_file.h"

namespace surveymc::cli {

/// A map and where its values come from.
struct MapSource {
  const store::Map* map;  ///< its values may be empty
  std::function<std::vector<double>(std::size_t first, std::size_t count)> values;
};

/// All maps of a result, held and streamed. They refer to `result`.
std::vector<MapSource> maps_of(const store::Result& result);

/// "61 x 46".
std::string shape_text(const store::Map& map);

void print_map(const MapSource& source);       ///< axes, range, what is infinite or missing
void print_map_csv(const MapSource& source);   ///< one line a value: coordinates, then the value
void print_map_json(const MapSource& source);  ///< an object with the values in one list, the last axis fastest

}  // namespace surveymc::cli
