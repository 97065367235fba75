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

/// All inputs of a run except the random draws. `gravity_H` (m/s2) and `field_H` (nT) are the readings of a perfect
/// tool at toolface 0: frame H is the tool's with y towards the high side.
struct SensorRunSetup {
  std::vector<survey::Vec3<double>> gravity_H, field_H;
  std::vector<double> md;  ///< metres
  double declination = 0;  ///< rad
  survey::PositionMethod method = survey::PositionMethod::minimum_curvature;
  survey::SensorTermArray sd{};  ///< one standard deviation of each error, normal and independent
  survey::ToolfacePlan plan;
  std::vector<int> reported;  ///< stations whose position is wanted, ascending
  /// True: the first station is a tie-on, whose direction is known and not measured by the tool. False: the tool
  /// measures it as the other stations, and its errors move half of the interval that follows.
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
/// with the number of its first trial. first_trial is a multiple of kGroup. The bits of a trial do not depend on
/// batches.
void for_each_batch(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial, int count,
                    const std::function<void(std::uint64_t, const SensorRuns&)>& use);

/// The group of kGroup runs that holds one trial, drawn and run through; the trial is lane trial % kGroup.
SensorRuns runs_around(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t trial);

/// The toolfaces of one trial in rad: in [0, 2 pi) at stations where they are drawn, as given at the others.
std::vector<double> toolfaces_of_trial(const survey::ToolfacePlan& plan, const random::Stream& stream,
                                       std::uint64_t trial);

}  // namespace surveymc::sensor
