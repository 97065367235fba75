#pragma once
/// A result as an HDF5 file (docs/results-format.md): its writing, and what a file says of itself. read_result() and
/// stored_content_hash() are in result_file.h.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "store/result_file.h"

namespace surveymc::store {

/// A malformed result is a bug of the study that made it: std::logic_error.
void check_shape(const Result& result);

/// What is called with the bytes of values so far. Its exceptions pass through.
using Written = std::function<void(std::uint64_t)>;

/// Writes all but the seal to the file `path`, which is there. Equal results give equal bytes. What is not held is
/// written in pieces. `compression`: level of deflate, 0 for none. Throws Hdf5Failure, and the exceptions of streams.
void write_hdf5(const std::filesystem::path& path, const Result& result, int compression, const Written& written);

/// The bytes of such a file, for a result that is small.
std::string hdf5_bytes(const Result& result, int compression, const Written& written);

/// Whether the file says that it is a surveymc result, of any format version. `other`: it is something else;
/// `unreadable`: it begins as an HDF5 file does, but cannot be read, for the reason that is given ("is damaged ...").
enum class ResultFile { yes, other, unreadable };
struct ResultFileState {
  ResultFile is = ResultFile::other;
  std::string reason = {};
};
ResultFileState result_file_state(const std::filesystem::path& path);

}  // namespace surveymc::store
