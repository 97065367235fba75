#pragma once
/// A result as the bytes of an HDF5 file (docs/results-format.md), made in memory or, with streamed maps, on the disk.
#include <filesystem>
#include <vector>

#include "store/result_file.h"

namespace surveymc::store {

/// A malformed result is a bug of the study that made it: std::logic_error.
void check_shape(const Result& result);

/// The whole file, without its seal. Equal results give equal bytes. Throws Hdf5Failure.
std::vector<char> file_image(const Result& result);

/// The same file, whose streamed maps are never held as a whole, in place of the one at `path`. Throws Hdf5Failure, and
/// whatever the streams throw; the file then is not whole.
void write_file(const std::filesystem::path& path, const Result& result);

}  // namespace surveymc::store
