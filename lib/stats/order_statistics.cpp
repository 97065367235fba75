#include "stats/order_statistics.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace surveymc::stats {

double sorted_quantile(const std::vector<double>& sorted, double share) {
  const auto rank =
      static_cast<std::size_t>(std::max(1.0, std::ceil(share * static_cast<double>(sorted.size()) - 1e-9)));
  return sorted[std::min(rank, sorted.size()) - 1];
}

double median(std::vector<double> x) {
  if (x.empty()) return kNaN;
  const auto half = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), half, x.end());
  return x.size() % 2 == 1 ? *half : (*half + *std::max_element(x.begin(), half)) / 2;
}

Interval median_interval(const std::vector<double>& sorted, double confidence) {
  const std::size_t n = sorted.size();
  // Logarithms: 2^-n is 0 from n = 1075 on.
  double log_term = -static_cast<double>(n) * std::log(2.0), below = std::exp(log_term);
  std::size_t l = 0;
  while (l < n / 2 && below <= (1 - confidence) / 2) {
    ++l;
    log_term += std::log(static_cast<double>(n - l + 1) / static_cast<double>(l));
    below += std::exp(log_term);
  }
  if (l == 0) return {0, kInfinity};
  return {sorted[l - 1], sorted[n - l]};
}

}  // namespace surveymc::stats
