#pragma once
/// A result as an HDF5 file (docs/results-format.md).
#include <cstdint>
#include <functional>

#include "store/atomic_file.h"
#include "store/result_file.h"

namespace surveymc::store {

/// A malformed result is a bug of the study that made it: std::logic_error.
void check_shape(const Result& result);

/// Writes the whole file, its seal included. Equal results give equal bytes. What is not held is written in pieces.
/// `compression`: level of deflate, 0 for none (large_files.h). `past_cache`: the file is large (PagedFile). `written`
/// is called with the bytes of long values so far. Throws Hdf5Failure, std::system_error of the disk, and the
/// exceptions of streams and of `written`.
void write_hdf5(AtomicFile& file, const Result& result, int compression, bool past_cache,
                const std::function<void(std::uint64_t)>& written);

}  // namespace surveymc::store
