#pragma once
/// How long the rest of a sweep takes, whose points cost differently much a trial.
#include <cstdint>
#include <string>
#include <vector>

namespace surveymc::cli {

/// A point of the sweep: its trials, and its value of every key of the sweep, in the order of the keys.
struct PacedPoint {
  std::uint64_t trials = 0;
  std::vector<std::string> values = {};
};

/// Points run one after the other. A point that has run, or runs, tells what its trials cost; one that has not is taken
/// to cost what those do that share most values of the sweep's keys with it: a sweep over estimators and noise knows
/// after the first noise what each estimator costs.
class SweepPace {
 public:
  explicit SweepPace(std::vector<PacedPoint> points = {});
  /// `done` trials in all were done after `elapsed` seconds. Call it often: each point is timed between its calls.
  void note(std::uint64_t done, double elapsed);
  /// Seconds for the trials that were not done at the last note(); NaN while no point was timed, and for more than 1000
  /// points.
  double left() const;
  std::uint64_t trials() const { return ends_.empty() ? 0 : ends_.back(); }

 private:
  struct Timed {
    std::uint64_t from = 0, to = 0;  // trials in all at the first and the last note
    double since = 0, until = 0;     // s
    bool noted = false;
  };
  double seconds_per_trial(std::size_t point) const;  // NaN: not timed
  std::vector<double> expected_per_trial() const;     // of every point; NaN: none is timed

  std::vector<PacedPoint> points_;
  std::vector<std::uint64_t> ends_;  // of each point, in trials of all
  std::vector<Timed> timed_;
  std::uint64_t done_ = 0;
};

}  // namespace surveymc::cli
