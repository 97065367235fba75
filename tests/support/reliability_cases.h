#pragma once
/// Levels, ways of adjustment, attitudes and readings that the tests of reliability share.
#include <array>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "least_squares_oracle.h"
#include "reliability/adjustment.h"
#include "reliability/significance.h"

namespace surveymc::test {

inline constexpr std::array kSingleModes{reliability::AdjustmentMode::sse, reliability::AdjustmentMode::sse_axial,
                                         reliability::AdjustmentMode::mse_fixed};
inline constexpr std::array kAllModes{reliability::AdjustmentMode::sse, reliability::AdjustmentMode::sse_axial,
                                      reliability::AdjustmentMode::mse_fixed, reliability::AdjustmentMode::mse_shared};

/// The paper's levels.
inline const reliability::TestLevels kLevels{1e-4, reliability::Tails::one, 0.8};
inline const double kLambda = reliability::lambda0(kLevels), kCritical = reliability::w_critical(kLevels);

inline reliability::AdjustmentModel model_of(reliability::AdjustmentMode mode, bool systematic = false,
                                             int stations = 30) {
  return {.mode = mode, .stations = stations, .systematic_terms = systematic};
}

inline survey::Attitude degrees(double inclination, double toolface, double azimuth) {
  return {inclination * kDegree, azimuth * kDegree, toolface * kDegree};
}

/// Error-free readings of one station.
inline std::array<double, 6> readings_at(const survey::Attitude& at, const survey::ReferenceField& field) {
  const reliability::Observations y = reliability::true_observations(at, field);
  return {y[0], y[1], y[2], y[3], y[4], y[5]};
}
inline std::array<double, 3> references(const survey::ReferenceField& f) { return {f.gravity, f.total, f.dip}; }

/// What an error of `size` in observation `row` of the oracle makes of angles and references is what the oracle has, to
/// 1e-8 of itself or `of_sd` of the standard deviation of the parameter. `e` names these effects as ErrorResponse does.
template <class Effects>
void check_effects(const Effects& e, const reliability::AdjustmentModel& m, const LeastSquares& l, int stations,
                   Eigen::Index row, double size, double of_sd) {
  const double found[] = {e.inclination, e.toolface, e.azimuth, e.gravity, e.total_field, e.dip};
  for (Eigen::Index j = 0; j < (m.mode == reliability::AdjustmentMode::mse_fixed ? 3 : 6); ++j) {
    const Eigen::Index parameter = j < 3 ? j : 3 * stations + j - 3;
    const double sd = std::sqrt((l.effect.row(parameter).array().square() * l.variance.transpose().array()).sum());
    const double expected = l.effect(parameter, row) * size;
    INFO("parameter " << j);
    CHECK_THAT(found[j], Catch::WithinAbs(expected, 1e-8 * std::abs(expected) + of_sd * sd));
  }
}

}  // namespace surveymc::test
