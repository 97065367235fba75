#include "reliability/observations.h"

#include <algorithm>
#include <stdexcept>

namespace surveymc::reliability {

const std::array<std::string, kObservations>& observation_names() {
  static const std::array<std::string, kObservations> names{"gx", "gy",      "gz",          "bx", "by",
                                                            "bz", "gravity", "total_field", "dip"};
  return names;
}

const std::string& observation_unit(std::size_t observation) {
  static const std::array<std::string, 3> units{"mps2", "nT", "deg"};
  return units[observation < kReadings ? observation / 3 : observation - kReadings];
}

double observation_scale(std::size_t observation) {
  return observation == index_of(Observation::dip) ? 1 / kDegree : 1;
}

double relative_unit(std::size_t observation, const survey::ReferenceField& field) {
  if (observation == index_of(Observation::dip)) return 1;
  return observation < 3 || observation == index_of(Observation::gravity) ? field.gravity : field.total;
}

const std::vector<std::string>& adjustment_mode_names() {
  static const std::vector<std::string> names{"sse", "sse_axial", "mse_fixed", "mse_shared"};
  return names;
}

AdjustmentMode adjustment_mode(const std::string& name) {
  const auto& names = adjustment_mode_names();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) throw std::out_of_range("no adjustment mode " + name);
  return static_cast<AdjustmentMode>(at - names.begin());
}

bool is_observed(AdjustmentMode mode, std::size_t observation) {
  if (mode == AdjustmentMode::sse_axial) return observation != index_of(Observation::bz);
  return mode != AdjustmentMode::mse_fixed || observation < kReadings;
}

std::vector<std::size_t> observed(AdjustmentMode mode) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < kObservations; ++i)
    if (is_observed(mode, i)) all.push_back(i);
  return all;
}

Observations true_observations(const survey::Attitude& at, const survey::ReferenceField& field) {
  const survey::Vec3<double> g = scale(field.gravity, survey::down_T(at)),
                             b = survey::magnetic_T(at, field.total, field.dip);
  return {g.x, g.y, g.z, b.x, b.y, b.z, field.gravity, field.total, field.dip};
}

VarianceParts variance_parts(const SigmaModel& s, std::size_t reading, double y) {
  const bool accelerometer = reading < 3;
  const double bias = accelerometer ? s.accelerometer_bias : s.magnetometer_bias,
               scale = (accelerometer ? s.accelerometer_scale : s.magnetometer_scale) * y,
               noise = accelerometer ? s.accelerometer_noise : s.magnetometer_noise,
               axial = reading == index_of(Observation::bz) ? s.axial_interference : 0;
  return {bias * bias + axial * axial + scale * scale, noise * noise};
}

Observations observation_variances(const AdjustmentModel& model, const Observations& y) {
  const bool single = model.mode == AdjustmentMode::sse || model.mode == AdjustmentMode::sse_axial;
  Observations v{};
  for (std::size_t i = 0; i < kReadings; ++i) {
    const VarianceParts parts = variance_parts(model.sigma, i, y[i]);
    v[i] = parts.noise + (single ? parts.systematic : 0);
  }
  if (model.mode == AdjustmentMode::mse_fixed) return v;
  const SigmaModel& s = model.sigma;
  v[6] = s.gravity * s.gravity;
  v[7] = s.total_field * s.total_field;
  v[8] = s.dip * s.dip;
  return v;
}

}  // namespace surveymc::reliability
