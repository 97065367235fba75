#include "propagate/station_effects.h"

#include "propagate/error_sum.h"
#include "survey/minimum_curvature.h"

namespace surveymc::propagate {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TangentDerivatives tangent_derivatives(const survey::StationFields& station) {
  const auto [n, e, u, bh, bv] = survey::field_frame(station);
  TangentDerivatives d;
  // db turns north about down by -(e.db) / Bh: dn = e (e.db) / Bh, de = -n (e.db) / Bh.
  const Vector3d turn(e.z(), -n.z(), 0);
  d.by_field = turn * e.transpose() / bh;
  // du tilts n and e towards u, and turns north by the field's vertical part: dn = -(n.du) u - (Bv/Bh)(e.du) e.
  d.by_down.row(0) = -u.z() * n.transpose() - bv / bh * e.z() * e.transpose();
  d.by_down.row(1) = -u.z() * e.transpose() + bv / bh * n.z() * e.transpose();
  d.by_down.row(2) = Vector3d::UnitZ().transpose();
  return d;
}

std::vector<StationEffect> final_position_effects(const std::vector<double>& md,
                                                  const std::vector<survey::StationFields>& stations,
                                                  double declination) {
  const Matrix3d to_true = survey::true_from_magnetic(declination);
  std::vector<survey::Vec3<double>> tangents;
  for (const survey::StationFields& s : stations)
    tangents.push_back(
        survey::from_eigen(to_true * survey::to_eigen(survey::tangent_from_fields(s.down_T, s.field_T))));
  const std::vector<Matrix3d> by_tangent = survey::final_position_by_tangent(md, tangents);
  std::vector<StationEffect> effects;
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const TangentDerivatives d = tangent_derivatives(stations[k]);
    effects.push_back({by_tangent[k] * to_true * d.by_field, by_tangent[k] * to_true * d.by_down});
  }
  return effects;
}

Matrix36d magnetometer_error_effect(const StationEffect& effect, const survey::StationFields& station,
                                    const std::array<double, 3>& gain) {
  const Vector3d per_gain(1 / gain[0], 1 / gain[1], 1 / gain[2]);
  Matrix36d x;
  x.leftCols<3>() = -effect.by_field * survey::to_eigen(station.field_T).cwiseProduct(per_gain).asDiagonal();
  x.rightCols<3>() = -effect.by_field * per_gain.asDiagonal();
  return x;
}

namespace {

/// One survey leg, errors independent of each other: the general rules (ErrorSum), one error source after the other.
Matrix3d propagate_each(const std::vector<Matrix36d>& effects, const Vector6d& sd, PropagationMode mode) {
  Matrix3d c = Matrix3d::Zero();
  for (int i = 0; i < 6; ++i) {
    ErrorSum sum(mode);
    for (const Matrix36d& x : effects) sum.add(sd[i] * x.col(i));
    c += sum.covariance();
  }
  return c;
}

}  // namespace

Matrix3d propagate_systematic(const std::vector<Matrix36d>& effects, const Vector6d& sd) {
  return propagate_each(effects, sd, PropagationMode::systematic);
}

Matrix3d propagate_random(const std::vector<Matrix36d>& effects, const Vector6d& sd) {
  return propagate_each(effects, sd, PropagationMode::random);
}

}  // namespace surveymc::propagate
