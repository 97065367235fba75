#include "reliability/station_response.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "base/units.h"
#include "reliability/reliability_grid.h"
#include "stats/linear_algebra.h"

namespace surveymc::reliability {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNothing = 1e-12;  // rad per sd of the error: rounding, as in station_kernel.h

/// Orthonormal bases of the station in the tool frame, and the derivatives of `down` by inclination and toolface.
struct Directions {
  Vector3d down, north, east, by_inclination, by_toolface;  ///< by_toolface: per sin I
};
Directions directions_of(const StationSines<double>& s) {
  Directions d;
  d.down << -s.si * s.st, -s.si * s.ct, s.ci;
  d.north << s.ci * s.ca * s.st + s.sa * s.ct, s.ci * s.ca * s.ct - s.sa * s.st, s.si * s.ca;
  d.east = d.down.cross(d.north);
  d.by_inclination << -s.ci * s.st, -s.ci * s.ct, -s.si;
  d.by_toolface << -s.ct, s.st, 0;
  return d;
}

/// Inverse of a symmetric and positive definite matrix.
Matrix3d inverse_of(const Matrix3d& a) { return a.llt().solve(Matrix3d::Identity()); }

/// x / divisor where the divisor may be 0: an x that is only rounding gives 0.
double over(double x, double divisor, double size) {
  return divisor > 0 ? x / divisor : std::abs(x) <= kNothing * size ? 0 : std::copysign(kInfinity, x);
}

}  // namespace

StationSines<double> station_sines(double inclination_deg, double toolface_deg, double magnetic_azimuth_deg,
                                   double dip_deg) {
  const auto [si, ci] = sincos_degrees(inclination_deg);
  const auto [st, ct] = sincos_degrees(toolface_deg);
  const auto [sa, ca] = sincos_degrees(magnetic_azimuth_deg);
  const auto [sd, cd] = sincos_degrees(dip_deg);
  return {si, ci, st, ct, sa, ca, sd, cd};
}

StationResponse::StationResponse(const AdjustmentModel& model, const StationSines<double>& s)
    : sines_(s), stations_(model.mode == AdjustmentMode::mse_shared ? model.stations : 1), mode_(model.mode) {
  const survey::ReferenceField& f = model.field;
  unit_ << Vector3::Constant(f.gravity), Vector3::Constant(f.total), f.gravity, f.total, 1;
  const Directions d = directions_of(s);
  const Vector3 field = s.cd * d.north + s.sd * d.down, by_dip = s.cd * d.down - s.sd * d.north;
  columns_.setZero();
  for (Index i = 0; i < 3; ++i) {
    columns_.col(i) << d.down[i], 0, d.north[i];
    columns_.col(3 + i) << 0, field[i], by_dip[i];
  }
  columns_.rightCols<3>() = -Matrix3d::Identity();

  Observations y{};
  Vector3::Map(y.data()) = f.gravity * d.down;
  Vector3::Map(y.data() + 3) = f.total * field;
  const Observations v = observation_variances(model, y);
  const bool terms = mode_ == AdjustmentMode::mse_shared && model.systematic_terms;
  systematic_.setZero();
  for (std::size_t i = 0; i < kObservations; ++i) {
    const auto k = static_cast<Index>(i);
    variance_[k] = v[i] / (unit_[k] * unit_[k]);
    if (terms && i < kReadings)
      systematic_[k] = variance_parts(model.sigma, i, y[i]).systematic / (unit_[k] * unit_[k]);
  }

  const Eigen::Matrix<double, 3, kReadings> readings = columns_.leftCols<kReadings>();
  Eigen::Matrix<double, kReadings, 1> own = variance_.head<kReadings>();
  if (mode_ == AdjustmentMode::sse_axial) own[kAxialMagnetometer] = 0;
  const Matrix3d of_one = readings * own.asDiagonal() * readings.transpose();
  Matrix3d common = variance_.tail<3>().asDiagonal();
  common += readings * systematic_.head<kReadings>().asDiagonal() * readings.transpose();
  weight_sum_ = inverse_of(of_one + stations_ * common);
  weight_ = weight_sum_;
  if (stations_ > 1) weight_ = ((stations_ - 1) * inverse_of(of_one) + weight_sum_) / stations_;

  of_bz_.setZero();
  if (mode_ == AdjustmentMode::sse_axial) {
    const Vector3 z = columns_.col(kAxialMagnetometer), wz = weight_ * z;
    const double zwz = z.dot(wz);
    azimuth_is_lost_ = zwz * variance_[kAxialMagnetometer] < kLeastRedundancy;
    if (!azimuth_is_lost_) {
      of_bz_ = wz / zwz;
      weight_ -= of_bz_ * wz.transpose();
      weight_sum_ = weight_;
    }
    columns_.col(kAxialMagnetometer).setZero();
  }
}

Observations StationResponse::sd() const {
  Observations sd;
  Vector9::Map(sd.data()) = variance_.cwiseSqrt().cwiseProduct(unit_);
  return sd;
}

StationResponse::Matrix9 StationResponse::information() const {
  const Columns scaled = columns_ * variance_.cwiseSqrt().asDiagonal();
  const auto readings = scaled.leftCols<kReadings>();
  const auto references = scaled.rightCols<3>();
  Matrix9 h;
  h.topLeftCorner<kReadings, kReadings>() = readings.transpose() * weight_ * readings;
  h.topRightCorner<kReadings, 3>() = readings.transpose() * weight_sum_ * references;
  h.bottomLeftCorner<3, kReadings>() = h.topRightCorner<kReadings, 3>().transpose();
  h.bottomRightCorner<3, 3>() = stations_ * references.transpose() * weight_sum_ * references;
  return h;
}

ErrorResponse StationResponse::of(const Observations& error) const {
  const Vector9 eps = Vector9::Map(error.data()).cwiseQuotient(unit_);
  double size = 0;  // of the error in sd
  for (Index k = 0; k < eps.size(); ++k)
    if (variance_[k] > 0) size += eps[k] * eps[k] / variance_[k];
  size = std::sqrt(size);

  const Vector3 readings = columns_.leftCols<kReadings>() * eps.head<kReadings>(),
                references = columns_.rightCols<3>() * eps.tail<3>();
  const Vector3 k = weight_ * readings + weight_sum_ * references,
                k_sum = weight_sum_ * (readings + stations_ * references);
  Vector9 residual = variance_.cwiseProduct(columns_.transpose() * k);
  residual.tail<3>() = variance_.tail<3>().cwiseProduct(columns_.rightCols<3>().transpose() * k_sum);

  // The rest of the error in the readings, after subtracting the estimated systematic terms, too
  Vector9 left = eps - residual - systematic_.cwiseProduct(columns_.transpose() * k_sum);
  if (mode_ == AdjustmentMode::sse_axial) left[kAxialMagnetometer] = -of_bz_.dot(readings + references);
  const Directions d = directions_of(sines_);
  const Vector3 g = left.head<3>(), b = left.segment<3>(3);
  // Leaning to the right of the hole makes toolface and azimuth move against each other.
  const double turn = (sines_.sd * d.east.dot(g) - d.east.dot(b)) / sines_.cd;

  ErrorResponse r;
  for (std::size_t i = 0; i < kObservations; ++i) {
    const auto at = static_cast<Index>(i);
    r.residuals[i] = is_observed(mode_, i) ? residual[at] * unit_[at] : kNaN;
  }
  r.inclination = d.by_inclination.dot(g);
  if (std::abs(sines_.si) < kLeastSine)  // by its tilt, to whichever side
    r.inclination = std::copysign(std::hypot(r.inclination, d.by_toolface.dot(g)), sines_.ci);
  r.toolface = over(d.by_toolface.dot(g), std::abs(sines_.si), size);
  r.azimuth = turn;
  if (r.toolface != 0 && sines_.ci != 0) r.azimuth -= sines_.ci * r.toolface;
  if (azimuth_is_lost_ && size > 0) r.azimuth = kInfinity;
  r.gravity = left[6] * unit_[6];
  r.total_field = left[7] * unit_[7];
  r.dip = left[8];
  return r;
}

WeakestDirection weakest_direction(const Eigen::MatrixXd& information) {
  const stats::SymmetricEigen eigen = stats::symmetric_eigen(information);
  const Eigen::VectorXd& values = eigen.values;  // rising, at most 1
  Index equal = 1;                               // directions that show as little
  while (equal < values.size() && values[equal] - values[0] < kLeastRedundancy) ++equal;
  const Eigen::MatrixXd space = eigen.vectors.leftCols(equal);
  // Nearest to a single observation: the longest projection of a unit vector, of equal ones the first
  const Eigen::VectorXd lengths = space.rowwise().norm();
  Index first = 0;
  while (lengths[first] < lengths.maxCoeff() * (1 - 1e-9)) ++first;
  WeakestDirection w;
  w.redundancy = values[0] < kLeastRedundancy ? 0 : values[0];
  w.direction = space * space.row(first).transpose() / lengths[first];
  w.dimensions = (values.array() >= kLeastRedundancy).count();
  return w;
}

}  // namespace surveymc::reliability
