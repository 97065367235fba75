#include "analysis/sensor_prediction.h"

#include <cmath>

#include <Eigen/LU>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "propagate/ellipse.h"
#include "propagate/sensor_error_covariance.h"
#include "propagate/toolface_independent.h"
#include "stats/linear_algebra.h"

namespace surveymc::analysis {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

namespace {

/// A sd below this part of the largest is zero to first order: it is only rounding and predicts nothing.
constexpr double kZero = 1e-6;

}  // namespace

PositionPrediction::PositionPrediction(const Matrix3d& c) : covariance(c), horizontal_weight(Matrix2d::Constant(kNaN)) {
  const auto eigen = stats::symmetric_eigen(c);
  for (int a = 0; a < 3; ++a) {
    sd[a] = standard_deviation(eigen.values[2 - a]);
    axes.col(a) = eigen.vectors.col(2 - a);
  }
  for (int a = 1; a < 3; ++a)
    if (sd[a] < kZero * sd[0]) sd[a] = 0;
  const Matrix2d h = c.topLeftCorner<2, 2>();
  const propagate::Ellipse e = propagate::ellipse(h);
  horizontal_axes = e.axes;
  if (e.semi_minor > kZero * e.semi_major) horizontal_weight = h.inverse();
}

std::vector<PositionPredictions> predict_sensor_runs(const survey::Survey& survey, const survey::ReferenceField& field,
                                                     const survey::SensorTermArray& sd,
                                                     const survey::ToolfacePlan& plan, const std::vector<int>& reported,
                                                     bool first_is_tie_on) {
  const std::vector<double> md = survey.md();
  const std::vector<survey::Vec3<double>> tangents = survey::true_tangents(survey);
  const auto covariances = [&](std::vector<propagate::TangentErrors> errors) {
    if (first_is_tie_on) {
      errors.front().constant.setZero();
      errors.front().independent.setZero();
    }
    return propagate::propagate_tangent_errors(md, tangents, errors, survey::PositionMethod::minimum_curvature);
  };
  using enum propagate::ToolfacePropagation;
  const std::array<std::vector<Matrix3d>, 3> all{
      covariances(propagate::sensor_tangent_errors(survey, field, sd, plan)),
      covariances(propagate::toolface_independent_errors(survey, field, sd, systematic)),
      covariances(propagate::toolface_independent_errors(survey, field, sd, random))};
  std::vector<PositionPredictions> predictions;
  for (const int k : reported) {
    predictions.emplace_back();
    for (const auto& c : all) predictions.back().emplace_back(c[static_cast<std::size_t>(k)]);
  }
  return predictions;
}

}  // namespace surveymc::analysis
