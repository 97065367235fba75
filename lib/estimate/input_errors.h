#pragma once
#include <cmath>

#include "base/error.h"

namespace surveymc::estimate {

/// Sizes of the errors of an estimator's inputs, one standard deviation each: the true sizes, for a prediction, or the
/// sizes that an estimator assumes, for its weights and claims.
struct InputErrors {
  double magnetometer = 0;             ///< nT per axis and station
  double down = 0;                     ///< rad per cross-axis direction: accelerometer noise / gravity
  double total = 0;                    ///< nT, reference field
  double dip = 0;                      ///< rad, reference field
  bool reference_per_station = false;  ///< drawn anew at every station; else one error for the whole run
  double gain = 0;                     ///< of the true gains; as prior, about 1; 0: no prior
  double bias = 0;                     ///< nT, of the true biases; as prior, about 0; 0: no prior
  double axial_bias = 0;               ///< nT, added to bias z: interference of the drill string
  double station_total = 0;            ///< nT, disturbance of the true field, new at every station
  double station_dip = 0;              ///< rad, the same of its dip

  double bias_sd(int axis) const { return axis == 2 ? std::hypot(bias, axial_bias) : bias; }
};

/// Throws InputError where the magnetometers' size cannot serve as a weight.
inline void require_weights(const InputErrors& assumed) {
  require(assumed.magnetometer > 0,
          "estimator.magnetometer_nT = {}: must be > 0: this estimator weighs the readings by it",
          assumed.magnetometer);
}

}  // namespace surveymc::estimate
