#pragma once
/// What a tool code claims of a survey, parted into what a correction of magnetometers can change and what it cannot.
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "error_model/model.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::propagate {

/// Sizes at the stations of a survey, one code or a part of it.
struct ClaimedErrors {
  Eigen::Matrix3d position = Eigen::Matrix3d::Zero();  ///< covariance of the last station: N, E, V (true north), m2
  /// Variance of sinI times the azimuth of every station, rad2; 0 at the tie-on. Of terms that turn the hole: errors of
  /// depth and of the course do not.
  std::vector<double> azimuth;
};

/// A code ready to be asked about many wells.
class ClaimedCode {
 public:
  /// Throws InputError by the term's name if the code has a term of another kind of tool.
  explicit ClaimedCode(const error_model::Model& model);

  bool first_leg_doubled() const { return magnetic_->first_leg_doubled; }
  /// Of the terms of sensors and reference. Their sum with carried() is that of tool_covariances().
  ClaimedErrors magnetic(const survey::Survey& survey, const survey::ReferenceField& field) const;
  /// Of depth, sag, misalignment and course.
  ClaimedErrors carried(const survey::Survey& survey, const survey::ReferenceField& field) const;

 private:
  std::shared_ptr<const error_model::Model> magnetic_, carried_turning_, carried_rest_;
};

}  // namespace surveymc::propagate
