#pragma once
/// Models, readings and truths of chained multistation for the tests.
#include <cmath>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/batch.h"
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
  return {.gravity = m.gravity,
          .horizontal = m.horizontal,
          .down = m.down,
          .first_sd = m.prior_sd,
          .step_sd = m.link_sd,
          .noise = m.noise,
          .attitudes = attitudes};
}

/// The profile of spec and slides: inclination 10 to 45 deg, azimuth 45 deg.
inline std::vector<survey::Attitude> building_profile(int stations) {
  std::vector<survey::Attitude> a;
  for (int k = 0; k < stations; ++k) a.push_back({(10 + 35.0 * k / (stations - 1)) * kDegree, 45 * kDegree, 0});
  return a;
}

/// 18 stations of one direction.
inline std::vector<survey::Attitude> constant(double inclination, double azimuth) {
  return std::vector<survey::Attitude>(18, {inclination * kDegree, azimuth * kDegree, 0});
}

/// Slide 7 with a prior of the axial magnetometer offset that allows a bias.
inline chained::Model loose(double prior, chained::ChainReferences references = chained::ChainReferences::chained) {
  chained::ChainSizes sizes = slide7_sizes();
  sizes.magnetometer_z.offset = prior;
  return chained::make_model(sizes, 18, references);
}

/// Readings of a run that is drawn from the model.
inline chained::Readings drawn_readings(const chained::Model& m, const std::vector<survey::Attitude>& attitudes,
                                        const random::Stream& stream, std::uint64_t trial) {
  return {sensor::simulate_chained_run(run_setup(m, attitudes), stream, trial).readings, {}};
}

/// Runs of so many stations, and their readings side by side.
struct Runs {
  Runs(const sensor::ChainedRunSetup& setup, int count, const random::Stream& stream)
      : batch(count, static_cast<int>(setup.attitudes.size())) {
    for (int t = 0; t < count; ++t) {
      runs.push_back(sensor::simulate_chained_run(setup, stream, static_cast<std::uint64_t>(t)));
      set(t);
    }
  }
  /// Takes the readings of a run as they are now.
  void set(int t) {
    const auto& readings = runs[static_cast<std::size_t>(t)].readings;
    for (std::size_t k = 0; k < readings.size(); ++k) batch.set(t, static_cast<int>(k), readings[k]);
  }

  std::vector<sensor::ChainedRun> runs;
  chained::Batch batch;
};

inline chained::ChainVector vector_of(const chained::ChainArray& c) {
  return Eigen::Map<const chained::ChainVector>(c.data());
}
inline double unit_of_state(int i) { return i == 0 || (i >= 3 && i < 6) ? kMg : 1; }

}  // namespace surveymc::chained_case
