#include "monitoring/training.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace surveymc::monitoring {

Samples Scaling::to_z(const Samples& readings) const {
  return ((readings.rowwise() - mean).array().rowwise() / sd.array()).matrix();
}

Samples Scaling::from_z(const Samples& z) const {
  return ((z.array().rowwise() * sd.array()).matrix().rowwise() + mean);
}

Eigen::RowVectorXd population_sd(const Samples& x) {
  const Eigen::RowVectorXd mean = x.colwise().mean();
  return ((x.rowwise() - mean).array().square().colwise().mean()).sqrt().matrix();
}

Scaling fit_scaling(const Samples& training) {
  require(training.rows() >= 2, "training: {} samples: must be at least 2", training.rows());
  Scaling s{training.colwise().mean(), population_sd(training)};
  for (Eigen::Index j = 0; j < s.sd.size(); ++j)
    require(s.sd[j] > 1e-12 * std::abs(s.mean[j]), "training: sensor {} does not vary: it cannot be monitored", j + 1);
  return s;
}

std::vector<Eigen::Index> select_memory(const Samples& z, Eigen::Index count) {
  const Eigen::Index n = z.rows();
  require(count >= 2 * z.cols() && count <= n,
          "memory: {} vectors: must be at least 2 for each of {} sensors and at most the {} training samples", count,
          z.cols(), n);
  std::vector<Eigen::Index> chosen;
  std::vector<bool> taken(static_cast<std::size_t>(n), false);
  const auto take = [&](Eigen::Index i) {
    if (taken[static_cast<std::size_t>(i)]) return;
    taken[static_cast<std::size_t>(i)] = true;
    chosen.push_back(i);
  };
  for (Eigen::Index j = 0; j < z.cols(); ++j) {
    Eigen::Index largest = 0, smallest = 0;
    for (Eigen::Index i = 1; i < n; ++i) {
      if (z(i, j) > z(largest, j)) largest = i;
      if (z(i, j) < z(smallest, j)) smallest = i;
    }
    take(largest);
    take(smallest);
  }
  const Eigen::VectorXd norm = z.rowwise().norm();
  std::vector<Eigen::Index> rest;
  for (Eigen::Index i = 0; i < n; ++i)
    if (!taken[static_cast<std::size_t>(i)]) rest.push_back(i);
  std::stable_sort(rest.begin(), rest.end(), [&](Eigen::Index a, Eigen::Index b) { return norm[a] < norm[b]; });
  const auto missing = static_cast<std::size_t>(count) - chosen.size();
  for (std::size_t k = 0; k < missing; ++k) chosen.push_back(rest[k * rest.size() / missing]);
  return chosen;
}

Samples rows_of(const Samples& x, const std::vector<Eigen::Index>& rows) {
  Samples out(static_cast<Eigen::Index>(rows.size()), x.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = x.row(rows[i]);
  return out;
}

}  // namespace surveymc::monitoring
