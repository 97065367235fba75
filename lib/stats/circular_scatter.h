#pragma once
/// Common sd of the two directions of a plane, where both have the same.
#include <cstdint>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Variation of (x - mx)^2 + (y - my)^2 over the square of its mean, of variables whose kurtosis is known:
///   ((kx - 1) vx^2 + (ky - 1) vy^2 + 2 c) / (vx + vy)^2,   c = cov(x^2, y^2).
/// It is 1 for independent normal values of equal variance; less is taken as 1, on the safe side.
struct CircularScatter {
  std::uint64_t count = 0;                ///< of points
  double variance_x = 0, variance_y = 0;  ///< unbiased
  double kurtosis_x = 3, kurtosis_y = 3;  ///< of the sample
  double covariance_of_squares = 0;       ///< c
  double relative_variance() const;
  double sd() const;  ///< root of the mean of both variances
};

/// Interval of sd(): chi-squared with 2 (n - 1) / relative_variance() degrees of freedom. Normal points give
/// 2 (n - 1): the interval is narrower by the root of 2 than that of one direction.
Interval circular_sd_interval(const CircularScatter& s, double confidence);
/// The same at all looks of a run: ln sd -+ c(n) sqrt(relative_variance() / (4 n)) (confidence_sequence.h).
Interval circular_sd_sequence(const CircularScatter& s, double confidence);

}  // namespace surveymc::stats
