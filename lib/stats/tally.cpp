#include "stats/tally.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace surveymc {

using Eigen::Index;

Moments::Moments(Index d)
    : mean(Eigen::VectorXd::Zero(d)),
      squares(Eigen::MatrixXd::Zero(d, d)),
      cubes(Eigen::VectorXd::Zero(d)),
      fourths(Eigen::VectorXd::Zero(d)) {}

Moments Moments::of(const Eigen::Ref<const Eigen::MatrixXd>& x) {
  Moments m(x.rows());
  m.count = static_cast<std::uint64_t>(x.cols());
  if (m.count == 0) return m;
  // Plain loops in a fixed order: Eigen's reductions and products choose theirs by the vector width.
  const Index d = x.rows(), n = x.cols();
  // Sums of differences from the first value: positions of kilometres with errors of metres keep their digits.
  for (Index j = 1; j < n; ++j)
    for (Index i = 0; i < d; ++i) m.mean[i] += x(i, j) - x(i, 0);
  for (Index i = 0; i < d; ++i) m.mean[i] = x(i, 0) + m.mean[i] / static_cast<double>(n);
  std::vector<double> r(static_cast<std::size_t>(d));
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < d; ++i) r[static_cast<std::size_t>(i)] = x(i, j) - m.mean[i];
    for (Index c = 0; c < d; ++c) {
      const double rc = r[static_cast<std::size_t>(c)], rc2 = rc * rc;
      for (Index i = c; i < d; ++i) m.squares(i, c) += r[static_cast<std::size_t>(i)] * rc;
      m.cubes[c] += rc2 * rc;
      m.fourths[c] += rc2 * rc2;
    }
  }
  for (Index c = 0; c < d; ++c)
    for (Index i = 0; i < c; ++i) m.squares(i, c) = m.squares(c, i);
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

void Tally::merge(const Tally& next) {
  trials += next.trials;
  failed += next.failed;
  moments.merge(next.moments);
  if (counts.size() < next.counts.size()) counts.resize(next.counts.size(), 0);
  for (std::size_t i = 0; i < next.counts.size(); ++i) counts[i] += next.counts[i];
  const std::size_t room = kMaxListed - std::min(kMaxListed, failed_trials.size());
  failed_trials.insert(
      failed_trials.end(), next.failed_trials.begin(),
      next.failed_trials.begin() + static_cast<std::ptrdiff_t>(std::min(room, next.failed_trials.size())));
  samples.insert(samples.end(), next.samples.begin(), next.samples.end());
}

}  // namespace surveymc
