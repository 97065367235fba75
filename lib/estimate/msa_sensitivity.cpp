#include "estimate/msa_sensitivity.h"

#include <Eigen/Dense>

#include "base/error.h"

namespace surveymc {

using Eigen::Matrix3d;
using Eigen::Vector3d;

MsaSensitivity msa_sensitivity(const std::vector<StationFields>& stations, const std::array<double, 3>& gain,
                               double total, double dip) {
  const std::size_t n = stations.size();
  const Vector3d per_gain(1 / gain[0], 1 / gain[1], 1 / gain[2]);
  std::vector<Eigen::Matrix<double, 2, 3>> by_field(n);  // d(Bh, Bv)/db
  std::vector<Eigen::Matrix<double, 2, 6>> jacobian(n);  // d(Bh, Bv)/d(gain, bias)
  Matrix6d normal = Matrix6d::Zero();
  // Biases are scaled by the total field, so that the condition of J'J speaks of geometry and not of units.
  Vector6d unit;
  unit << 1, 1, 1, total, total, total;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3d b = to_eigen(stations[k].field_T), u = to_eigen(stations[k].down_T);
    const Vector3d h = b - u.dot(b) * u;
    by_field[k].row(0) = h.normalized();
    by_field[k].row(1) = u;
    // b = (m - bias) / gain: db_i/dgain_i = -b_i / gain_i, db_i/dbias_i = -1 / gain_i
    jacobian[k].leftCols<3>() = -by_field[k] * b.cwiseProduct(per_gain).asDiagonal();
    jacobian[k].rightCols<3>() = -by_field[k] * per_gain.asDiagonal();
    const Eigen::Matrix<double, 2, 6> j = jacobian[k] * unit.asDiagonal();
    normal += j.transpose() * j / (total * total);
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(normal);
  // Below 1e-13 of the largest, rounding in J'J alone makes an eigenvalue: the geometry says nothing there.
  require(eigen.eigenvalues().minCoeff() > 1e-13 * eigen.eigenvalues().maxCoeff(),
          "the stations cannot determine three gains and three biases (condition of J'J {:.1e}): MSA needs "
          "stations of different attitude and toolface",
          eigen.eigenvalues().maxCoeff() / std::max(eigen.eigenvalues().minCoeff(), 1e-300));
  const Matrix6d inverse =
      unit.asDiagonal() * Matrix6d(normal.ldlt().solve(Matrix6d::Identity())) * unit.asDiagonal() / (total * total);

  Eigen::Matrix2d reference;  // d(Bh_ref, Bv_ref)/d(total, dip)
  reference << std::cos(dip), -total * std::sin(dip), std::sin(dip), total * std::cos(dip);
  MsaSensitivity s;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3d b = to_eigen(stations[k].field_T), u = to_eigen(stations[k].down_T);
    const Eigen::Matrix<double, 6, 2> pull = inverse * jacobian[k].transpose();
    s.by_magnetometer.push_back(-pull * by_field[k] * per_gain.asDiagonal());
    // dBv/du = b; dBh/du = -(Bv / Bh) (b - Bv u) - ...: with n.u = 0, dBh = n.d(b - (u.b) u) = -Bv n.du for du
    // perpendicular to u.
    Eigen::Matrix<double, 2, 3> by_down;
    by_down.row(0) = -u.dot(b) * by_field[k].row(0);
    by_down.row(1) = b;
    s.by_down.push_back(-pull * by_down);
    s.by_reference.push_back(pull * reference);
  }
  return s;
}

Matrix6d msa_covariance(const MsaSensitivity& s, const std::vector<StationFields>& stations,
                        const MsaInputNoise& noise) {
  Matrix6d c = Matrix6d::Zero();
  const Eigen::Vector2d reference_sd(noise.total_sd, noise.dip_sd);
  Matrix62d common = Matrix62d::Zero();
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Matrix63d m = noise.magnetometer_sd * s.by_magnetometer[k];
    c += m * m.transpose();
    const Vector3d u = to_eigen(stations[k].down_T);
    const Matrix63d d = noise.down_sd * s.by_down[k] * (Matrix3d::Identity() - u * u.transpose());
    c += d * d.transpose();
    const Matrix62d r = s.by_reference[k] * reference_sd.asDiagonal();
    if (noise.reference_per_station)
      c += r * r.transpose();
    else
      common += r;
  }
  return c + common * common.transpose();
}

}  // namespace surveymc
