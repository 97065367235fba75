#pragma once
/// The twelve constant errors of a tool's two triads: per axis, reading = (1 + scale) value + bias.
#include <array>

namespace surveymc::survey {

inline constexpr int kSensorTerms = 12;
/// Index of the first of the three axes x, y, z of each kind. The order is part of the address of random numbers.
enum SensorTerm {
  kAccelerometerBias = 0,   ///< m/s2
  kAccelerometerScale = 3,  ///< 1
  kMagnetometerBias = 6,    ///< nT
  kMagnetometerScale = 9,   ///< 1
};
/// One value a term: errors, or their standard deviations.
using SensorTermArray = std::array<double, kSensorTerms>;

/// ISCWSA's codes: accelerometer or magnetometer, bias or scale, axis.
inline constexpr std::array<const char*, kSensorTerms> kSensorTermCodes{"ABX", "ABY", "ABZ", "ASX", "ASY", "ASZ",
                                                                        "MBX", "MBY", "MBZ", "MSX", "MSY", "MSZ"};

/// The same sizes for all axes.
constexpr SensorTermArray equal_axes(double accelerometer_bias, double accelerometer_scale, double magnetometer_bias,
                                     double magnetometer_scale) {
  const double a = accelerometer_bias, b = accelerometer_scale, c = magnetometer_bias, d = magnetometer_scale;
  return {a, a, a, b, b, b, c, c, c, d, d, d};
}

}  // namespace surveymc::survey
