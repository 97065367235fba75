/// Calibration of the claimed distributions of the study `msa_position`.
#include <cmath>

#include "base/units.h"
#include "msa_position/study.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

/// The tallied NEES is then that of the claim.
bool PositionPoint::claims_what_is_predicted() const {
  const Eigen::Matrix<double, 6, 6> claimed = prediction_.claimed_covariance.topLeftCorner<6, 6>();
  for (int i = 0; i < 6; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const double off = prediction_.parameters[i] - (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]);
    if (!(std::abs(off) <= 1e-9 * std::sqrt(claimed(i, i)))) return false;
    for (int j = 0; j <= i; ++j)
      if (!(std::abs(claimed(i, j) - prediction_.parameter_covariance(i, j)) <=
            1e-12 * std::sqrt(claimed(i, i) * claimed(j, j))))
        return false;
  }
  return true;
}

void PositionPoint::make_calibrated() {
  const Eigen::Matrix3d& joint = prediction_.position_covariance[0];
  const Eigen::Vector3d off =
      prediction_.position - Eigen::Vector3d(survey::minimum_curvature_positions(s_.survey).back());
  const bool constant = s_.assumed_noise == sensor::AssumedNoise::constant;
  for (const compare::RowName& row : calibrated_rows(s_)) {
    if (!s_.calibration.wants(row.quantity)) continue;
    const std::string &f = row.formulation, &q = row.quantity;
    CalibratedColumn at;
    double sd = 1;
    for (int i = 0; i < 6; ++i)
      if (const auto a = static_cast<std::size_t>(i); q == estimate::kParameterNames[a]) {
        at = {at_.parameter + i, prediction_.parameters[i] - (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]),
              constant ? -1 : at_.claimed + i};
        if (constant) sd = std::sqrt(prediction_.claimed_covariance(i, i));
      }
    for (int i = 0; i < 2; ++i)
      if (q == kReference[static_cast<std::size_t>(i)]) {
        at = {at_.reference + i};
        sd = std::sqrt(prediction_.claimed_covariance(6 + i, 6 + i)) / (i == 0 ? 1 : kDegree);
      }
    for (int i = 0; i < 3; ++i)
      if (q == kDirections[static_cast<std::size_t>(i)]) {
        at = {at_.position + i, off[i]};
        sd = std::sqrt(joint(i, i));
      }
    for (int i = 0; i < 2; ++i)
      if (q == (i == 0 ? "major_axis" : "minor_axis")) {
        const Eigen::Vector2d axis = horizontal_axes_[0].col(i);
        at = {at_.axes + i, axis.dot(off.head<2>())};
        const double variance = axis.dot(joint.topLeftCorner<2, 2>() * axis);
        sd = variance > 1e-14 * joint.trace() ? std::sqrt(variance) : 0;  // rounding is no claim
      }
    for (int i = 0; i < 3; ++i)
      if (q == kAzimuths[static_cast<std::size_t>(i)]) at = {kAzimuth - i};
    if (q == "nees") at = {claims_what_is_predicted() ? at_.nees_parameters : kNees};
    has_azimuths_ = has_azimuths_ || at.column <= kAzimuth;
    calibrated_.push_back(
        q == "nees" ? compare::chi_squared_quantity(f, q, 6)
        : at.column <= kAzimuth
            ? compare::angle_quantity(f, q,
                                      prediction_.claimed_azimuth_sd[static_cast<std::size_t>(kAzimuth - at.column)])
            : compare::normal_quantity(f, q, sd));
    calibrated_columns_.push_back(at);
  }
  azimuth_places_ = analysis::first_middle_last(s_.survey.stations.size());
  for (std::size_t i = 0; i < azimuth_places_.size(); ++i) {
    const double magnetic = s_.survey.stations[azimuth_places_[i]].azimuth - s_.field.declination;
    sin_azimuth_[i] = std::sin(magnetic);
    cos_azimuth_[i] = std::cos(magnetic);
  }
}

void PositionPoint::count_calibration(const Eigen::Ref<const Eigen::MatrixXd>& values, const Eigen::MatrixXd& angles,
                                      std::vector<std::uint64_t>& counts) const {
  Eigen::VectorXd scaled(values.rows());
  for (std::size_t c = 0; c < calibrated_.size(); ++c) {
    const CalibratedColumn& at = calibrated_columns_[c];
    const double* x = scaled.data();
    double offset = 0;
    if (at.column <= kAzimuth) {
      x = angles.col(kAzimuth - at.column).data();
    } else if (at.column == kNees) {
      for (Eigen::Index t = 0; t < values.rows(); ++t) {
        Eigen::Matrix<double, 6, 1> error;
        for (int i = 0; i < 6; ++i) {
          const auto a = static_cast<std::size_t>(i);
          error[i] = values(t, at_.parameter + i) + prediction_.parameters[i] -
                     (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]);
        }
        scaled[t] = error.dot(claimed_weight_ * error);
      }
    } else if (at.variance >= 0) {
      for (Eigen::Index t = 0; t < values.rows(); ++t) {
        const double variance = values(t, at.variance);
        scaled[t] = variance > 0 ? (values(t, at.column) + at.offset) / std::sqrt(variance) : kNaN;
      }
    } else {
      x = values.col(at.column).data();
      offset = at.offset;
    }
    calibrated_[c].cells.count(x, static_cast<std::size_t>(values.rows()), offset,
                               counts.data() + kCounts + c * stats::kPitSlots);
  }
}

}  // namespace surveymc::studies::msa_position
