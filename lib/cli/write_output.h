#pragma once
/// Writes a result file as the arguments ask.
#include <filesystem>
#include <vector>

#include "cli/run_arguments.h"
#include "store/result_file.h"

namespace surveymc::cli {

/// Writes the result as the arguments ask (store/result_file.h). Returns the new names of older
/// results.
std::vector<std::filesystem::path> write_result_file(const RunArguments& a, const std::filesystem::path& path,
                                                     const store::Result& result);

/// Prints the new names of older results.
void print_backup(const std::vector<std::filesystem::path>& kept);

}  // namespace surveymc::cli
