#include <algorithm>
#include <cmath>

#include "chained_performance_tables.h"

namespace surveymc {
namespace {

constexpr std::size_t kPerEstimator = 3 * kChainedQuantities + kChainedZ + 2;
constexpr std::size_t kCountsPerEstimator = 2 * kChainedQuantities + 3 * PerformanceLayout::kBins;
constexpr int kMostAlong = 200;  // stations: their table has a covariance of this size behind it

QuantityArray mean_squares(const RunCheck& run) {
  QuantityArray sum{};
  for (const StationCheck& c : run.stations)
    for (std::size_t q = 0; q < kChainedQuantities; ++q)
      sum[q] += c.error[q] * c.error[q] / static_cast<double>(run.stations.size());
  return sum;
}

std::size_t bin_of(double x, double first, double width) {
  const double place = std::floor((x - first) / width);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(PerformanceLayout::kBins - 1)));
}

Eigen::Index index(std::size_t estimator, std::size_t place) {
  return static_cast<Eigen::Index>(estimator * kPerEstimator + place);
}

}  // namespace

PerformanceLayout::PerformanceLayout(const ChainedScenario& s, std::size_t kept_runs)
    : estimators_(s.estimators.size()), kept_(kept_runs), along_(s.stations() <= kMostAlong) {
  for (std::size_t e = 0; e < estimators_; ++e) {
    chained_.push_back(is_chained(s.estimators[e]));
    if (s.estimators[e] == ChainedEstimator::single) single_ = static_cast<int>(e);
  }
  cost_width_ = 2 * 3.0 * s.stations() / kBins;  // twice the expected cost is the last bin
  number_count_ = static_cast<Eigen::Index>(estimators_ * kPerEstimator);
  count_count_ = estimators_ * kCountsPerEstimator;
}

using Index = Eigen::Index;
Index PerformanceLayout::square(std::size_t e, std::size_t q) const { return index(e, q); }
Index PerformanceLayout::claimed(std::size_t e, std::size_t q) const { return index(e, kChainedQuantities + q); }
Index PerformanceLayout::worse(std::size_t e, std::size_t q) const { return index(e, 2 * kChainedQuantities + q); }
Index PerformanceLayout::z_square(std::size_t e, std::size_t z) const { return index(e, 3 * kChainedQuantities + z); }
Index PerformanceLayout::nees(std::size_t e) const { return index(e, 3 * kChainedQuantities + kChainedZ); }
Index PerformanceLayout::cost(std::size_t e) const { return index(e, 3 * kChainedQuantities + kChainedZ + 1); }
std::size_t PerformanceLayout::worse_runs(std::size_t e, std::size_t q) const { return e * kCountsPerEstimator + q; }
std::size_t PerformanceLayout::worse_last(std::size_t e, std::size_t q) const {
  return worse_runs(e, kChainedQuantities + q);
}
std::size_t PerformanceLayout::z_bin(std::size_t e) const { return worse_runs(e, 2 * kChainedQuantities); }
std::size_t PerformanceLayout::nees_bin(std::size_t e) const { return z_bin(e) + kBins; }
std::size_t PerformanceLayout::cost_bin(std::size_t e) const { return z_bin(e) + 2 * kBins; }

void PerformanceLayout::add(const std::vector<RunCheck>& checks,
                            Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> numbers,
                            std::vector<Eigen::MatrixXd>& along, Index row, std::vector<std::uint64_t>& counts) const {
  for (std::size_t e = 0; e < estimators_; ++e) {
    const RunCheck& run = checks[e];
    const double per_station = 1 / static_cast<double>(run.stations.size());
    const QuantityArray squares = mean_squares(run);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) numbers[square(e, q)] = squares[q];
    if (along_)
      for (std::size_t k = 0; k < run.stations.size(); ++k)
        for (std::size_t q = 0; q < kChainedQuantities; ++q) {
          const double x = run.stations[k].error[q];
          along[group(e, q)](row, static_cast<Index>(k)) = x * x;
        }
    if (!chained_[e]) continue;
    for (const StationCheck& c : run.stations) {
      for (std::size_t q = 0; q < kChainedQuantities; ++q)
        numbers[claimed(e, q)] += c.claimed_sd[q] * c.claimed_sd[q] * per_station;
      for (std::size_t z = 0; z < kChainedZ; ++z) {
        numbers[z_square(e, z)] += c.z[z] * c.z[z] * per_station;
        ++counts[z_bin(e) + bin_of(c.z[z], kZFirst, kZWidth)];
      }
      numbers[nees(e)] += c.nees * per_station;
      ++counts[nees_bin(e) + bin_of(c.nees, 0, kNeesWidth)];
    }
    numbers[cost(e)] = run.cost;
    ++counts[cost_bin(e) + bin_of(run.cost, 0, cost_width_)];
    if (single_ < 0) continue;
    const RunCheck& other = checks[static_cast<std::size_t>(single_)];
    const QuantityArray others = mean_squares(other);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      if (squares[q] > others[q]) {
        ++counts[worse_runs(e, q)];
        numbers[worse(e, q)] = std::sqrt(squares[q]);
      }
      counts[worse_last(e, q)] += std::abs(run.stations.back().error[q]) > std::abs(other.stations.back().error[q]);
    }
  }
}

void PerformanceLayout::keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const {
  for (const RunCheck& run : checks)
    for (const double square : mean_squares(run)) samples.push_back(std::sqrt(square));
}

}  // namespace surveymc
