#pragma once
#include <cstdint>

#include <Eigen/Core>

#include "random/stream.h"

namespace surveymc::test {

/// Standard normal numbers of `trials` trials from `first` on, one row each.
inline Eigen::MatrixXd normal_draws(const random::Stream& stream, std::uint64_t first, int trials, int columns) {
  return Eigen::MatrixXd::NullaryExpr(trials, columns, [&](Eigen::Index trial, Eigen::Index column) {
    return stream.normal(first + static_cast<std::uint64_t>(trial), random::Channel::magnetometer_noise,
                         static_cast<std::uint32_t>(column));
  });
}

}  // namespace surveymc::test
