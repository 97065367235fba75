/// Calibration of the claimed distributions of the study `msa_position`.
#include <cmath>

#include "base/units.h"
#include "msa_position/study.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

void PositionPoint::make_calibrated() {
  calibrated_rows_ = compare::calibrated_rows(rows_, s_.calibration);
  for (const compare::Row& row : calibrated_rows_) {
    const std::string &f = row.formulation, &q = row.quantity;
    using enum compare::Statistic;
    has_azimuths_ = has_azimuths_ || row.statistic == angle;
    calibrated_.push_back(row.statistic == squared_distance ? compare::chi_squared_quantity(f, q, 6)
                          : row.statistic == angle          ? compare::angle_quantity(f, q, row.prediction)
                                                            : compare::normal_quantity(f, q, row.prediction));
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
    const compare::Row& at = calibrated_rows_[c];
    const double* x = scaled.data();
    double offset = 0;
    if (at.statistic == compare::Statistic::angle) {
      x = angles.col(kAzimuth - at.component).data();
    } else if (at.component == kClaimedDistance) {
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
        scaled[t] = variance > 0 ? (values(t, at.component) + at.offset) / std::sqrt(variance) : kNaN;
      }
    } else {
      x = values.col(at.component).data();
      offset = at.offset;
    }
    calibrated_[c].cells.count(x, static_cast<std::size_t>(values.rows()), offset,
                               counts.data() + kCounts + c * stats::kPitSlots);
  }
}

}  // namespace surveymc::studies::msa_position
