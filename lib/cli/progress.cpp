#include "cli/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

#include "base/units.h"
#include "cli/log.h"
#include "cli/screen.h"

namespace surveymc::cli {

std::string format_duration(double seconds) {
  const auto s = static_cast<long long>(seconds + 0.5);
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
}

std::string progress_line(double share, const std::string& all, const std::string& rate, const std::string& left,
                          std::size_t width) {
  constexpr std::size_t kLongestBar = 30, kShortestBar = 5, kBrackets = 3;
  const std::string head = fmt::format("{:5.1f} %", 100 * share);
  std::string words = head + (left.empty() ? "" : fmt::format("  {} left", left));
  const std::string whole = fmt::format("{} of {}  {}/s{}", head, all, rate, words.substr(head.size()));
  if (whole.size() <= width) words = whole;
  if (words.size() + kBrackets + kShortestBar > width) return words.substr(0, width);
  const std::size_t bar = std::min(kLongestBar, width - words.size() - kBrackets),
                    full = std::min(bar, static_cast<std::size_t>(share * static_cast<double>(bar)));
  return fmt::format("[{}{}] {}", std::string(full, '#'), std::string(bar - full, '.'), words);
}

Progress::Progress(std::uint64_t kept, std::string what)
    : terminal_(isatty(STDERR_FILENO) != 0),
      kept_(kept),
      what_(std::move(what)),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::update(std::uint64_t done, std::uint64_t expected) {
  const auto now = std::chrono::steady_clock::now();
  pace_.note(done, elapsed_s());
  if (now - last_ < std::chrono::duration<double>(terminal_ ? 0.2 : 60.0) || done == 0 || expected == 0) return;
  last_ = now;
  const std::uint64_t own = done > kept_ ? done - kept_ : 0, rest = expected > done ? expected - done : 0;
  const double rate = static_cast<double>(own) / elapsed_s(),
               share = std::min(1.0, static_cast<double>(done) / static_cast<double>(expected));
  double seconds = expected == pace_.trials() ? pace_.left() : kNaN;
  if (std::isnan(seconds) && own > 0) seconds = static_cast<double>(rest) / rate;
  const std::string all = fmt::format("{:.3g} {}", static_cast<double>(expected), what_),
                    speed = fmt::format("{:.3g}", rate), left = std::isnan(seconds) ? "" : format_duration(seconds);
  if (!terminal_) {
    log_info(
        fmt::format("{:5.1f} % of {}  {}/s{}", 100 * share, all, speed, left.empty() ? "" : "  " + left + " left"));
    return;
  }
  // The last column stays free: a terminal may go to the next line when it is written.
  fmt::print(stderr, "\r{}\033[K", progress_line(share, all, speed, left, screen_width(STDERR_FILENO) - 1));
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace surveymc::cli
