#include "estimate/sensitivity.h"

#include <algorithm>

#include <Eigen/LU>

#include "base/error.h"
#include "base/units.h"
#include "estimate/estimators.h"
#include "estimate/field_fit.h"
#include "estimate/field_misfit.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// An eigenvalue below 1e-13 of the largest may come from rounding in J'J alone, and says nothing of the geometry.
constexpr double kSingular = 1e13;

/// `visible`: the eigenvalue of a parameter that the stations see well. Without it a single unknown that the stations
/// hardly see would pass as well conditioned.
double condition_of(const Eigen::MatrixXd& normal, double visible) {
  if (normal.size() == 0) return 1;
  const Eigen::VectorXd eigenvalues = stats::symmetric_eigen(normal).values;
  return std::max(eigenvalues.maxCoeff(), visible) / std::max(eigenvalues.minCoeff(), 1e-300);
}

/// The same of the matrix scaled to a unit diagonal.
double scaled_condition_of(const Eigen::MatrixXd& normal) {
  if (normal.size() == 0) return 1;
  if (!(normal.diagonal().minCoeff() > 0)) return kInfinity;
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  return condition_of(scale.asDiagonal() * normal * scale.asDiagonal(), 0);
}

/// a a'
template <int Inner>
Matrix8d square(const Eigen::Matrix<double, 8, Inner>& a) {
  return a.lazyProduct(a.transpose());
}

/// Unknowns: gain, bias / total, z (field_fit.h); fields in units of `total`. Without derivatives where singular.
Sensitivity linearised_fit(const FieldFitModel& model, const NominalTruth& truth) {
  const std::size_t n = truth.stations.size();
  const double total = truth.field.total;
  const Vector3d gain(truth.gain.data()), bias = Vector3d(truth.bias.data()) / total, per_gain = gain.cwiseInverse();
  Matrix2d w;
  w << model.w_hh, model.w_hv, model.w_hv, model.w_vv;
  const Vector2d z_unit(model.total_sd * total, model.dip_sd);  // nT and rad of one z

  const std::vector<FieldMisfit> misfits =
      field_misfits(truth.stations, truth.gain, truth.field.total, truth.field.dip);
  std::vector<Eigen::Matrix<double, 2, 8>> jacobian(n);
  Matrix8d normal = Matrix8d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    jacobian[k].leftCols<3>() = misfits[k].by_parameters.leftCols<3>() / total;
    jacobian[k].middleCols<3>(3) = misfits[k].by_parameters.rightCols<3>();
    jacobian[k].rightCols<2>() = misfits[k].by_reference * z_unit.asDiagonal() / total;
    normal += jacobian[k].transpose() * w * jacobian[k];
  }
  // Priors are on p - 1 and q, p = 1 / gain and q = bias / gain.
  Matrix6d dpq = Matrix6d::Zero();
  dpq.topLeftCorner<3, 3>() = Vector3d(-per_gain.cwiseAbs2()).asDiagonal();
  dpq.bottomLeftCorner<3, 3>() = Vector3d(-bias.cwiseProduct(per_gain.cwiseAbs2())).asDiagonal();
  dpq.bottomRightCorner<3, 3>() = per_gain.asDiagonal();
  Vector6d weight, pq;
  for (int i = 0; i < 3; ++i) {
    weight[i] = model.gain_prior;
    weight[3 + i] = model.bias_prior[static_cast<std::size_t>(i)];
    pq[i] = per_gain[i] - 1;
    pq[3 + i] = bias[i] * per_gain[i];
  }
  std::vector<int> unknown, held;
  for (int i = 0; i < 6; ++i) (model.estimated[static_cast<std::size_t>(i)] ? unknown : held).push_back(i);
  weight(held).setZero();
  Matrix6d prior = dpq.transpose() * weight.asDiagonal() * dpq;
  for (const int k : held) prior.col(k).setZero();
  const Matrix8d by_readings = normal;
  normal.topLeftCorner<6, 6>() += prior;
  Sensitivity s;
  // A bias's column has the length 1 at a station whose tool axis lies in the plane of gravity and field.
  s.condition = condition_of(normal(unknown, unknown), static_cast<double>(n) * std::max(model.w_hh, model.w_vv));
  if (!(s.condition < kSingular)) return s;
  if (model.joint) {
    normal.bottomRightCorner<2, 2>() += model.unit_weight * Matrix2d::Identity();
    unknown.insert(unknown.end(), {6, 7});
  }
  s.scaled_condition = scaled_condition_of(normal(unknown, unknown));

  Vector8d unit = Vector8d::Ones();
  unit.segment<3>(3).setConstant(total);
  unit.tail<2>() = z_unit;
  Matrix8d inverse = Matrix8d::Zero();  // of the unknowns; parameters that are held do not move
  if (!unknown.empty()) {
    inverse(unknown, unknown) = stats::symmetric_inverse(normal(unknown, unknown));
  }
  inverse = unit.asDiagonal() * inverse;
  s.by_magnetometer.reserve(n);
  s.by_down.reserve(n);
  s.by_reference.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Matrix82d pull = inverse * jacobian[k].transpose() * w / -total;
    s.by_magnetometer.push_back(pull * misfits[k].by_magnetometer);
    s.by_down.push_back(pull * misfits[k].by_down);
    Matrix82d by_reference = pull * misfits[k].by_reference;
    // The reference's own error; one draw that holds for all stations counts once, at the first.
    if (k == 0) by_reference.bottomRows<2>() += Matrix2d::Identity();
    s.by_reference.push_back(by_reference);
  }
  s.by_truth = -inverse.leftCols<6>() * prior;
  // The deviation of a parameter that is held at 1 or 0 remains in the readings: the unknowns absorb the part of its
  // effect that looks like theirs.
  for (const int h : held) s.by_truth.col(h) = inverse * by_readings.col(h);
  s.by_truth.rightCols<3>() /= total;
  s.shift = -inverse.leftCols<6>() * dpq.transpose() * weight.cwiseProduct(pq);
  for (const int h : held) {
    s.by_truth(h, h) = -1;
    s.shift += s.by_truth.col(h) * (h < 3 ? gain[h] - 1 : bias[h - 3] * total);
  }
  return s;
}

Sensitivity linearise(const EstimatorOptions& options, const NominalTruth& truth) {
  const EstimatorKind& kind = estimator_kind(options.name);
  require(
      kind.predict != nullptr,
      "estimator.name = \"{}\": a prediction to first order is needed here, and this estimator has none (its line in "
      "lib/estimate/estimators.cpp has no `predict`)",
      options.name);
  require(kind.takes_subset || options.estimates_all(), "estimator.estimated: {} estimates {}", options.name,
          kind.estimates_all ? "all six parameters" : "its own parameters only");
  return kind.predict(options, truth);
}

}  // namespace

Sensitivity field_fit_sensitivity(const EstimatorOptions& options, const NominalTruth& truth) {
  return linearised_fit(field_fit_model(options, truth.field), truth);
}

/// wls.h: per axis, unknowns e_S and bias.
Sensitivity wls_sensitivity(const EstimatorOptions& options, const NominalTruth& truth) {
  const InputErrors& assumed = options.assumed;
  require_weights(assumed);
  const double r = 1 / (assumed.magnetometer * assumed.magnetometer), total = truth.field.total;
  const std::size_t n = truth.stations.size();
  const Vector2d unit(1, total);
  Sensitivity s;
  s.by_magnetometer.assign(n, Matrix83d::Zero());
  s.by_down.assign(n, Matrix83d::Zero());
  s.by_reference.assign(n, Matrix82d::Zero());
  if (n > 0) s.by_reference[0].bottomRows<2>().setIdentity();
  for (int axis = 0; axis < 3; ++axis) {
    const double bias_sd = assumed.bias_sd(axis);
    const Vector2d prior(assumed.gain > 0 ? 1 / (assumed.gain * assumed.gain) : 0,
                         bias_sd > 0 ? total * total / (bias_sd * bias_sd) : 0);
    Matrix2d normal = prior.asDiagonal();
    const auto column = [&](std::size_t k) {
      return Vector2d(survey::to_eigen(truth.stations[k].field_T)[axis], total);
    };
    for (std::size_t k = 0; k < n; ++k) normal += r * column(k) * column(k).transpose();
    s.condition = std::max(s.condition, condition_of(normal, 0));
    if (!(s.condition < kSingular)) return s;
    const Matrix2d inverse = unit.asDiagonal() * Matrix2d(normal.inverse());
    for (std::size_t k = 0; k < n; ++k) {
      const Vector2d gain = inverse * column(k) * r;
      s.by_magnetometer[k](axis, axis) = gain[0];
      s.by_magnetometer[k](3 + axis, axis) = gain[1];
    }
    const auto a = static_cast<std::size_t>(axis);
    const Matrix2d pull = -inverse * prior.asDiagonal() * unit.cwiseInverse().asDiagonal();
    const Vector2d shift = pull * Vector2d(truth.gain[a] - 1, truth.bias[a]);
    for (int i = 0; i < 2; ++i) {
      s.shift[3 * i + axis] = shift[i];
      for (int j = 0; j < 2; ++j) s.by_truth(3 * i + axis, 3 * j + axis) = pull(i, j);
    }
  }
  return s;
}

Sensitivity sensitivity(const EstimatorOptions& options, const NominalTruth& truth) {
  Sensitivity s = linearise(options, truth);
  require(s.condition < kSingular,
          "the stations cannot determine {} (condition of J'J {:.1e}): MSA needs stations of different attitude and "
          "toolface",
          options.estimates_all() ? "three gains and three biases" : "the gains and biases to be estimated",
          s.condition);
  return s;
}

std::optional<Sensitivity> find_sensitivity(const EstimatorOptions& options, const NominalTruth& truth) {
  std::optional<Sensitivity> s = linearise(options, truth);
  if (!(s->condition < kSingular)) s.reset();
  return s;
}

Matrix8d error_covariance(const Sensitivity& s, const std::vector<survey::StationFields>& stations,
                          const InputErrors& errors, const Eigen::MatrixXd* correlation) {
  Vector6d truth_sd;
  truth_sd.head<3>().setConstant(errors.gain);
  for (int axis = 0; axis < 3; ++axis) truth_sd[3 + axis] = errors.bias_sd(axis);
  const Matrix86d t = s.by_truth * truth_sd.asDiagonal();
  Matrix8d c = square(t);
  const Vector2d reference_sd(errors.total, errors.dip);
  Matrix82d common = Matrix82d::Zero();
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Matrix83d m = errors.magnetometer * s.by_magnetometer[k];
    c += square(m);
    const Vector3d u = survey::to_eigen(stations[k].down_T);
    const Matrix83d d = errors.down * s.by_down[k] * (Matrix3d::Identity() - u * u.transpose());
    c += square(d);
    const Matrix82d r = s.by_reference[k] * reference_sd.asDiagonal();
    if (errors.reference_per_station)
      c += square(r);
    else
      common += r;
    if (errors.station_total > 0 || errors.station_dip > 0) {
      // The true field moves, not the reference whose error the last two rows are.
      Matrix82d moved = s.by_reference[k];
      if (k == 0) moved.bottomRows<2>() -= Matrix2d::Identity();
      c += square(Matrix82d(moved * Vector2d(errors.station_total, errors.station_dip).asDiagonal()));
    }
  }
  c += square(common);
  if (correlation == nullptr) return c;
  Eigen::Matrix<double, 8, Eigen::Dynamic> by_draws(8, correlation->cols());
  for (std::size_t k = 0; k < stations.size(); ++k)
    by_draws.middleCols<2>(2 * static_cast<Eigen::Index>(k)) = s.by_reference[k] * reference_sd.asDiagonal();
  c += by_draws * (*correlation - Eigen::MatrixXd::Identity(by_draws.cols(), by_draws.cols())) * by_draws.transpose();
  return c;
}

}  // namespace surveymc::estimate
