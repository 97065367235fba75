#include <algorithm>
#include <cmath>

#include "chained_performance_tables.h"

namespace surveymc {
namespace {

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
    : numbers(s.estimators.size()),
      counts(s.estimators.size()),
      groups(s.stations() <= kMostAlong ? s.estimators.size() : 0),
      kept_(kept_runs),
      cost_width_(2 * 3.0 * s.stations() / kBins) {  // twice the expected cost is the last bin
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    chained_.push_back(is_chained(s.estimators[e]));
    if (s.estimators[e] == ChainedEstimator::single) single_ = static_cast<int>(e);
  }
}

void PerformanceLayout::add(const std::vector<RunCheck>& checks,
                            Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> values,
                            std::vector<Eigen::MatrixXd>& along, Eigen::Index row,
                            std::vector<std::uint64_t>& events) const {
  for (std::size_t e = 0; e < chained_.size(); ++e) {
    const RunCheck& run = checks[e];
    const double per_station = 1 / static_cast<double>(run.stations.size());
    const QuantityArray squares = mean_squares(run);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) values[numbers.square(e, q)] = squares[q];
    if (groups.size() > 0)
      for (std::size_t k = 0; k < run.stations.size(); ++k)
        for (std::size_t q = 0; q < kChainedQuantities; ++q) {
          const double x = run.stations[k].error[q];
          along[groups.square(e, q)](row, static_cast<Eigen::Index>(k)) = x * x;
        }
    if (!chained_[e]) continue;
    for (const StationCheck& c : run.stations) {
      for (std::size_t q = 0; q < kChainedQuantities; ++q)
        values[numbers.claimed(e, q)] += c.claimed_sd[q] * c.claimed_sd[q] * per_station;
      for (std::size_t z = 0; z < kChainedZ; ++z) {
        values[numbers.z_square(e, z)] += c.z[z] * c.z[z] * per_station;
        ++events[counts.z(e, bin_of(c.z[z], kZFirst, kZWidth))];
      }
      values[numbers.nees(e)] += c.nees * per_station;
      ++events[counts.nees(e, bin_of(c.nees, 0, kNeesWidth))];
    }
    values[numbers.cost(e)] = run.cost;
    ++events[counts.cost(e, bin_of(run.cost, 0, cost_width_))];
    if (single_ < 0) continue;
    const RunCheck& other = checks[static_cast<std::size_t>(single_)];
    const QuantityArray others = mean_squares(other);
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      if (squares[q] > others[q]) {
        ++events[counts.worse_runs(e, q)];
        values[numbers.worse(e, q)] = std::sqrt(squares[q]);
      }
      events[counts.worse_last(e, q)] +=
          std::abs(run.stations.back().error[q]) > std::abs(other.stations.back().error[q]);
    }
  }
}

void PerformanceLayout::keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const {
  for (const RunCheck& run : checks)
    for (const double square : mean_squares(run)) samples.push_back(std::sqrt(square));
}

}  // namespace surveymc
