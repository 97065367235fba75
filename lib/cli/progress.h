#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace surveymc::cli {

/// "3.4 s", "2 min 05 s", "1 h 20 min".
std::string format_duration(double seconds);

/// How far a run is: a bar with rate and remaining time on a terminal, otherwise one log line a minute. On stderr.
/// Not thread-safe: run_blocks calls it from one thread at a time.
class Progress {
 public:
  Progress();
  ~Progress();  // clears the bar
  Progress(const Progress&) = delete;

  /// `expected` may change as a stopping rule learns how many trials it needs.
  void update(std::uint64_t done, std::uint64_t expected);
  double elapsed_s() const;

 private:
  bool terminal_, drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace surveymc::cli
