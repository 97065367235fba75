#pragma once
/// The program's log on stderr: a line with the time of day before each text. The library never logs.
#include <string>

namespace surveymc::cli {

// No function of this header is thread-safe.

/// Drops what is not a warning from now on.
void log_only_warnings();
/// Drops everything from now on: for ranks other than 0.
void silence_log();

void log_info(const std::string& text);
void log_warning(const std::string& text);

}  // namespace surveymc::cli
