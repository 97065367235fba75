#include "chained/basic_solution.h"

#include <array>
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

/// One term v (q(x) - r)^2.
struct Term {
  double weight, misfit;  ///< v, q - r
  Vector3d gradient;      ///< of q
};

/// Minimises sum w_i (y_i - x_i)^2 + sum_j v_j (q_j(x) - r_j)^2 by Gauss-Newton from x = y. `terms(x)` gives the second
/// sum. The curvature is noise over field: a few steps.
template <class Terms>
Vector3d optimum(const Vector3d& y, const Vector3d& w, const Terms& terms) {
  Vector3d x = y;
  for (int it = 0; it < 50; ++it) {
    Matrix3d normal = w.asDiagonal();
    Vector3d pull = w.cwiseProduct(y - x);
    for (const Term& t : terms(x)) {
      normal += t.weight * t.gradient * t.gradient.transpose();
      pull -= t.weight * t.misfit * t.gradient;
    }
    const Vector3d step = normal.llt().solve(pull);
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
  const auto weight = [&](std::size_t j) { return 1 / (s_r[j] * s_r[j]); };
  const Vector3d f = optimum(accelerometers(y), s_f.cwiseAbs2().cwiseInverse(), [&](const Vector3d& x) {
    return std::array{Term{weight(0), x.norm() - m.gravity, x / x.norm()}};
  });
  const Vector3d d = -f.normalized();
  const Vector3d h = optimum(magnetometers(y), s_h.cwiseAbs2().cwiseInverse(), [&](const Vector3d& x) {
    const Vector3d level = x - d.dot(x) * d;
    return std::array{Term{weight(1), level.norm() - m.horizontal, level.normalized()},
                      Term{weight(2), d.dot(x) - m.down, d}};
  });
  return station_of(f, h);
}

}  // namespace surveymc::chained
