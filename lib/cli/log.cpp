#include "cli/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace surveymc::cli {

void start_log() {
  spdlog::set_default_logger(spdlog::stderr_logger_st("surveymc"));
  spdlog::set_pattern("%H:%M:%S %v");
}

void silence_log() { spdlog::set_level(spdlog::level::off); }
void log_only_warnings() { spdlog::set_level(spdlog::level::warn); }

void log_info(const std::string& text) { spdlog::info(text); }
void log_warning(const std::string& text) { spdlog::warn(text); }

}  // namespace surveymc::cli
