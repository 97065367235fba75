#pragma once
/// Reading of result files; read_result() and stored_content_hash() are in result_file.h.
#include <filesystem>

namespace surveymc::store {

/// True if the file says that it is a surveymc result, of any format version. False if it cannot be read or is damaged.
bool is_result_file(const std::filesystem::path& path);

}  // namespace surveymc::store
