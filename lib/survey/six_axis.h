#pragma once
#include <vector>

#include "survey/frames.h"

namespace surveymc::survey {

/// Readings of a tool in one run: six axes per station, in the tool frame. Measured depths increase.
struct SixAxisReadings {
  std::vector<double> md;                ///< m
  std::vector<Vec3<double>> gravity_T;   ///< accelerometers, m/s2, pointing down (the sign of frames.h)
  std::vector<Vec3<double>> magnetic_T;  ///< magnetometers, nT
  /// The user's accelerometers are this times gravity_T: 1, or -1 where they read the specific force. Errors of them
  /// are reported in the user's sign.
  double accelerometer_sign = 1;

  int size() const { return static_cast<int>(md.size()); }
};

}  // namespace surveymc::survey
