#include "stats/share_interval.h"

#include <algorithm>

#include <boost/math/distributions/beta.hpp>

namespace surveymc::stats {

Interval share_interval(double mean, double variance, std::uint64_t count, double confidence) {
  namespace bm = boost::math;
  const double tail = (1 - confidence) / 2, least = static_cast<double>(count);
  // Shares vary no more than events of their probability, so there are `count` of these or more
  double n = least;
  if (variance > 0 && mean > 0 && mean < 1) n = std::max(least, least * mean * (1 - mean) / variance);
  const double k = mean * n;
  return {k > 0 ? bm::quantile(bm::beta_distribution<>(k, n - k + 1), tail) : 0,
          k < n ? bm::quantile(bm::complement(bm::beta_distribution<>(k + 1, n - k), tail)) : 1};
}

}  // namespace surveymc::stats
