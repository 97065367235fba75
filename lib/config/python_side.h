#pragma once
/// The commands of surveymc that are written in Python: plot, report, import, studies (scripts/surveymc).
#include <string>
#include <vector>

namespace surveymc::config {

/// The words that start such a command: a Python, the folder of the Python side, and `words`, of which the first is the
/// command. The Python is that of the environment variable SURVEYMC_PYTHON, else /usr/bin/python3, else the first
/// python3 in PATH; it hands over to another one where it lacks packages. Throws IoError, with a way out, where the
/// folder is not beside the program or there is no Python.
std::vector<std::string> python_command(const std::vector<std::string>& words);

/// The path of this program.
std::string own_path();

}  // namespace surveymc::config
