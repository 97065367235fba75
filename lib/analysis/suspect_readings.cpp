#include "analysis/suspect_readings.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace surveymc::analysis {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

/// Effect of an error in each of the six readings on the two residuals of its station, per m/s2 and per nT, the
/// accelerometers' errors in the sign of the user's readings.
std::vector<Vector2d> effects_of_readings(const estimate::FieldMisfit& misfit, const survey::Vec3<double>& gravity_T,
                                          double accelerometer_sign) {
  const Eigen::Vector3d g = survey::to_eigen(gravity_T), u = g.normalized();
  const Eigen::Matrix<double, 2, 3> by_gravity = misfit.by_down * (Matrix3d::Identity() - u * u.transpose()) / g.norm();
  std::vector<Vector2d> effects;
  for (int i = 0; i < 3; ++i) effects.push_back(accelerometer_sign * by_gravity.col(i));
  for (int i = 0; i < 3; ++i) effects.push_back(misfit.by_magnetometer.col(i));
  return effects;
}

survey::SixAxisReadings without_station(survey::SixAxisReadings r, int station) {
  r.md.erase(r.md.begin() + station);
  r.gravity_T.erase(r.gravity_T.begin() + station);
  r.magnetic_T.erase(r.magnetic_T.begin() + station);
  return r;
}

}  // namespace

std::optional<Suspect> examine_suspect(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                       const sensor::NoiseModel& noise, const estimate::EstimatorOptions& estimator,
                                       const ReadingsAnalysis& a, const std::vector<ReadingsTest>& tests) {
  const int row = suspect(tests);
  if (row < 0) return std::nullopt;
  Suspect s;
  s.station = static_cast<int>(tests[static_cast<std::size_t>(row)].station);
  const auto k = static_cast<std::size_t>(s.station);
  const std::vector<Vector2d> effects =
      effects_of_readings(a.misfits[k], readings.gravity_T[k], readings.accelerometer_sign);
  constexpr std::array<const char*, 6> names{"gx", "gy", "gz", "bx", "by", "bz"};
  std::vector<std::size_t> order;
  std::vector<estimate::DirectionTest> found;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    found.push_back(estimate::direction_test(a.tests, k, effects[i]));
    if (std::isfinite(found[i].w)) order.push_back(i);  // else no residual sees this reading
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return std::abs(found[i].w) > std::abs(found[j].w); });
  for (const std::size_t i : order) {
    const double r = estimate::direction_correlation(a.tests, k, effects[order.front()], effects[i]);
    s.readings.push_back({names[i], i < 3 ? "m/s2" : "nT", found[i].w, found[i].error, found[i].error_sd, r,
                          std::abs(r) >= kInseparableTests});
  }
  if (readings.size() > 4) try {
      s.without = analyse_readings(without_station(readings, s.station), field, noise, estimator);
    } catch (const InputError&) {  // what is left does not determine the parameters
    }
  return s;
}

}  // namespace surveymc::analysis
