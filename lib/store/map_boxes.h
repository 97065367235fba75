#pragma once
/// Values that lie together in a map, as the boxes of its dimensions that HDF5 wants.
#include <algorithm>
#include <vector>

#include <hdf5.h>

namespace surveymc::store {

struct Box {
  hsize_t first, size;  ///< values first .. first + size - 1 of the map, the last axis fastest
  std::vector<hsize_t> start, count;
};

/// Values first .. first + count - 1 in few boxes, in order: each is a run along one axis, whole in the axes behind it.
inline std::vector<Box> boxes_in(const std::vector<hsize_t>& shape, hsize_t first, hsize_t count) {
  std::vector<Box> boxes;
  for (const hsize_t end = first + count; first < end;) {
    std::size_t axis = shape.size();  // the run is along shape[axis - 1]
    hsize_t inner = 1;
    while (axis > 1 && first % (inner * shape[axis - 1]) == 0 && first + inner * shape[axis - 1] <= end) {
      inner *= shape[--axis];
    }
    const hsize_t along = shape[axis - 1], n = std::min((end - first) / inner, along - first / inner % along);
    Box b{first, n * inner, std::vector<hsize_t>(shape.size(), 0), shape};
    hsize_t rest = first / inner;
    for (std::size_t d = axis; d-- > 0;) {
      b.start[d] = rest % shape[d];
      b.count[d] = 1;
      rest /= shape[d];
    }
    b.count[axis - 1] = n;
    first += b.size;
    boxes.push_back(std::move(b));
  }
  return boxes;
}

}  // namespace surveymc::store
