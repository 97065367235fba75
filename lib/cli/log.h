#pragma once
/// The program's log on stderr: a line with the time of day before each text. The library never logs.
#include <string>

namespace surveymc::cli {

/// Call before the first line. No function of this header is thread-safe.
void start_log();
/// Turns the log off, for ranks other than 0.
void silence_log();
/// Only warnings from now on.
void log_only_warnings();

void log_info(const std::string& text);
void log_warning(const std::string& text);

}  // namespace surveymc::cli
