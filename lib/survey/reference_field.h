#pragma once
namespace surveymc::survey {

/// The reference field at the well, by a global model or a magnetic survey.
struct ReferenceField {
  double gravity = 9.80665;  ///< m/s2
  double total = 0;          ///< nT
  double dip = 0;            ///< rad, positive down
  double declination = 0;    ///< rad, positive east: true azimuth = magnetic azimuth + declination
  double convergence = 0;    ///< rad: true azimuth = grid azimuth + convergence
};

}  // namespace surveymc::survey
