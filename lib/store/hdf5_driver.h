#pragma once
/// HDF5's files in a PagedFile, so that every byte of a result is written by us.
#include <cstdint>
#include <exception>
#include <functional>
#include <utility>

#include "store/hdf5_handle.h"
#include "store/paged_file.h"

namespace surveymc::store {

/// What HDF5 writes to, and the first error of the disk. After an error HDF5 is told no other one: it can close its
/// file, which it could not if its last records found no place (and would crash at the end of the program, 1.10.8).
struct DriverTarget {
  DriverTarget(AtomicFile& file, bool past_cache, std::function<void(std::uint64_t)> written)
      : pages(file, past_cache, std::move(written)) {}

  PagedFile pages;
  std::uint64_t allocated = 0;  ///< bytes of the file, with those that nothing was written to
  std::exception_ptr error = {};
};

/// Properties of a file that is made in `target`, which must live until it is closed.
Handle access_to(DriverTarget& target);

}  // namespace surveymc::store
