#include "chained/basic_solution.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace surveymc::chained {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Vector3d accelerometers(const StationReading& y) { return {y[0], y[1], y[2]}; }
Vector3d magnetometers(const StationReading& y) { return {y[3], y[4], y[5]}; }

SingleStation station_of(const Vector3d& f, const Vector3d& h) {
  SingleStation s;
  s.gravity = f.norm();
  const Vector3d d = -f / s.gravity;
  s.down = d.dot(h);
  const Vector3d level = h - s.down * d;
  s.horizontal = level.norm();
  s.frame.col(0) = level / s.horizontal;
  s.frame.col(1) = d.cross(s.frame.col(0));
  s.frame.col(2) = d;
  return s;
}

/// Minimises sum w_i (y_i - x_i)^2 + sum_j v_j (q_j(x) - r_j)^2 by Gauss-Newton from x = y. `rows(x)` gives q and its
/// gradients. The curvature is noise over field: a few steps.
template <int Q, class Rows>
Vector3d optimum(const Vector3d& y, const Vector3d& w, const Eigen::Matrix<double, Q, 1>& v, const Rows& rows) {
  Vector3d x = y;
  for (int it = 0; it < 50; ++it) {
    const auto [misfit, gradient] = rows(x);  // Q, Q x 3
    const Matrix3d normal = Matrix3d(w.asDiagonal()) + gradient.transpose() * v.asDiagonal() * gradient;
    const Vector3d step = normal.llt().solve(w.cwiseProduct(y - x) - gradient.transpose() * v.cwiseProduct(misfit));
    x += step;
    if (step.norm() <= 1e-15 * y.norm()) break;
  }
  return x;
}

}  // namespace

SingleStation basic_station(const StationReading& y) { return station_of(accelerometers(y), magnetometers(y)); }

SingleWeights single_weights(const Model& m) {
  SingleWeights w;
  w.reference_sd = m.reference_sd;
  for (std::size_t i = 0; i < 6; ++i) {
    const double prior = m.prior_sd[kReferenceStates + i], walk = m.link_sd[kReferenceStates + i];
    w.reading_sd[i] = std::sqrt(prior * prior - walk * walk);
  }
  return w;
}

SingleStation fully_optimised_station(const Model& m, const SingleWeights& weights, const StationReading& y) {
  const Vector3d s_f = accelerometers(weights.reading_sd), s_h = magnetometers(weights.reading_sd);
  const auto& s_r = weights.reference_sd;
  using One = Eigen::Matrix<double, 1, 1>;
  const Vector3d f =
      optimum<1>(accelerometers(y), s_f.cwiseAbs2().cwiseInverse(), One(1 / (s_r[0] * s_r[0])), [&](const Vector3d& x) {
        return std::pair{One(x.norm() - m.gravity), Eigen::Matrix<double, 1, 3>(x.transpose() / x.norm())};
      });
  const Vector3d d = -f.normalized();
  const Vector3d h =
      optimum<2>(magnetometers(y), s_h.cwiseAbs2().cwiseInverse(),
                 Eigen::Vector2d(1 / (s_r[1] * s_r[1]), 1 / (s_r[2] * s_r[2])), [&](const Vector3d& x) {
                   const Vector3d level = x - d.dot(x) * d;
                   Eigen::Matrix<double, 2, 3> gradient;
                   gradient << level.normalized().transpose(), d.transpose();
                   return std::pair{Eigen::Vector2d(level.norm() - m.horizontal, d.dot(x) - m.down), gradient};
                 });
  return station_of(f, h);
}

}  // namespace surveymc::chained
