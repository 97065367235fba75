#pragma once
#include <string>

namespace surveymc::test {

/// Whole text of a file of the project; path relative to its root.
std::string project_file(const std::string& path);
std::string project_path(const std::string& path);

}  // namespace surveymc::test
