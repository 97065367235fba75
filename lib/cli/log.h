#pragma once
/// The program's log on stderr: a line with the time of day before each text. The library never logs.
#include <string>

namespace surveymc::cli {

/// Before the first line; not thread-safe, as all of this.
void start_log();
/// Nothing more is said: for ranks other than 0.
void silence_log();

void log_info(const std::string& text);
void log_warning(const std::string& text);

}  // namespace surveymc::cli
