#include "cli/log.h"

#include <unistd.h>

#include <cstdio>
#include <ctime>

#include "cli/screen.h"
#include "render/text.h"

namespace surveymc::cli {
namespace {

enum class Level { info, warning, none };
Level g_least = Level::info;

void print(Level level, const std::string& text) {
  if (level < g_least) return;
  char time[] = "13:51:09 ";
  constexpr std::size_t kTime = sizeof time - 1;
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  std::strftime(time, sizeof time, "%H:%M:%S ", localtime_r(&now, &local));
  const std::size_t width = screen_width(STDERR_FILENO);
  // On a terminal, further lines stand behind the time.
  const std::string lines =
      width == 0 ? printable_lines(text)
                 : render::folded(std::string(kTime, ' ') + printable_lines(text), width, kTime).substr(kTime);
  std::fputs((time + lines + "\n").c_str(), stderr);  // a log that cannot be written (a full disk) does not end a run
}

}  // namespace

void log_only_warnings() { g_least = Level::warning; }
void silence_log() { g_least = Level::none; }

void log_info(const std::string& text) { print(Level::info, text); }
void log_warning(const std::string& text) { print(Level::warning, text); }

}  // namespace surveymc::cli
