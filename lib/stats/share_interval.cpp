#include "stats/share_interval.h"

#include <algorithm>

#include "stats/beta_quantile.h"

namespace surveymc::stats {

Interval share_interval(double mean, double variance, std::uint64_t count, double confidence) {
  const double tail = (1 - confidence) / 2, least = static_cast<double>(count);
  // Shares vary no more than events of their probability, so there are `count` of these or more
  double n = least;
  if (variance > 0 && mean > 0 && mean < 1) n = std::max(least, least * mean * (1 - mean) / variance);
  const double k = mean * n;
  return {k > 0 ? beta_quantile(k, n - k + 1, tail).share : 0,
          k < n ? beta_upper_quantile(k + 1, n - k, tail).share : 1};
}

}  // namespace surveymc::stats
