#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "cli/sweep_pace.h"

namespace surveymc::cli {

/// "3.4 s", "2 min 05 s", "1 h 20 min".
std::string format_duration(double seconds);

/// "[####......]  45.0 % of 3e+03 trials  1.2e+05/s  3.4 s left", with `all` = "3e+03 trials", in at most `width`
/// letters: in a narrow line the bar is short or left out, then the rate.
std::string progress_line(double share, const std::string& all, const std::string& rate, const std::string& left,
                          std::size_t width);

/// How far a run is: a bar with rate and remaining time on a terminal, otherwise one log line a minute. On stderr.
/// Not thread-safe: run_blocks calls it from one thread at a time.
class Progress {
 public:
  /// `kept`: trials that an earlier attempt has done; they tell nothing of the time that the others take.
  /// `what` is counted.
  explicit Progress(std::uint64_t kept = 0, std::string what = "trials");
  ~Progress();  // clears the bar
  Progress(const Progress&) = delete;

  /// From now on the time that is left is that of these points, as long as they are expected to run all of their
  /// trials.
  void know(SweepPace pace) { pace_ = std::move(pace); }
  /// `expected` may change as a stopping rule learns how many trials it needs.
  void update(std::uint64_t done, std::uint64_t expected);
  double elapsed_s() const;

 private:
  bool terminal_, drawn_ = false;
  std::uint64_t kept_;
  std::string what_;
  SweepPace pace_;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace surveymc::cli
