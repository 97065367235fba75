#pragma once
/// Simulated readings with gross errors, and their tests: trials of the study `gross_error_detection`.
///
/// Every observation of an adjustment is its true value, plus its standard deviation times a draw, plus its gross
/// error. Systematic terms that the model has as unknowns are drawn from their priors, once a trial.
#include <cstdint>
#include <vector>

#include "random/stream.h"
#include "reliability/adjustment.h"
#include "reliability/redundancy_model.h"
#include "reliability/shots_lanes.h"
#include "survey/readings.h"

namespace surveymc::reliability {

/// `number` is that of observation_number(); `size` in internal units.
struct GrossError {
  Eigen::Index number = 0;
  double size = 0;
};

/// Results of the tests of one trial.
struct TrialTests {
  bool converged = false;
  Eigen::VectorXd w;  ///< of all observations; 0 where there is no test
  double omega = 0;
  double largest = 0;                  ///< |w|
  std::vector<Eigen::Index> suspects;  ///< the observation of the largest test and those that are tied with it
};

class GrossErrorTrials {
 public:
  /// Throws std::invalid_argument where a model of one station gets several attitudes.
  GrossErrorTrials(const AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes,
                   const std::vector<GrossError>& errors, const random::Stream& stream);

  /// One station, and no systematic terms: simulate() may be used, with trials side by side.
  bool on_lanes() const;
  /// Two to kMostShots stations with shared references, and no systematic terms: simulate_shots() may be used.
  bool shots_on_lanes() const;
  /// Readings of a trial, with or without the gross errors.
  StationReadings readings(std::uint64_t trial, bool with_errors) const;
  /// The same of given normals, one an observation.
  StationReadings readings(const Eigen::VectorXd& normals, bool with_errors) const;
  /// How many observations the adjustment has, and their standard deviations in internal units.
  int observations() const { return static_cast<int>(variances_.size()); }
  Eigen::VectorXd standard_deviations() const { return variances_.cwiseSqrt(); }
  /// Error-free readings, plus the gross errors.
  StationReadings readings_without_noise(bool with_errors) const;
  /// The general adjustment of such readings, which defines the result.
  StationAdjustment adjusted(const StationReadings& y) const { return adjust(model_, y, variances_); }

  /// Tests of trials first .. first + 8 `groups` - 1, without and with errors; kTestRows rows (gross_error_lanes.h).
  /// Trials that do not converge on lanes are adjusted one by one, by adjusted().
  void simulate(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with, int groups) const;
  /// Tests of one trial of such a block; the same as those of adjusted(readings(...)) to rounding.
  static TrialTests tests_of(const survey::LaneArray& block, int trial);

  /// The same of several stations, with ShotsRows::tests() and all() rows (shots_lanes.h). Trials that do not converge
  /// on lanes are marked so: the caller adjusts them by adjusted().
  void simulate_shots(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with, int groups) const;
  /// The same as the kernel sees it.
  ShotsBatch shots_batch(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with, int groups) const;
  ShotsRows shots_rows() const;
  bool converged_shots(const survey::LaneArray& block, int trial) const {
    return block.value(trial, shots_rows().converged()) != 0;
  }
  /// Tests of one trial, without the suspects.
  TrialTests tests_of_shots(const survey::LaneArray& block, int trial) const;
  /// The linear model of one trial with errors.
  void model_of_shots(const survey::LaneArray& with, int trial, RedundancyModel& model) const;

  static TrialTests tests_of(const StationAdjustment& adjustment);

  const AdjustmentModel& model() const { return model_; }
  const std::vector<survey::Attitude>& attitudes() const { return attitudes_; }
  const std::vector<GrossError>& errors() const { return errors_; }

 private:
  static void put(const TrialTests& tests, int trial, survey::LaneArray& block);
  StationReadings readings_of(const Eigen::VectorXd& noise, bool with_errors) const;
  ShotsModel shots_model() const;

  AdjustmentModel model_;
  std::vector<survey::Attitude> attitudes_;
  std::vector<GrossError> errors_;
  random::Stream stream_;
  std::vector<std::array<double, kReadings>> truth_;
  Eigen::VectorXd variances_;
};

}  // namespace surveymc::reliability
