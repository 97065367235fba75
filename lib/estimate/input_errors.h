#pragma once
#include <cmath>

namespace surveymc::estimate {

/// Sizes of the errors of an estimator's inputs, one standard deviation each: what they are, for a prediction, or what
/// an estimator takes them to be, for its weights and claims.
struct InputErrors {
  double magnetometer = 0;             ///< nT per axis and station
  double down = 0;                     ///< rad per cross-axis direction: accelerometer noise / gravity
  double total = 0;                    ///< nT, reference field
  double dip = 0;                      ///< rad, reference field
  bool reference_per_station = false;  ///< drawn anew at every station; else one error for the whole run
  double gain = 0;                     ///< of the true gains; as prior, about 1; 0: no prior
  double bias = 0;                     ///< nT, of the true biases; as prior, about 0; 0: no prior
  double axial_bias = 0;               ///< nT, bias z has this too: interference of the drill string

  double bias_sd(int axis) const { return axis == 2 ? std::hypot(bias, axial_bias) : bias; }
};

}  // namespace surveymc::estimate
