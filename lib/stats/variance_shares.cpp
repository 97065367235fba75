#include "stats/variance_shares.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace surveymc::stats {

namespace {

/// What is left of y about its mean, or plane, in each group; and how many coefficients each group's plane has.
struct Residuals {
  std::vector<double> of_value;
  std::vector<std::size_t> coefficients;
};

Residuals residuals_of(const std::vector<double>& y, const std::vector<std::uint32_t>& group, std::uint32_t groups,
                       const std::vector<double>& size, const std::vector<const std::vector<double>*>& slopes) {
  const auto sums_of = [&](const auto& value) {
    std::vector<double> sum(groups, 0);
    for (std::size_t i = 0; i < y.size(); ++i) sum[group[i]] += value(i);
    return sum;
  };
  const auto centred = [&](std::vector<double> x) {
    const std::vector<double> sum = sums_of([&](std::size_t i) { return x[i]; });
    for (std::size_t i = 0; i < x.size(); ++i) x[i] -= sum[group[i]] / size[group[i]];
    return x;
  };
  // Gram and Schmidt, in all groups at once: a slope less what those before it explain
  std::vector<std::vector<double>> basis;
  const auto remove = [&](std::vector<double>& x, const std::vector<double>& b) {
    const std::vector<double> bb = sums_of([&](std::size_t i) { return b[i] * b[i]; }),
                              bx = sums_of([&](std::size_t i) { return b[i] * x[i]; });
    for (std::size_t i = 0; i < x.size(); ++i)
      if (bb[group[i]] > 0) x[i] -= bx[group[i]] / bb[group[i]] * b[i];
  };
  Residuals out{centred(y), std::vector<std::size_t>(groups, 1)};
  for (const std::vector<double>* slope : slopes) {
    std::vector<double> x = centred(*slope);
    const std::vector<double> all = sums_of([&](std::size_t i) { return (*slope)[i] * (*slope)[i]; });
    for (const std::vector<double>& b : basis) remove(x, b);
    const std::vector<double> left = sums_of([&](std::size_t i) { return x[i] * x[i]; });
    constexpr double kRounding = 1e-20;  // of squares: equal values, or those of another slope
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!(left[group[i]] > kRounding * all[group[i]])) x[i] = 0;
    for (std::uint32_t g = 0; g < groups; ++g) out.coefficients[g] += left[g] > kRounding * all[g];
    remove(out.of_value, x);
    basis.push_back(std::move(x));
  }
  return out;
}

}  // namespace

ExplainedShare explained_share(const std::vector<double>& y, const std::vector<std::uint32_t>& group,
                               std::uint32_t groups, const std::vector<const std::vector<double>*>& slopes) {
  const std::size_t n = y.size();
  ExplainedShare out;
  out.influence.assign(n, kNaN);
  if (n < 2) return out;
  const double count = static_cast<double>(n), mean = std::accumulate(y.begin(), y.end(), 0.0) / count;
  std::vector<double> size(groups, 0);
  for (const std::uint32_t g : group) size[g] += 1;
  const Residuals residuals = residuals_of(y, group, groups, size, slopes);
  // Squares whose means are Var(y) and E[Var(y | group)], both without bias
  std::vector<double> whole(n), within(n, kNaN);
  double variance = 0, left = 0, judged = 0, squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double d = y[i] - mean, members = size[group[i]],
                 coefficients = static_cast<double>(residuals.coefficients[group[i]]), e = residuals.of_value[i];
    whole[i] = d * d * count / (count - 1);
    variance += whole[i] / count;
    squares += e * e;
    if (members <= coefficients) continue;
    within[i] = e * e * members / (members - coefficients);
    left += within[i];
    judged += 1;
  }
  if (!(variance > 0) || judged == 0) return out;
  left /= judged;
  out.share = 1 - left / variance;
  out.of_squares = 1 - squares / (variance * (count - 1));
  for (std::size_t i = 0; i < n; ++i)
    out.influence[i] =
        (left / variance * (whole[i] - variance) - (std::isnan(within[i]) ? 0 : within[i] - left)) / variance;
  return out;
}

double share_of_groups(const std::vector<double>& y, const std::vector<std::uint32_t>& group, std::uint32_t groups) {
  const double mean = std::accumulate(y.begin(), y.end(), 0.0) / static_cast<double>(y.size());
  std::vector<double> sum(groups, 0), size(groups, 0);
  double whole = 0, between = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    sum[group[i]] += y[i] - mean;
    size[group[i]] += 1;
    whole += (y[i] - mean) * (y[i] - mean);
  }
  for (std::uint32_t g = 0; g < groups; ++g)
    if (size[g] > 0) between += sum[g] * sum[g] / size[g];
  return whole > 0 ? between / whole : kNaN;
}

double chance_of_share(double freedom, double n) {
  return std::sqrt(2 * freedom / (std::max(1.0, n - 1 - freedom) * (n + 1)));
}

double standard_error_of(const std::vector<double>& influence) {
  const double n = static_cast<double>(influence.size());
  const double mean = std::accumulate(influence.begin(), influence.end(), 0.0) / n;
  double squares = 0;
  for (const double x : influence) squares += (x - mean) * (x - mean);
  return std::sqrt(squares / (n - 1) / n);
}

namespace {

std::vector<double> mean_ranks(const std::vector<double>& x) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  std::vector<double> ranks(x.size());
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && x[order[end]] == x[order[first]]) ++end;
    for (std::size_t i = first; i < end; ++i) ranks[order[i]] = static_cast<double>(first + end - 1) / 2;
  }
  return ranks;
}

}  // namespace

double rank_correlation(const std::vector<double>& x, const std::vector<double>& y) {
  const std::vector<double> a = mean_ranks(x), b = mean_ranks(y);
  const double middle = (static_cast<double>(x.size()) - 1) / 2;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - middle) * (a[i] - middle);
    bb += (b[i] - middle) * (b[i] - middle);
    ab += (a[i] - middle) * (b[i] - middle);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : kNaN;
}

}  // namespace surveymc::stats
