#pragma once
/// The four test trajectories of the thesis (Vis 2019, tables 12-15) with the true errors of our configs.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "project_files.h"
#include "random/stream.h"
#include "sensor/magnetometer.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::test {

struct ThesisCase {
  int number;
  survey::Survey survey;
  survey::ReferenceField field;
  sensor::MagnetometerErrors errors;
};

/// number: 1 .. 4. Trajectories are read from configs/thesis.
ThesisCase thesis_case(int number);

/// The case's readings without noise.
sensor::CleanReadings clean_readings(const ThesisCase& c);

/// Field and down direction of every station, as linearisations take them.
std::vector<survey::StationFields> station_fields(const ThesisCase& c);

/// Gains and biases (nT) of its tool.
Eigen::Matrix<double, 6, 1> true_parameters(const ThesisCase& c);

/// Readings of `trials` trials from `first` on, a multiple of simd::kGroup.
survey::ReadingBlock simulated(const ThesisCase& c, const sensor::NoiseModel& noise, int trials,
                               const random::Stream& stream, std::uint64_t first = 0);

/// Attitudes worth trying: every combination of easy, tiny, right-angled and wrapped-round angles, in radians.
std::vector<survey::Attitude> difficult_attitudes();

}  // namespace surveymc::test
