#pragma once
/// A result as the bytes of an HDF5 file (docs/results-format.md), made in memory.
#include <vector>

#include "store/result_file.h"

namespace surveymc {

/// A malformed result is a bug of the study that made it: std::logic_error.
void check_shape(const Result& result);

/// The whole file, without its seal. Equal results give equal bytes. Throws Hdf5Failure.
std::vector<char> file_image(const Result& result);

}  // namespace surveymc
