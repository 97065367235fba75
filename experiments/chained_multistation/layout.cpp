#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "chained_multistation/performance_tables.h"

namespace surveymc::studies::chained_multistation {
namespace {

constexpr int kMostAlong = 200;  // stations: their table has a covariance of this size behind it

QuantityArray mean_squares(const RunCheck& run) {
  QuantityArray sum{};
  for (const StationCheck& c : run.stations)
    for (std::size_t q = 0; q < kRunQuantities; ++q)
      sum[q] += c.error[q] * c.error[q] / static_cast<double>(run.stations.size());
  return sum;
}

std::size_t bin_of(double x, double first, double width) {
  const double place = std::floor((x - first) / width);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(PerformanceLayout::kBins - 1)));
}

}  // namespace

PerformanceLayout::PerformanceLayout(const Scenario& s)
    : counts(s.estimators.size()),
      groups(s.estimators.size(), s.stations() <= kMostAlong),
      kept_(s.kept_runs),
      cost_width_(2 * 3.0 * s.stations() / kBins) {  // twice the expected cost is the last bin
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    chained_.push_back(is_chained(s.estimators[e]));
    if (s.estimators[e] == Solver::single) single_ = static_cast<int>(e);
  }
}

const stats::Moments& PerformanceLayout::moments(const stats::Tally& tally, std::size_t e) const {
  static const stats::Moments none;
  return tally.groups.empty() ? none : tally.groups[groups.solved(e)];
}

std::uint64_t PerformanceLayout::failed(const stats::Tally& tally, std::size_t e) const {
  std::uint64_t sum = 0;
  for (std::size_t s = 1; s < stats::kDescentStatuses && !tally.counts.empty(); ++s)
    sum += tally.counts[counts.ended(e, s)];
  return sum;
}

PerformanceLayout::Block PerformanceLayout::block(Eigen::Index trials, int stations) const {
  const auto width = static_cast<Eigen::Index>(numbers.size());
  return {std::vector<Eigen::MatrixXd>(groups.estimators, Eigen::MatrixXd::Zero(trials, width)),
          std::vector<Eigen::MatrixXd>(groups.size() - groups.estimators, Eigen::MatrixXd::Zero(trials, stations)),
          std::vector<Eigen::Index>(groups.estimators, 0)};
}

std::vector<stats::Moments> PerformanceLayout::moments_of(const Block& b) const {
  std::vector<stats::Moments> out;
  for (std::size_t e = 0; e < groups.estimators; ++e)
    out.push_back(stats::Moments::of(b.numbers[e].topRows(b.rows[e])));
  for (std::size_t g = 0; g < b.along.size(); ++g)
    out.push_back(stats::Moments::of(b.along[g].topRows(b.rows[g / kRunQuantities])));
  return out;
}

void PerformanceLayout::add(const std::vector<RunCheck>& checks, Block& block,
                            std::vector<std::uint64_t>& events) const {
  for (std::size_t e = 0; e < chained_.size(); ++e) {
    const RunCheck& run = checks[e];
    ++events[counts.ended(e, static_cast<std::size_t>(run.status))];
    if (!run.converged()) continue;
    const Eigen::Index row = block.rows[e]++;
    auto values = block.numbers[e].row(row);
    const double per_station = 1 / static_cast<double>(run.stations.size());
    const QuantityArray squares = mean_squares(run);
    for (std::size_t q = 0; q < kRunQuantities; ++q) values[numbers.square(q)] = squares[q];
    if (along())
      for (std::size_t k = 0; k < run.stations.size(); ++k)
        for (std::size_t q = 0; q < kRunQuantities; ++q) {
          const double x = run.stations[k].error[q];
          block.along[groups.square(e, q) - groups.estimators](row, static_cast<Eigen::Index>(k)) = x * x;
        }
    if (!chained_[e]) continue;
    for (const StationCheck& c : run.stations) {
      for (std::size_t q = 0; q < kRunQuantities; ++q)
        values[numbers.claimed(q)] += c.claimed_sd[q] * c.claimed_sd[q] * per_station;
      for (std::size_t z = 0; z < kTestedStates; ++z) {
        values[numbers.z_square(z)] += c.z[z] * c.z[z] * per_station;
        ++events[counts.z(e, bin_of(c.z[z], kZFirst, kZWidth))];
      }
      values[numbers.nees()] += c.nees * per_station;
      ++events[counts.nees(e, bin_of(c.nees, 0, kNeesWidth))];
    }
    values[numbers.cost()] = run.cost;
    ++events[counts.cost(e, bin_of(run.cost, 0, cost_width_))];
    if (single_ < 0) continue;
    const RunCheck& other = checks[static_cast<std::size_t>(single_)];
    const QuantityArray others = mean_squares(other);
    for (std::size_t q = 0; q < kRunQuantities; ++q) {
      if (squares[q] > others[q]) {
        ++events[counts.worse_runs(e, q)];
        values[numbers.worse(q)] = std::sqrt(squares[q]);
      }
      events[counts.worse_last(e, q)] +=
          std::abs(run.stations.back().error[q]) > std::abs(other.stations.back().error[q]);
    }
  }
}

void PerformanceLayout::keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const {
  for (const RunCheck& run : checks)
    for (const double square : mean_squares(run)) samples.push_back(run.converged() ? std::sqrt(square) : kNaN);
}

}  // namespace surveymc::studies::chained_multistation
