#include "stats/circular_scatter.h"

#include <algorithm>
#include <cmath>

#include "stats/confidence_sequence.h"

namespace surveymc::stats {

double CircularScatter::relative_variance() const {
  const double sum = variance_x + variance_y;
  const double found = ((kurtosis_x - 1) * variance_x * variance_x + (kurtosis_y - 1) * variance_y * variance_y +
                        2 * covariance_of_squares) /
                       (sum * sum);
  return std::isfinite(found) ? std::max(1.0, found) : 1.0;
}

double CircularScatter::sd() const { return std::sqrt((variance_x + variance_y) / 2); }

Interval circular_sd_interval(const CircularScatter& s, double confidence) {
  const double tail = (1 - confidence) / 2;
  const double degrees = 2 * (static_cast<double>(s.count) - 1) / s.relative_variance();
  const auto bound = [&](double p) { return s.sd() * std::sqrt(degrees / chi_squared_quantile(degrees, p)); };
  return {bound(1 - tail), bound(tail)};
}

Interval circular_sd_sequence(const CircularScatter& s, double confidence) {
  const double half =
      sequence_quantile(s.count, confidence) * std::sqrt(s.relative_variance() / 4 / static_cast<double>(s.count));
  return {s.sd() * std::exp(-half), s.sd() * std::exp(half)};
}

}  // namespace surveymc::stats
