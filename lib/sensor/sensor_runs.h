#pragma once
/// Runs of a tool whose sensor errors are constant in a run: draws -> readings -> directions -> positions, for a batch
/// of trials, without keeping the readings.
#include <cstdint>
#include <functional>
#include <vector>

#include "random/stream.h"
#include "survey/position_method.h"
#include "survey/readings.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"
#include "survey/toolface_plan.h"

namespace surveymc::sensor {

/// All of a run but chance. `gravity_H` (m/s2) and `field_H` (nT) are what a perfect tool at toolface 0 reads: frame H
/// is the tool's with y towards the high side.
struct SensorRunSetup {
  std::vector<survey::Vec3<double>> gravity_H, field_H;
  std::vector<double> md;  ///< metres
  double declination = 0;  ///< rad
  survey::PositionMethod method = survey::PositionMethod::minimum_curvature;
  survey::SensorTermArray sd{};  ///< one standard deviation of each error, normal and independent
  survey::ToolfacePlan plan;
  std::vector<int> reported;  ///< stations whose position is wanted, ascending
  /// The first station is a tie-on: its direction is known, the tool does not measure it. Else it is measured as the
  /// others are, and its errors move the half interval that follows it.
  bool first_is_tie_on = false;

  int stations() const { return static_cast<int>(md.size()); }
};
SensorRunSetup sensor_run_setup(const survey::Survey& survey, const survey::ReferenceField& field,
                                const survey::SensorTermArray& sd, const survey::ToolfacePlan& plan,
                                survey::PositionMethod method, const std::vector<int>& reported);

/// A batch of runs. Reuse it from batch to batch.
struct SensorRuns {
  SensorRuns(int trial_count, const SensorRunSetup& setup);

  int trials;
  survey::LaneArray errors;    ///< rows as in sensor_terms.h
  survey::LaneArray toolface;  ///< rows 2 k + {0 cos, 1 sin} of station k; one shared group when no toolface is drawn
  survey::LaneArray
      positions;  ///< rows 3 i + {N, E, V}: metres from the first station, at reported station i, true north
};

/// Draws errors and toolfaces of trials first_trial, first_trial + 1, ... first_trial is a multiple of kGroup.
void draw_runs(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial, SensorRuns& runs);

/// Fills runs.positions from runs.errors and runs.toolface: the full nonlinear chain.
void run_positions(const SensorRunSetup& setup, SensorRuns& runs);

/// Runs trials first_trial .. first_trial + count - 1 in batches that fit the caches and calls `use` on each batch,
/// with the number of its first trial. first_trial is a multiple of kGroup. The batches change no bit of a trial.
void for_each_batch(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial, int count,
                    const std::function<void(std::uint64_t, const SensorRuns&)>& use);

/// The toolfaces of one trial in rad, [0, 2 pi) where drawn, as given elsewhere.
std::vector<double> toolfaces_of_trial(const survey::ToolfacePlan& plan, const random::Stream& stream,
                                       std::uint64_t trial);

}  // namespace surveymc::sensor
