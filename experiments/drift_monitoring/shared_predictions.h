#pragma once
/// Predictions that several points of a sweep have in common are computed once.
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "monitoring/gas_lift_well.h"
#include "monitoring/kalman.h"
#include "monitoring/monitor.h"
#include "monitoring/samples.h"
#include "random/study_id.h"

namespace surveymc::studies::drift_monitoring {

/// Of all tested samples of a realisation, by architecture.
using Predictions = std::vector<monitoring::Samples>;

/// All that the predictions of a simulated well depend on.
struct PredictionInput {
  struct Drift {
    std::vector<double> amplitude;  ///< z, of every sensor
    double start_h, test_end_h;
    auto operator<=>(const Drift&) const = default;
  };
  random::StudySeed seed;
  monitoring::InjectionSchedule schedule;
  double sample_s, noise_to_signal;
  Eigen::Index rows, train, memory_vectors;
  double bandwidth;
  monitoring::DriftFilterOptions filter;
  std::vector<monitoring::Architecture> architectures;
  std::optional<Drift> drift;  ///< none: readings without drift
  auto operator<=>(const PredictionInput&) const = default;
};

/// Predictions by realisation for all points of this process that compute the same. They take at most kMostBytes in
/// all; what finds no place is computed again. Which point comes first changes nothing, as all would compute the same
/// bits.
class SharedPredictions {
 public:
  /// One object for equal inputs, as long as anyone holds it.
  static std::shared_ptr<SharedPredictions> of(const PredictionInput& input);
  ~SharedPredictions();

  /// More than one point has asked for them.
  bool are_shared() const;
  /// Null: not there.
  std::shared_ptr<const Predictions> find(std::uint64_t trial) const;
  void keep(std::uint64_t trial, Predictions predictions);

  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

 private:
  mutable std::mutex mutex_;
  int points_ = 0;
  std::size_t bytes_ = 0;
  std::map<std::uint64_t, std::shared_ptr<const Predictions>> by_trial_;
};

}  // namespace surveymc::studies::drift_monitoring
