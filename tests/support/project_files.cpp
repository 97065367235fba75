#include "project_files.h"

#include <fstream>
#include <sstream>

namespace surveymc::test {

std::string project_path(const std::string& path) { return std::string(SURVEYMC_SOURCE_DIR "/") + path; }

std::string project_file(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(project_path(path)).rdbuf();
  return text.str();
}

}  // namespace surveymc::test
