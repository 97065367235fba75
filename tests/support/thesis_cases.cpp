#include "thesis_cases.h"

#include <fmt/format.h>

#include "base/units.h"
#include "config/survey_csv.h"

namespace surveymc::test {

ThesisCase thesis_case(int number) {
  const std::string path = fmt::format("configs/thesis/traj{}.csv", number);
  ThesisCase c;
  c.number = number;
  c.survey = config::survey_from_table(config::parse_csv(project_file(path), path),
                                       {config::ToolfaceZero::x, config::AzimuthReference::true_north}, true);
  c.field.total = 51000;
  c.field.dip = 72 * kDegree;
  switch (number) {
    case 1:
      c.errors = {{1.10, 0.95, 1.25}, {250, 295, -335}};
      break;
    case 2:
      c.errors = {{1.008, 0.992, 1.008}, {250, -350, 850}};
      break;
    case 3:
      c.errors = {{1, 1, 1}, {250, 295, -335}};
      break;
    default:
      c.errors = {{1, 1, 1.018}, {-70, -54, -811}};
  }
  return c;
}

sensor::CleanReadings clean_readings(const ThesisCase& c) {
  return sensor::clean_readings(c.survey, c.field, c.errors);
}

std::vector<survey::StationFields> station_fields(const ThesisCase& c) {
  const sensor::CleanReadings clean = clean_readings(c);
  std::vector<survey::StationFields> s;
  for (std::size_t k = 0; k < clean.field_T.size(); ++k)
    s.push_back({clean.field_T[k], scale(1 / c.field.gravity, clean.gravity_T[k])});
  return s;
}

Eigen::Matrix<double, 6, 1> true_parameters(const ThesisCase& c) {
  Eigen::Matrix<double, 6, 1> x;
  x << Eigen::Map<const Eigen::Vector3d>(c.errors.gain.data()), Eigen::Map<const Eigen::Vector3d>(c.errors.bias.data());
  return x;
}

survey::ReadingBlock simulated(const ThesisCase& c, const sensor::NoiseModel& noise, int trials,
                               const random::Stream& stream, std::uint64_t first) {
  survey::ReadingBlock block = sensor::make_reading_block(trials, c.survey.size(), noise);
  sensor::simulate_readings(clean_readings(c), c.field, noise, stream, first, block);
  return block;
}

std::vector<survey::Attitude> difficult_attitudes() {
  std::vector<survey::Attitude> all;
  for (const double inclination : {0.0, 1e-8, 1.0, 30.0, 89.9999, 90.0, 120.0, 179.0, 180.0})
    for (const double azimuth : {0.0, 1e-8, 57.0, 90.0, 180.0, 250.0, 270.0, 359.999999, 360.0})
      for (const double toolface : {0.0, 33.0, 90.0, 180.0, 261.0, 359.9999})
        all.push_back({inclination * kDegree, azimuth * kDegree, toolface * kDegree});
  return all;
}

}  // namespace surveymc::test
