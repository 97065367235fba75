#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace surveymc {

/// "3.4 s", "2 min 05 s", "1 h 20 min".
std::string format_duration(double seconds);

/// How far a run is: a bar with rate and remaining time on a terminal, otherwise one log line a minute. On stderr.
/// Not thread-safe: run_blocks calls it from one thread at a time.
class Progress {
 public:
  explicit Progress(std::uint64_t total);
  ~Progress();  // clears the bar
  Progress(const Progress&) = delete;

  void update(std::uint64_t done);
  double elapsed_s() const;

 private:
  std::uint64_t total_;
  bool terminal_, drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace surveymc
