#pragma once
/// Modes of a hybrid gyro along a leg: a compass at every station of the upper hole, continuous beyond (SPE 90408).
///
/// 1. Stationary until the inclination reaches initialise_at, and again when it falls below; then initialised anew.
///    A tool that is initialised at the start of the leg is so from the first station on.
/// 2. While it is initialised, every stationary function keeps the value at Inc = initialise_at and the azimuth
///    listed at the last station before ("leg start": inclination and azimuth of the tie-on).
/// 3. A section lasts from the end of the one before, or the beginning of the leg, to its own end: the stationary
///    stretch before the initialisation belongs to it.
/// Rule 2 takes the azimuth that a survey lists for a vertical station, although it means nothing: only so are the
/// numbers of appendix E of SPE 90408 reproduced.
#include <cstddef>
#include <vector>

#include "error_model/model.h"
#include "survey/survey.h"

namespace surveymc::propagate {

/// Stations of one mode, one after the other.
struct GyroStretch {
  std::size_t first = 0, end = 0;  ///< stations, the last one is end - 1
  int section = 0;                 ///< from 0 in every leg
  bool is_continuous = false;
  /// Of a continuous stretch: inclination and azimuth at which the stationary functions keep their values, rad.
  double initialised_inclination = 0, initialised_azimuth = 0;
  std::size_t initialised_from = 0;  ///< the station whose azimuth that is
  bool azimuth_is_of_vertical_station = false;
};

/// The stretches of the leg with the stations first to end - 1; first >= 1.
std::vector<GyroStretch> gyro_stretches(const survey::Survey& survey, std::size_t first, std::size_t end,
                                        const error_model::Gyro& gyro);

/// The zone of `axis` that an inclination (rad) is in; null if it is in none. The last zone of all has no upper end.
const error_model::GyroZone* zone_at(const error_model::Gyro& gyro, const std::string& axis, double inclination);

}  // namespace surveymc::propagate
