#pragma once
/// A result as the bytes of an HDF5 file (docs/results-format.md), made in memory or, with streamed maps, on the disk.
#include <filesystem>
#include <memory>
#include <span>

#include "store/result_file.h"

namespace surveymc::store {

/// A malformed result is a bug of the study that made it: std::logic_error.
void check_shape(const Result& result);

/// A file in memory: that of HDF5 itself, as a copy would take as long again. `owner` keeps it.
struct FileImage {
  std::shared_ptr<const void> owner;
  std::span<const char> bytes;
};

/// The whole file, without its seal. Equal results give equal bytes. `compression`: level of deflate, 0 for none
/// (large_files.h). Throws Hdf5Failure.
FileImage file_image(const Result& result, int compression = 0);

/// Writes the same file in place of the one at `path`, without holding a streamed map as a whole. Throws Hdf5Failure,
/// and the exceptions of the streams; the file then is not whole.
void write_file(const std::filesystem::path& path, const Result& result, int compression = 0);

}  // namespace surveymc::store
