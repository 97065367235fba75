#include "stats/tally.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace surveymc::stats {

using Eigen::Index;

Moments::Moments(Index d)
    : mean(Eigen::VectorXd::Zero(d)),
      squares(Eigen::MatrixXd::Zero(d, d)),
      cubes(Eigen::VectorXd::Zero(d)),
      fourths(Eigen::VectorXd::Zero(d)) {}

namespace {

/// sum_t f(t) in eight partial sums: the compiler may compute them side by side, without changing the bits.
template <class F>
double ordered_sum(Index n, F f) {
  double s[8] = {};
  Index t = 0;
  for (; t + 8 <= n; t += 8)
    for (Index i = 0; i < 8; ++i) s[i] += f(t + i);
  for (Index i = 0; t + i < n; ++i) s[i] += f(t + i);
  return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

}  // namespace

Moments Moments::of(const Eigen::Ref<const Eigen::MatrixXd>& x) {
  const Index n = x.rows(), d = x.cols();
  Moments m(d);
  m.count = static_cast<std::uint64_t>(n);
  if (n == 0) return m;
  Eigen::MatrixXd r(n, d);
  for (Index c = 0; c < d; ++c) {
    const double* v = x.data() + c * x.outerStride();
    // Differences from the first value: positions of kilometres with errors of metres keep their digits.
    m.mean[c] = v[0] + ordered_sum(n, [v](Index t) { return v[t] - v[0]; }) / static_cast<double>(n);
    double* rc = r.data() + c * n;
    const double mean = m.mean[c];
    for (Index t = 0; t < n; ++t) rc[t] = v[t] - mean;
    m.cubes[c] = ordered_sum(n, [rc](Index t) { return rc[t] * rc[t] * rc[t]; });
    m.fourths[c] = ordered_sum(n, [rc](Index t) { return (rc[t] * rc[t]) * (rc[t] * rc[t]); });
    m.squares(c, c) = ordered_sum(n, [rc](Index t) { return rc[t] * rc[t]; });
    if (m.squares(c, c) == 0) continue;  // a quantity that is not observed has no covariance
    for (Index i = 0; i < c; ++i) {
      const double* ri = r.data() + i * n;
      if (m.squares(i, i) == 0) continue;
      m.squares(i, c) = m.squares(c, i) = ordered_sum(n, [ri, rc](Index t) { return ri[t] * rc[t]; });
    }
  }
  return m;
}

void Moments::merge(const Moments& o) {
  if (o.count == 0) return;
  if (count == 0) {
    *this = o;
    return;
  }
  assert(mean.size() == o.mean.size());
  const double na = static_cast<double>(count), nb = static_cast<double>(o.count), n = na + nb;
  for (Index i = 0; i < mean.size(); ++i) {
    const double d = o.mean[i] - mean[i], sa = squares(i, i), sb = o.squares(i, i);
    fourths[i] += o.fourths[i] + d * d * d * d * na * nb * (na * na - na * nb + nb * nb) / (n * n * n) +
                  6 * d * d * (na * na * sb + nb * nb * sa) / (n * n) + 4 * d * (na * o.cubes[i] - nb * cubes[i]) / n;
    cubes[i] += o.cubes[i] + d * d * d * na * nb * (na - nb) / (n * n) + 3 * d * (na * sb - nb * sa) / n;
  }
  for (Index c = 0; c < mean.size(); ++c)
    for (Index i = 0; i < mean.size(); ++i)
      squares(i, c) += o.squares(i, c) + (o.mean[i] - mean[i]) * (o.mean[c] - mean[c]) * (na * nb / n);
  for (Index i = 0; i < mean.size(); ++i) mean[i] += (o.mean[i] - mean[i]) * (nb / n);
  count += o.count;
}

double Moments::skewness(Index i) const {
  const double n = static_cast<double>(count);
  return std::sqrt(n) * cubes[i] / std::pow(squares(i, i), 1.5);
}

double Moments::kurtosis(Index i) const {
  return static_cast<double>(count) * fourths[i] / (squares(i, i) * squares(i, i));
}

namespace {

void merge_each(std::vector<Moments>& all, const std::vector<Moments>& next) {
  if (all.size() < next.size()) all.resize(next.size());
  for (std::size_t i = 0; i < next.size(); ++i) all[i].merge(next[i]);
}

}  // namespace

bool can_merge(const Tally& a, const Tally& b) {
  const auto alike = [](const Moments& x, const Moments& y) {
    return x.count == 0 || y.count == 0 || x.mean.size() == y.mean.size();
  };
  const auto all_alike = [&](const std::vector<Moments>& x, const std::vector<Moments>& y) {
    return std::equal(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(std::min(x.size(), y.size())), y.begin(),
                      alike);
  };
  const bool same_counts = a.counts.empty() || b.counts.empty() || a.counts.size() == b.counts.size();
  const bool same_weights = (a.weighted.empty() || b.weighted.empty() || a.weighted.size() == b.weighted.size()) &&
                            (a.proposal == 0 || b.proposal == 0 || a.proposal == b.proposal);
  return same_counts && same_weights && alike(a.moments, b.moments) && alike(a.pairs, b.pairs) &&
         all_alike(a.groups, b.groups) && all_alike(a.controlled, b.controlled) &&
         all_alike(a.controlled_pairs, b.controlled_pairs);
}

void Tally::add_failed(std::uint64_t trial) {
  ++failed;
  if (failed_trials.size() < kMaxListed) failed_trials.push_back(trial);
}

void Tally::merge(const Tally& next) {
  trials += next.trials;
  failed += next.failed;
  left_out += next.left_out;
  moments.merge(next.moments);
  merge_each(groups, next.groups);
  merge_each(controlled, next.controlled);
  pairs.merge(next.pairs);
  merge_each(controlled_pairs, next.controlled_pairs);
  if (counts.size() < next.counts.size()) counts.resize(next.counts.size(), 0);
  for (std::size_t i = 0; i < next.counts.size(); ++i) counts[i] += next.counts[i];
  const std::size_t room = kMaxListed - std::min(kMaxListed, failed_trials.size());
  failed_trials.insert(
      failed_trials.end(), next.failed_trials.begin(),
      next.failed_trials.begin() + static_cast<std::ptrdiff_t>(std::min(room, next.failed_trials.size())));
  samples.insert(samples.end(), next.samples.begin(), next.samples.end());
  if (weighted.size() < next.weighted.size()) weighted.resize(next.weighted.size());
  for (std::size_t i = 0; i < next.weighted.size(); ++i) weighted[i].merge(next.weighted[i]);
  assert(proposal == 0 || next.proposal == 0 || proposal == next.proposal);
  if (proposal == 0) proposal = next.proposal;
}

}  // namespace surveymc::stats
