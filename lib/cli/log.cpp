#include "cli/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "cli/screen.h"
#include "store/table.h"

namespace surveymc::cli {
namespace {

/// The text, folded on a terminal so that further lines stand behind the time.
std::string behind_time(const std::string& text) {
  constexpr std::size_t kTime = 9;  // "13:51:09 "
  const std::size_t width = screen_width(STDERR_FILENO);
  return width == 0 ? text : store::folded(std::string(kTime, ' ') + text, width, kTime).substr(kTime);
}

}  // namespace

void start_log() {
  spdlog::set_default_logger(spdlog::stderr_logger_st("surveymc"));
  spdlog::set_pattern("%H:%M:%S %v");
}

void silence_log() { spdlog::set_level(spdlog::level::off); }
void log_only_warnings() { spdlog::set_level(spdlog::level::warn); }

void log_info(const std::string& text) { spdlog::info(behind_time(printable_lines(text))); }
void log_warning(const std::string& text) { spdlog::warn(behind_time(printable_lines(text))); }

}  // namespace surveymc::cli
