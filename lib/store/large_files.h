#pragma once
/// What large result files are written and read with; result_file.h has the plain ways.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "store/atomic_file.h"
#include "store/result_file.h"

namespace surveymc::store {

inline constexpr int kMostCompression = 9;

struct WriteOptions {
  /// 1 to 9: the numbers of tables and maps (from 1024 on) are in compressed chunks, by HDF5's shuffle and deflate.
  /// Contents and content_hash are the same. Texts are not compressed: HDF5 keeps them outside of what its filters see.
  /// 0: none.
  int compression = 0;
  /// Called while a large result is written, with the bytes that are on their way to the disk and about all that there
  /// will be without compression. What it throws leaves no file.
  std::function<void(std::uint64_t written, std::uint64_t expected)> progress = {};
  OldFile old = OldFile::replaced;  ///< an older result of the same name
};
/// As write_result of result_file.h. Returns the new names of older results. Throws IoError also if the HDF5 library
/// has no deflate.
std::vector<std::filesystem::path> write_result(const std::filesystem::path& path, const Result& result,
                                                const WriteOptions& options);

/// As read_result, but looks neither at the seal nor at the content_hash: of a long table or a large map no more is
/// read than is asked for afterwards. Damage is then found only where HDF5 notices it.
Result read_unchecked_result(const std::filesystem::path& path);

}  // namespace surveymc::store
