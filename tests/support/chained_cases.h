#pragma once
/// Models, readings and truths of chained multistation for the tests.
#include <cmath>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/linearised_station.h"
#include "chained_case.h"
#include "sensor/chained_runs.h"

namespace surveymc::chained_case {

inline constexpr double kMg = 9.80665e-3;  // m/s2

/// Slide 7: B 50000 nT, dip 75 deg.
inline chained::ChainSizes slide7_sizes() {
  chained::ChainSizes s;
  s.accelerometer_xy = s.accelerometer_z = {0.3 * kMg, 0.2 * kMg};
  s.magnetometer_xy = {80, 50};
  s.magnetometer_z = {80, 80};
  s.gravity = {0.1 * kMg, 0.02 * kMg};
  s.field = {80, 20};
  s.horizontal = kReference[1];
  s.down = kReference[2];
  return s;
}
inline chained::Model slide7(chained::ChainReferences references = chained::ChainReferences::chained) {
  return chained::make_model(slide7_sizes(), 18, references);
}

inline chained::Readings case_readings() {
  chained::Readings r;
  for (const auto& y : kReadings) r.y.push_back({y[0] * kMg, y[1] * kMg, y[2] * kMg, y[3], y[4], y[5]});
  return r;
}

inline sensor::ChainedRunSetup run_setup(const chained::Model& m, const std::vector<survey::Attitude>& attitudes) {
  sensor::ChainedRunSetup s;
  s.gravity = m.gravity;
  s.horizontal = m.horizontal;
  s.down = m.down;
  s.first_sd = m.prior_sd;
  s.step_sd = m.link_sd;
  s.noise = m.noise;
  s.attitudes = attitudes;
  return s;
}

/// The profile of spec and slides: inclination 10 to 45 deg, azimuth 45 deg.
inline std::vector<survey::Attitude> building_profile(int stations) {
  std::vector<survey::Attitude> a;
  for (int k = 0; k < stations; ++k) a.push_back({(10 + 35.0 * k / (stations - 1)) * kDegree, 45 * kDegree, 0});
  return a;
}

inline chained::ChainVector vector_of(const chained::ChainArray& c) {
  return Eigen::Map<const chained::ChainVector>(c.data());
}
inline double unit_of_state(int i) { return i == 0 || (i >= 3 && i < 6) ? kMg : 1; }

}  // namespace surveymc::chained_case
