#pragma once
/// Reading of result files; read_result() and stored_content_hash() are in result_file.h.
#include <filesystem>
#include <string>

namespace surveymc::store {

/// Whether the file says that it is a surveymc result, of any format version. `other`: it is something else;
/// `unreadable`: it begins as an HDF5 file does, but cannot be read, for the reason that is given ("is damaged ...").
enum class ResultFile { yes, other, unreadable };
struct ResultFileState {
  ResultFile is = ResultFile::other;
  std::string reason = {};
};
ResultFileState result_file_state(const std::filesystem::path& path);

}  // namespace surveymc::store
