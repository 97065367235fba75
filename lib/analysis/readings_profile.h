#pragma once
/// Intervals of a run of readings that hold where the estimate does not move in proportion to the errors of its inputs.
///
/// Readings without errors give the truth, so that the truth is what the readings less their errors give: with F(z) the
/// change of a result by further errors with the normals z, the truth is the result plus F(-z). Quantiles of F are
/// those of its profile (orders/profile.h) about the readings as they are: exact along the direction of the errors that
/// moves the result most, to first order in all others. Where that direction is all that matters and the result rises
/// or falls with it, the interval holds the truth with exactly its probability, however bent the path is.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "analysis/readings_analysis.h"

namespace surveymc::analysis {

/// An end of an interval counts as another one where it moves by more than this share of the first-order half width.
inline constexpr double kNotableShift = 0.05;

/// A parameter (gain: 1, bias: nT) or a coordinate of the last station (m), at one confidence.
struct ProfiledInterval {
  std::string quantity = {};             ///< "gain_x", "bias_z_nT", "north_m", "east_m", "vertical_m"
  double estimate = 0, sd = 0;           ///< to first order
  double first_low = 0, first_high = 0;  ///< estimate -+ the normal's quantile times sd
  double profile_sd = 0;                 ///< NaN, as the ends, where the profile has no value
  double profile_low = 0, profile_high = 0;
  double jump_probability = 0;  ///< of errors beyond which the estimate is another minimum's

  /// The larger shift of an end, in first-order half widths; 0 where neither has an extent.
  double shift() const;
  bool is_determined() const { return !std::isnan(profile_low) && !std::isnan(profile_high); }
  bool is_notable() const { return is_determined() && shift() > kNotableShift; }
};

/// Gains and biases, then the last station. Nothing where the estimator is no fit of all six parameters to the field,
/// or has priors of them: the errors of the tools that priors speak of are no errors of readings. Nothing for runs of
/// more than 2000 stations, either: memory is 241 readings of each.
std::vector<ProfiledInterval> profile_readings(const survey::SixAxisReadings& readings,
                                               const survey::ReferenceField& field, const sensor::NoiseModel& noise,
                                               const estimate::EstimatorOptions& estimator,
                                               const ReadingsAnalysis& analysis, double confidence);

}  // namespace surveymc::analysis
