#include "least_squares_oracle.h"

#include <complex>

#include "stats/linear_algebra.h"

namespace surveymc::test {

LeastSquares least_squares(const reliability::AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes) {
  using Complex = std::complex<double>;
  using Eigen::Index;
  const bool fixed = model.mode == reliability::AdjustmentMode::mse_fixed, terms = model.systematic_terms && !fixed;
  const auto stations = static_cast<Index>(attitudes.size());
  const Index references = fixed ? 0 : 3, xi = terms ? 12 : 0;
  const Index n = 6 * stations + references + xi, u = 3 * stations + references + xi;
  LeastSquares l;
  l.design = Eigen::MatrixXd::Zero(n, u);
  l.variance.resize(n);
  l.observed.assign(static_cast<std::size_t>(n), true);
  for (Index k = 0; k < stations; ++k) {
    const survey::Attitude& at = attitudes[static_cast<std::size_t>(k)];
    const auto model_at = [&](const Eigen::VectorXcd& x) {
      const Complex si = std::sin(x[0]), ci = std::cos(x[0]), st = std::sin(x[1]), ct = std::cos(x[1]),
                    sa = std::sin(x[2]), ca = std::cos(x[2]), sd = std::sin(x[5]), cd = std::cos(x[5]);
      Eigen::VectorXcd y(6);
      y << -x[3] * si * st, -x[3] * si * ct, x[3] * ci, x[4] * (cd * ci * ca * st + cd * sa * ct - sd * si * st),
          x[4] * (cd * ci * ca * ct - cd * sa * st - sd * si * ct), x[4] * (cd * si * ca + sd * ci);
      for (Index i = 0; i < 6; ++i) y[i] = y[i] + x[6 + i] + x[12 + i] * y[i];
      return y;
    };
    Eigen::VectorXcd x = Eigen::VectorXcd::Zero(18);
    x.head<6>() << at.inclination, at.toolface, at.azimuth, model.field.gravity, model.field.total, model.field.dip;
    const reliability::Observations y = reliability::true_observations(at, model.field),
                                    v = reliability::observation_variances(model, y);
    for (Index j = 0; j < 18; ++j) {
      Eigen::VectorXcd moved = x;
      moved[j] += Complex(0, 1e-30);
      const Eigen::VectorXd column = model_at(moved).imag() / 1e-30;
      if (j < 3)
        l.design.block(6 * k, 3 * k + j, 6, 1) = column;
      else if (j < 6 && !fixed)
        l.design.block(6 * k, 3 * stations + j - 3, 6, 1) = column;
      else if (j >= 6 && terms)
        l.design.block(6 * k, 3 * stations + 3 + j - 6, 6, 1) = column;
    }
    for (Index i = 0; i < 6; ++i) l.variance[6 * k + i] = v[static_cast<std::size_t>(i)];
    if (!fixed)
      for (Index j = 0; j < 3; ++j) l.variance[6 * stations + j] = v[static_cast<std::size_t>(6 + j)];
  }
  l.design.bottomRightCorner(references + xi, references + xi).setIdentity();
  for (Index i = 0; i < xi; ++i) {
    const auto reading = static_cast<std::size_t>(i % 6);
    const double scale = reading < 3 ? model.sigma.accelerometer_scale : model.sigma.magnetometer_scale;
    l.variance[6 * stations + 3 + i] =
        i < 6 ? reliability::variance_parts(model.sigma, reading, 0).systematic : scale * scale;
  }
  Eigen::VectorXd weight = l.variance.cwiseInverse();
  if (model.mode == reliability::AdjustmentMode::sse_axial) {
    weight[5] = 0;
    l.observed[5] = false;
  }
  // Unknowns in units that make the normal matrix well conditioned
  const Eigen::VectorXd unit =
      (l.design.transpose() * weight.asDiagonal() * l.design).diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd x = l.design * unit.asDiagonal();
  const Eigen::MatrixXd normal = x.transpose() * weight.asDiagonal() * x;
  l.effect = unit.asDiagonal() * stats::symmetric_inverse(normal) * x.transpose() * weight.asDiagonal();
  l.redundancy = Eigen::MatrixXd::Identity(n, n) - l.design * l.effect;
  return l;
}

}  // namespace surveymc::test
