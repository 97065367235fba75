#include "estimate/field_misfit.h"

#include <cmath>

namespace surveymc::estimate {

using Eigen::Vector3d;

FieldMisfit field_misfit(const survey::StationFields& station, const std::array<double, 3>& gain, double total,
                         double dip) {
  const Vector3d per_gain(1 / gain[0], 1 / gain[1], 1 / gain[2]);
  const Vector3d b = survey::to_eigen(station.field_T);
  const auto [north, east, down, bh, bv] = survey::field_frame(station);
  Eigen::Matrix<double, 2, 3> by_field;
  by_field.row(0) = north;
  by_field.row(1) = down;

  FieldMisfit m;
  m.residual << bh - total * std::cos(dip), bv - total * std::sin(dip);
  // b = (m - bias) / gain: db_i/dgain_i = -b_i / gain_i, db_i/dbias_i = -1 / gain_i
  m.by_parameters << -by_field * b.cwiseProduct(per_gain).asDiagonal(), -by_field * per_gain.asDiagonal();
  m.by_magnetometer = by_field * per_gain.asDiagonal();
  // Along du perpendicular to u, with n the first row: dBh = n.d(b - (u.b) u) = -Bv n.du, dBv = b.du
  m.by_down.row(0) = -bv * by_field.row(0);
  m.by_down.row(1) = b;
  m.by_reference << -std::cos(dip), total * std::sin(dip), -std::sin(dip), -total * std::cos(dip);
  return m;
}

std::vector<FieldMisfit> field_misfits(const std::vector<survey::StationFields>& stations,
                                       const std::array<double, 3>& gain, double total, double dip) {
  std::vector<FieldMisfit> all;
  for (const survey::StationFields& s : stations) all.push_back(field_misfit(s, gain, total, dip));
  return all;
}

survey::Vec3<double> corrected_field(const survey::Vec3<double>& m, const std::array<double, 3>& gain,
                                     const std::array<double, 3>& bias) {
  return {(m.x - bias[0]) / gain[0], (m.y - bias[1]) / gain[1], (m.z - bias[2]) / gain[2]};
}

Eigen::Matrix<double, Eigen::Dynamic, 6> misfit_jacobian(const std::vector<FieldMisfit>& misfits) {
  Eigen::Matrix<double, Eigen::Dynamic, 6> j(static_cast<Eigen::Index>(2 * misfits.size()), 6);
  for (std::size_t k = 0; k < misfits.size(); ++k)
    j.middleRows<2>(static_cast<Eigen::Index>(2 * k)) = misfits[k].by_parameters;
  return j;
}

}  // namespace surveymc::estimate
