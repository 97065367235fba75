#include "cli/progress.h"

#include "cli/log.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace surveymc::cli {

std::string format_duration(double seconds) {
  const auto s = static_cast<long long>(seconds + 0.5);
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
}

Progress::Progress() : terminal_(isatty(STDERR_FILENO) != 0), start_(std::chrono::steady_clock::now()), last_(start_) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::update(std::uint64_t done, std::uint64_t expected) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < std::chrono::duration<double>(terminal_ ? 0.2 : 60.0) || done == 0) return;
  last_ = now;
  const double elapsed = elapsed_s(), rate = static_cast<double>(done) / elapsed;
  const double left = static_cast<double>(expected - done) / rate,
               share = static_cast<double>(done) / static_cast<double>(expected);
  const std::string words = fmt::format("{:5.1f} % of {:.3g} trials  {:.3g}/s  {} left", 100 * share,
                                        static_cast<double>(expected), rate, format_duration(left));
  if (!terminal_) {
    log_info(words);
    return;
  }
  constexpr int kWidth = 30;
  const int full = static_cast<int>(share * kWidth);
  fmt::print(stderr, "\r[{}{}] {}\033[K", std::string(static_cast<std::size_t>(full), '#'),
             std::string(static_cast<std::size_t>(kWidth - full), '.'), words);
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace surveymc::cli
