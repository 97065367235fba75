#pragma once
/// A result as an HDF5 file (docs/results-format.md): its writing, and what a file says of itself. read_result() and
/// stored_content_hash() are in result_file.h.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

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

/// Whether the file says that it is a surveymc result, of any format version. `other`: it is something else;
/// `unreadable`: it begins as an HDF5 file does, but cannot be read, for the reason that is given ("is damaged ...").
enum class ResultFile { yes, other, unreadable };
struct ResultFileState {
  ResultFile is = ResultFile::other;
  std::string reason = {};
};
ResultFileState result_file_state(const std::filesystem::path& path);

}  // namespace surveymc::store
