#pragma once
/// Values that follow each other in a map, as boxes of its dimensions, which HDF5 needs.
#include <algorithm>
#include <string>
#include <vector>

#include "store/hdf5_handle.h"

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

/// Calls use(memory, space, offset) for each box of values first .. first + count - 1 of a dataset; in their list it
/// begins at `offset`. `memory` and `space` are HDF5's selections of it.
template <class Use>
void in_boxes(hid_t dataset, const std::string& link, hsize_t first, hsize_t count, const Use& use) {
  const Handle space(H5Dget_space(dataset), "read the shape of", link);
  std::vector<hsize_t> shape(
      static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "read the shape of", link)));
  if (shape.empty()) return use(H5S_ALL, H5S_ALL, 0);
  checked(H5Sget_simple_extent_dims(space, shape.data(), nullptr), "read the shape of", link);
  for (const Box& box : boxes_in(shape, first, count)) {
    const Handle memory(H5Screate_simple(static_cast<int>(box.count.size()), box.count.data(), nullptr),
                        "make a dataspace");
    checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, box.start.data(), nullptr, box.count.data(), nullptr),
            "select a part of", link);
    use(memory, space, static_cast<std::size_t>(box.first - first));
  }
}

}  // namespace surveymc::store
