#pragma once
/// The formulations of Hanak's memo by name, for one well and one way of drilling it.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "random/stream.h"
#include "survey/reference_field.h"
#include "survey/toolface_plan.h"

namespace surveymc::analysis {

/// Names of all formulations, right and wrong, in the order of the memo.
const std::vector<std::string>& vertical_well_formulations();

/// Of the well and of one run of it.
struct VerticalWellRun {
  std::vector<double> weights;                  ///< m, by vertical_station_weights
  std::vector<double> magnetic_toolfaces;       ///< rad
  std::vector<double> accelerometer_toolfaces;  ///< rad, from the biased accelerometers
  double tilt_sd = 0;                           ///< sigma / G, rad
};

/// The first trial of a plan as the tool sees it: the formulations get their toolfaces from readings.
///   spacing  m, of `legs` equal legs;  bias_sd  m/s2, of ABX and ABY
VerticalWellRun vertical_well_run(int legs, double spacing, const survey::ReferenceField& field, double bias_sd,
                                  const survey::ToolfacePlan& plan, const random::Stream& stream);

/// Predicted covariance (N, E) of the last position, m2. All but `toolface_dependent` only ask which stations of `run`
/// have one toolface, so that any run with drawn toolfaces gives the same. Asserts that the name is known.
Eigen::Matrix2d vertical_well_covariance(const std::string& formulation, const VerticalWellRun& run);

}  // namespace surveymc::analysis
