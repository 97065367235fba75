#include "propagate/corrected_well_covariance.h"

#include "survey/position_method.h"

namespace surveymc::propagate {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

AzimuthDerivatives azimuth_derivatives(const survey::StationFields& station) {
  const auto [n, e, u, bh, bv] = survey::field_frame(station);
  // A = atan2(e_z, n_z). db turns north about down by -(e.db) / Bh (tangent_derivatives); du by (Bv / Bh) e.du, and it
  // tilts n and e towards u, which at sinI moves the azimuth by u_z (e_z n - n_z e).du / sin^2 I.
  const double sin2 = n.z() * n.z() + e.z() * e.z();
  return {-e.transpose() / bh, bv / bh * e.transpose() + u.z() / sin2 * (e.z() * n - n.z() * e).transpose()};
}

MatrixXd covariance_with_estimate(const MatrixXd& own, const MatrixXd& by_parameters,
                                  const Matrix6d& parameters_by_draws, const Matrix6d& parameter_covariance) {
  const MatrixXd mixed = own * parameters_by_draws.transpose() * by_parameters.transpose();
  return own * own.transpose() + mixed + mixed.transpose() +
         by_parameters * parameter_covariance * by_parameters.transpose();
}

std::vector<Matrix3d> position_covariances(const std::vector<double>& md,
                                           const std::vector<survey::Vec3<double>>& tangents,
                                           const std::vector<StationErrors>& stations,
                                           const Matrix6d& parameter_covariance) {
  std::vector<Matrix3d> all(md.size(), Matrix3d::Zero());
  // Sums over the stations before the last one of the position in hand, R_j = dr/dt_j: R T T' R', R T S', R Y.
  Matrix3d own = Matrix3d::Zero();
  Matrix36d own_with_estimate = Matrix36d::Zero(), by_parameters = Matrix36d::Zero();
  const auto add = [](const StationErrors& s, const Matrix3d& by_tangent, Matrix3d& o, Matrix36d& m, Matrix36d& p) {
    const Eigen::Matrix<double, 3, 6> moved = by_tangent * s.tangent_by_draws;
    o += moved * moved.transpose();
    m += moved * s.parameters_by_draws.transpose();
    p += by_tangent * s.tangent_by_parameters;
  };
  survey::walk_intervals(survey::PositionMethod::minimum_curvature, md, tangents,
                         [&](std::size_t k, const survey::IntervalDerivatives& d, const Matrix3d& arriving) {
                           add(stations[k - 1], arriving + d.by_from, own, own_with_estimate, by_parameters);
                           Matrix3d o = own;
                           Matrix36d m = own_with_estimate, p = by_parameters;
                           add(stations[k], d.by_to, o, m, p);
                           const Matrix3d mixed = m * p.transpose();
                           all[k] = o + mixed + mixed.transpose() + p * parameter_covariance * p.transpose();
                         });
  return all;
}

}  // namespace surveymc::propagate
