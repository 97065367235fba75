#include "cli/screen.h"

#include <algorithm>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace surveymc::cli {

std::size_t screen_width(int descriptor) {
  constexpr std::size_t kUsual = 80;  // a terminal that does not say
  if (isatty(descriptor) == 0) return 0;
  winsize size{};
  if (ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
  return std::max<std::size_t>(kNarrowestScreen, size.ws_col);
}

store::TableFormat screen_format() {
  const std::size_t width = screen_width(STDOUT_FILENO);
  if (width == 0) return {.split = true};
  return {.width = width, .split = true, .fold = true};
}

std::string on_screen(const std::string& text, int descriptor, std::size_t indent) {
  const std::size_t width = screen_width(descriptor);
  return width == 0 ? text : store::folded(text, width, indent);
}

std::string counted(std::size_t n, const char* word) { return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s"); }

std::string printable_lines(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find('\n', begin);
    out += store::printable(text.substr(begin, end - begin));
    if (end == std::string::npos) return out;
    out += '\n';
    begin = end + 1;
  }
}

}  // namespace surveymc::cli
