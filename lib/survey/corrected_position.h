#pragma once
/// Final position of a survey whose magnetometers are corrected with estimated gains and biases.
#include <vector>

#include "survey/minimum_curvature.h"
#include "survey/readings.h"
#include "survey/survey.h"

namespace surveymc::survey {

/// For every trial of `readings`: b = (m - bias) / gain per station (thesis eq 16), the direction of the hole from b
/// and gravity, declination to true north, minimum curvature to the last station.
///   parameters  rows gain x, y, z (1), bias x, y, z (nT)
///   md          measured depths, metres
///   position    rows N, E, V in metres, relative to the first station
void corrected_final_positions(const ReadingBlock& readings, const LaneArray& parameters, const std::vector<double>& md,
                               double declination, LaneArray& position);

/// A survey whose first station is a tie-on: it is not measured, and the readings are those of the stations after it.
struct TiedSurvey {
  std::vector<double> md;              ///< m, of all stations
  std::vector<Vec3<double>> tangents;  ///< the true ones of all stations, magnetic north
  std::vector<Vec3<double>> right;     ///< unit vectors across the hole at the measured stations, level, magnetic north
  double declination = 0;              ///< rad
  /// The tie-on has the error of the first measured station: D_1 / 2 (t_1 - t_1 true) is added to the position.
  bool first_leg_doubled = false;
};
TiedSurvey tied_survey(const Survey& survey, double declination, bool first_leg_doubled);

/// For every trial of `readings` the corrected directions of the hole, as above, and from them
///   position  rows N, E, V of the last station in metres, relative to the tie-on, true north
///   lateral   row k: component of the direction of measured station k to the right of the true hole; sinI times the
///             error of the azimuth, which is finite in a vertical hole
void corrected_tied_positions(const ReadingBlock& readings, const LaneArray& parameters, const TiedSurvey& survey,
                              LaneArray& position, LaneArray& lateral);

}  // namespace surveymc::survey
