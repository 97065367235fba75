#pragma once
/// Wells, fields, tools and noise of every kind, for what must hold everywhere.
#include <cmath>
#include <random>

#include <Eigen/Core>

#include "base/units.h"
#include "sensor/magnetometer.h"
#include "stats/moments.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::test {

struct RandomRun {
  survey::Survey survey;
  survey::ReferenceField field;
  sensor::MagnetometerErrors errors;
  sensor::NoiseModel noise;
};

/// A run by its number, always the same: 5 to 30 stations that build and turn enough to determine six parameters, gains
/// from 0.85 to 1.2: farther from 1, where solvers start, many estimates end in another minimum. `scale` multiplies the
/// noise: 20 to 80 nT, 0 to 0.003 m/s2, reference 107 nT and 0.16 deg; trials in antithetic pairs.
inline RandomRun random_run(int number, double scale) {
  std::minstd_rand engine(static_cast<unsigned>(number) + 1);
  engine.discard(10);
  const auto uniform = [&engine](double from, double to) {  // the same bits by every standard library
    return from + (to - from) * static_cast<double>(engine() - engine.min()) / static_cast<double>(engine.max());
  };
  RandomRun r;
  const int stations = 5 + static_cast<int>(uniform(0, 26));
  survey::Station s{0, uniform(5, 40) * kDegree, uniform(0, 360) * kDegree, 0};
  const double build = uniform(1, 4) * kDegree, turn = uniform(-4, 4) * kDegree;
  for (int k = 0; k < stations; ++k) {
    s.toolface = uniform(0, 360) * kDegree;
    r.survey.stations.push_back(s);
    s.md += uniform(20, 40);
    s.inclination = std::min(s.inclination + build, 100 * kDegree);
    s.azimuth += turn;
  }
  r.field = {.gravity = 9.81,
             .total = uniform(30000, 60000),
             .dip = uniform(-80, 80) * kDegree,
             .declination = uniform(-20, 20) * kDegree,
             .convergence = 0};
  for (std::size_t i = 0; i < 3; ++i) {
    r.errors.gain[i] = uniform(0.85, 1.2);
    r.errors.bias[i] = uniform(-500, 500);
  }
  r.noise.antithetic = true;
  r.noise.magnetometer = scale * uniform(20, 80);
  r.noise.accelerometer = number % 3 == 0 ? 0 : scale * uniform(0, 0.003);
  r.noise.reference = number % 5 == 0   ? sensor::ReferenceNoise::none
                      : number % 2 == 0 ? sensor::ReferenceNoise::per_run
                                        : sensor::ReferenceNoise::per_station;
  r.noise.reference_total = scale * 107;
  r.noise.reference_dip = scale * 0.16 * kDegree;
  return r;
}

/// sd of `errors` over a predicted one. The variance of `sums` of the same draws is known exactly: what chance does to
/// both is taken out. Of antithetic pairs also what is odd in the draws: only squares of the second order are left.
inline double controlled_ratio(const Eigen::VectorXd& errors, const Eigen::VectorXd& sums, double variance_of_sums,
                               double predicted_variance) {
  Eigen::MatrixXd both(errors.size(), 2);
  both << errors, sums;
  const stats::Moments m = stats::Moments::of(both);
  return std::sqrt((variance_of_sums + m.variance(0) - m.variance(1)) / predicted_variance);
}

}  // namespace surveymc::test
