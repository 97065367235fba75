#include "cli/screen.h"
#include "render/csv.h"
#include "render/text.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace surveymc::cli {
namespace {

template <class Change>
std::string each_line(const std::string& text, Change change) {
  std::string out;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find('\n', begin);
    out += change(text.substr(begin, end - begin));
    if (end == std::string::npos) return out;
    out += '\n';
    begin = end + 1;
  }
}

bool is_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  return error != std::errc::invalid_argument && end == text.data() + text.size();
}

/// Tabs and carriage returns in front are skipped by some spreadsheets.
std::string no_formula(const std::string& text) {
  const bool is_formula = text.size() > 1 && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
  return is_formula && !is_number(text) ? "'" + text : text;
}

}  // namespace

std::size_t screen_width(int descriptor) {
  constexpr std::size_t kUsual = 80;  // a terminal that does not say
  if (isatty(descriptor) == 0) return 0;
  winsize size{};
  if (ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
  return std::max<std::size_t>(kNarrowestScreen, size.ws_col);
}

render::TableFormat screen_format() {
  const std::size_t width = screen_width(STDOUT_FILENO);
  if (width == 0) return {.split = true};
  return {.width = width, .split = true, .fold = true};
}

std::string on_screen(const std::string& text, int descriptor, std::size_t indent) {
  const std::size_t width = screen_width(descriptor);
  return width == 0 ? text : render::folded(text, width, indent);
}

std::string counted(std::size_t n, const char* word) { return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s"); }

std::string printable_lines(const std::string& text) { return each_line(text, render::printable); }

std::string printable_toml(const std::string& text) { return each_line(text, render::escaped_controls); }

void print_lines(const std::string& text) { fmt::print("{}", printable_lines(text)); }

void print_csv(const store::Table& table, bool with_header) {
  const auto print = [&](store::Table piece) {
    for (store::Column& c : piece.columns) {
      c.name = no_formula(c.name);
      if (auto* texts = std::get_if<std::vector<std::string>>(&c.values))
        for (std::string& text : *texts) text = no_formula(text);
    }
    const std::string text = render::to_csv(piece);
    fmt::print("{}", with_header ? text : text.substr(text.find('\n') + 1));
    with_header = false;
  };
  if (table.rows() == 0)
    print(table);
  else
    store::for_each_piece(table, [&](const store::Table& piece, std::size_t) { print(piece); });
}

}  // namespace surveymc::cli
