#pragma once
/// Reading of result files; read_result() and stored_content_hash() are in result_file.h.
#include <filesystem>

namespace surveymc::store {

/// True if the file says that it is a surveymc result, of any format version. False if it cannot be read or is damaged.
bool is_result_file(const std::filesystem::path& path);

/// Throws IoError if the contents of a file do not match its content_hash. Its seal is not looked at: it has just been
/// made of the file as it stands.
void require_content(const std::filesystem::path& path);

}  // namespace surveymc::store
