#include "propagate/vertical_well.h"

#include <cassert>
#include <cmath>

#include "base/units.h"

namespace surveymc::propagate {

using Eigen::Matrix2d;
using Eigen::Vector2d;

std::vector<double> vertical_station_weights(int intervals, double spacing) {
  std::vector<double> w(static_cast<std::size_t>(intervals) + 1, spacing);
  w.front() = w.back() = spacing / 2;
  return w;
}

double magnetic_toolface(const survey::Vec3<double>& field_T) {
  const double t = std::atan2(field_T.x, field_T.y);
  return t < 0 ? t + 2 * kPi : t;
}

namespace {

/// Columns: eqs 19 and 20 per radian of tilt and metre of weight.
Matrix2d bias_effects(double alpha) {
  const double s = std::sin(alpha), c = std::cos(alpha);
  Matrix2d m;
  m << -s, -c, c, -s;
  return m;
}

}  // namespace

Matrix2d toolface_dependent_covariance(const std::vector<double>& weights, const std::vector<double>& toolfaces,
                                       double tilt_sd) {
  assert(weights.size() == toolfaces.size());
  Matrix2d sum = Matrix2d::Zero();
  for (std::size_t k = 0; k < weights.size(); ++k) sum += tilt_sd * weights[k] * bias_effects(toolfaces[k]);
  return sum * sum.transpose();
}

double fictive_correlation(double toolface_j, double toolface_m) {
  return std::abs(std::remainder(toolface_j - toolface_m, 2 * kPi)) < 1e-9 ? 1.0 : 0.0;
}

Matrix2d fictive_terms_covariance(const std::vector<double>& weights, const std::vector<double>& magnetic_toolfaces,
                                  const std::vector<double>& toolfaces, double tilt_sd) {
  assert(weights.size() == magnetic_toolfaces.size() && weights.size() == toolfaces.size());
  Matrix2d covariance = Matrix2d::Zero();
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const double s = std::sin(magnetic_toolfaces[j]), c = std::cos(magnetic_toolfaces[j]);
    const Vector2d term4(s, -c), term5(c, s);
    // Eqs 37 and 39 hold for each bias with a factor 1/2; the two biases make it 1.
    const Matrix2d squares = term4 * term4.transpose() + term5 * term5.transpose();
    double correlated = 0;
    for (std::size_t m = 0; m < weights.size(); ++m)
      correlated += weights[m] * fictive_correlation(toolfaces[j], toolfaces[m]);
    covariance += tilt_sd * tilt_sd * weights[j] * correlated * squares;
  }
  return covariance;
}

TwoSources toolface_independent_sources(const std::vector<double>& weights, double tilt_sd) {
  TwoSources s;
  for (const double w : weights) s.push_back(tilt_sd * w * Matrix2d::Identity());
  return s;
}

TwoSources spe_67616_sources(const std::vector<double>& weights, double tilt_sd) {
  TwoSources s;
  for (const double w : weights) s.push_back(tilt_sd * w * bias_effects(0));
  return s;
}

TwoSources copegrove_sources(const std::vector<double>& weights, double tilt_sd, bool with_half_leg) {
  TwoSources s;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    // Without dD/2 each interval that meets at the station counts as one metre.
    const double intervals = k == 0 || k + 1 == weights.size() ? 1 : 2;
    s.push_back(tilt_sd * Vector2d(-weights[k], with_half_leg ? weights[k] : intervals).asDiagonal().toDenseMatrix());
  }
  return s;
}

Matrix2d systematic_covariance(const TwoSources& sources) {
  Matrix2d sum = Matrix2d::Zero();
  for (const Matrix2d& x : sources) sum += x;
  return sum * sum.transpose();
}

Matrix2d random_covariance(const TwoSources& sources) {
  Matrix2d c = Matrix2d::Zero();
  for (const Matrix2d& x : sources) c += x * x.transpose();
  return c;
}

Matrix2d as_drilled_covariance(const TwoSources& sources, const std::vector<double>& toolfaces) {
  assert(sources.size() == toolfaces.size());
  Matrix2d c = Matrix2d::Zero();
  for (std::size_t j = 0; j < sources.size(); ++j) {
    Matrix2d correlated = Matrix2d::Zero();
    for (std::size_t m = 0; m < sources.size(); ++m)
      correlated += fictive_correlation(toolfaces[j], toolfaces[m]) * sources[m];
    c += sources[j] * correlated.transpose();
  }
  return c;
}

}  // namespace surveymc::propagate
