#pragma once
/// What large result files are written and read with; result_file.h has the plain ways.
#include <filesystem>

#include "store/result_file.h"

namespace surveymc::store {

inline constexpr int kMostCompression = 9;

/// As write_result, with the numbers of tables and maps (from 1024 on) in compressed chunks: HDF5's shuffle and deflate
/// at `level`, 1 to 9. Contents and content_hash are those of write_result. Texts are not compressed: HDF5 keeps them
/// outside of what its filters see. Throws IoError also if the HDF5 library has no deflate.
void write_compressed_result(const std::filesystem::path& path, const Result& result, int level);

/// As read_result, but looks neither at the seal nor at the content_hash: of a long table or a large map no more is
/// read than is asked for afterwards. Damage is then found only where HDF5 notices it.
Result read_unchecked_result(const std::filesystem::path& path);

}  // namespace surveymc::store
