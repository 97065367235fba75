#pragma once
#include <Eigen/Core>

#include "error_model/model.h"

namespace surveymc::propagate {

using error_model::PropagationMode;

/// Position covariance of one error source, station after station (Williamson, SPE 67616; thesis eqs 41-47, with the
/// errata of docs/studies/msa_position.md). With e_k the effect of station k's error on positions beyond station k + 1,
/// and e*_K that on the position of station K itself (the leg before it only),
///
///   R     C_K = sum_{k<K} e_k e_k' + e*_K e*_K'
///   S     C_K = sum_{earlier legs} (sum_k e_k)(sum_k e_k)' + (sum_{k<K} e_k + e*_K)(same)', k in the leg of K
///   W, G  C_K = (sum_{k<K} e_k + e*_K)(same)', k over all legs
///
/// Effects have one-sigma size: N, E, V in metres. Memory and time per station are constant.
class ErrorSum {
 public:
  explicit ErrorSum(PropagationMode mode) : mode_(mode) {}

  /// One more station with stations beyond it: its e_k.
  void add(const Eigen::Vector3d& e) {
    if (mode_ == PropagationMode::random)
      past_ += e * e.transpose();
    else
      sum_ += e;
  }
  /// The next station belongs to another survey leg.
  void end_leg() {
    if (mode_ != PropagationMode::systematic) return;
    past_ += sum_ * sum_.transpose();
    sum_.setZero();
  }
  /// Covariance (m2) at a station whose own effect is `e_star`; the stations before it were added.
  Eigen::Matrix3d covariance(const Eigen::Vector3d& e_star) const {
    const Eigen::Vector3d e = sum_ + e_star;
    return past_ + e * e.transpose();
  }
  /// Covariance (m2) of what was added.
  Eigen::Matrix3d covariance() const { return covariance(Eigen::Vector3d::Zero()); }

 private:
  PropagationMode mode_;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d past_ = Eigen::Matrix3d::Zero();
};

}  // namespace surveymc::propagate
