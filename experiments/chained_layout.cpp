#include <algorithm>
#include <cmath>

#include "chained_performance_tables.h"

namespace surveymc {
namespace {

constexpr std::size_t kPerEstimator = 3 * kChainedQuantities + kChainedZ + 2;
constexpr std::size_t kCountsPerEstimator = 2 * kChainedQuantities + 3 * PerformanceLayout::kBins + kChainedStatuses;
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

}  // namespace

PerformanceLayout::PerformanceLayout(const ChainedScenario& s, std::size_t kept_runs)
    : estimators_(s.estimators.size()), kept_(kept_runs), along_(s.stations() <= kMostAlong) {
  for (std::size_t e = 0; e < estimators_; ++e) {
    chained_.push_back(is_chained(s.estimators[e]));
    if (s.estimators[e] == ChainedEstimator::single) single_ = static_cast<int>(e);
  }
  cost_width_ = 2 * 3.0 * s.stations() / kBins;  // twice the expected cost is the last bin
  count_count_ = estimators_ * kCountsPerEstimator;
}

using Index = Eigen::Index;
Index PerformanceLayout::numbers() const { return static_cast<Index>(kPerEstimator); }
Index PerformanceLayout::square(std::size_t q) const { return static_cast<Index>(q); }
Index PerformanceLayout::claimed(std::size_t q) const { return static_cast<Index>(kChainedQuantities + q); }
Index PerformanceLayout::worse(std::size_t q) const { return static_cast<Index>(2 * kChainedQuantities + q); }
Index PerformanceLayout::z_square(std::size_t z) const { return static_cast<Index>(3 * kChainedQuantities + z); }
Index PerformanceLayout::nees() const { return static_cast<Index>(3 * kChainedQuantities + kChainedZ); }
Index PerformanceLayout::cost() const { return nees() + 1; }
const Moments& PerformanceLayout::moments(const Tally& tally, std::size_t e) const {
  static const Moments none;
  return tally.groups.empty() ? none : tally.groups[e];
}
std::size_t PerformanceLayout::worse_runs(std::size_t e, std::size_t q) const { return e * kCountsPerEstimator + q; }
std::size_t PerformanceLayout::worse_last(std::size_t e, std::size_t q) const {
  return worse_runs(e, kChainedQuantities + q);
}
std::size_t PerformanceLayout::z_bin(std::size_t e) const { return worse_runs(e, 2 * kChainedQuantities); }
std::size_t PerformanceLayout::nees_bin(std::size_t e) const { return z_bin(e) + kBins; }
std::size_t PerformanceLayout::cost_bin(std::size_t e) const { return z_bin(e) + 2 * kBins; }

std::size_t PerformanceLayout::ended(std::size_t e, ChainedStatus status) const {
  return z_bin(e) + 3 * kBins + static_cast<std::size_t>(status);
}
std::uint64_t PerformanceLayout::failed(const Tally& tally, std::size_t e) const {
  std::uint64_t sum = 0;
  for (std::size_t s = 1; s < kChainedStatuses && !tally.counts.empty(); ++s)
    sum += tally.counts[ended(e, static_cast<ChainedStatus>(s))];
  return sum;
}

PerformanceLayout::Block PerformanceLayout::block(Index trials, int stations) const {
  return {std::vector<Eigen::MatrixXd>(estimators_, Eigen::MatrixXd::Zero(trials, numbers())),
          std::vector<Eigen::MatrixXd>(along_groups(), Eigen::MatrixXd::Zero(trials, stations)),
          std::vector<Index>(estimators_, 0)};
}

std::vector<Moments> PerformanceLayout::groups(const Block& b) const {
  std::vector<Moments> out;
  for (std::size_t e = 0; e < estimators_; ++e) out.push_back(Moments::of(b.numbers[e].topRows(b.rows[e])));
  for (std::size_t g = 0; g < b.along.size(); ++g)
    out.push_back(Moments::of(b.along[g].topRows(b.rows[g / kChainedQuantities])));
  return out;
}

void PerformanceLayout::add(const std::vector<RunCheck>& checks, Block& block,
                            std::vector<std::uint64_t>& counts) const {
  for (std::size_t e = 0; e < estimators_; ++e) {
    const RunCheck& run = checks[e];
    ++counts[ended(e, run.status)];
    if (!run.converged()) continue;
    const Index row = block.rows[e]++;
    auto numbers = block.numbers[e].row(row);
    const double per_station = 1 / static_cast<double>(run.stations.size());
    const QuantityArray squares = mean_squares(run);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) numbers[square(q)] = squares[q];
    if (along_)
      for (std::size_t k = 0; k < run.stations.size(); ++k)
        for (std::size_t q = 0; q < kChainedQuantities; ++q) {
          const double x = run.stations[k].error[q];
          block.along[e * kChainedQuantities + q](row, static_cast<Index>(k)) = x * x;
        }
    if (!chained_[e]) continue;
    for (const StationCheck& c : run.stations) {
      for (std::size_t q = 0; q < kChainedQuantities; ++q)
        numbers[claimed(q)] += c.claimed_sd[q] * c.claimed_sd[q] * per_station;
      for (std::size_t z = 0; z < kChainedZ; ++z) {
        numbers[z_square(z)] += c.z[z] * c.z[z] * per_station;
        ++counts[z_bin(e) + bin_of(c.z[z], kZFirst, kZWidth)];
      }
      numbers[nees()] += c.nees * per_station;
      ++counts[nees_bin(e) + bin_of(c.nees, 0, kNeesWidth)];
    }
    numbers[cost()] = run.cost;
    ++counts[cost_bin(e) + bin_of(run.cost, 0, cost_width_)];
    if (single_ < 0) continue;
    const RunCheck& other = checks[static_cast<std::size_t>(single_)];
    const QuantityArray others = mean_squares(other);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      if (squares[q] > others[q]) {
        ++counts[worse_runs(e, q)];
        numbers[worse(q)] = std::sqrt(squares[q]);
      }
      counts[worse_last(e, q)] += std::abs(run.stations.back().error[q]) > std::abs(other.stations.back().error[q]);
    }
  }
}

void PerformanceLayout::keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const {
  for (const RunCheck& run : checks)
    for (const double square : mean_squares(run)) samples.push_back(run.converged() ? std::sqrt(square) : std::nan(""));
}

}  // namespace surveymc
