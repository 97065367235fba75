#pragma once
/// Final position of a survey whose magnetometers are corrected with estimated gains and biases.
#include <vector>

#include "survey/minimum_curvature.h"
#include "survey/readings.h"

namespace surveymc::survey {

/// For every trial of `readings`: b = (m - bias) / gain per station (thesis eq 16), the direction of the hole from b
/// and gravity, declination to true north, minimum curvature to the last station.
///   parameters  rows gain x, y, z (1), bias x, y, z (nT)
///   md          measured depths, metres
///   position    rows N, E, V in metres, relative to the first station
void corrected_final_positions(const ReadingBlock& readings, const LaneArray& parameters, const std::vector<double>& md,
                               double declination, LaneArray& position);

}  // namespace surveymc::survey
