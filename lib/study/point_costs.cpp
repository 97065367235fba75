#include "study/point_costs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <variant>

#include "base/error.h"

namespace surveymc::study {
namespace {

constexpr std::uint64_t kMostOfKey = 1000;         // values of a key that are read
constexpr std::uint64_t kMostListed = 10'000'000;  // points of a product whose keys are looked at apart

/// The same number for the same `i` always, spread over 64 bits: the finaliser of SplitMix64.
std::uint64_t scattered(std::uint64_t i) {
  std::uint64_t x = (i + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

double cost_of(const RunPlan& run, std::uint64_t point) {
  try {
    const double cost = run.plan(point)->cost();
    return std::isfinite(cost) && cost > 0 ? cost : 0;
  } catch (const InputError&) {
    if (!run.is_large()) throw;
    return 0;
  }
}

}  // namespace

PointCosts::Axis::Axis(std::uint64_t of_size, std::vector<double> of_ranges)
    : size(of_size), factors(std::move(of_ranges)), upto(factors.size() + 1) {
  for (std::size_t r = 0; r < factors.size(); ++r)
    upto[r + 1] = upto[r] + factors[r] * static_cast<double>(first_of(r + 1) - first_of(r));
}

std::uint64_t PointCosts::Axis::first(std::uint64_t range, std::uint64_t of_size, std::uint64_t ranges) {
  return of_size / ranges * range + of_size % ranges * range / ranges;
}

std::uint64_t PointCosts::Axis::range_of(std::uint64_t value) const {
  std::uint64_t lo = 0, hi = factors.size();  // first_of(lo) <= value < first_of(hi)
  while (hi - lo > 1) (first_of(std::midpoint(lo, hi)) <= value ? lo : hi) = std::midpoint(lo, hi);
  return lo;
}

double PointCosts::Axis::before(std::uint64_t value) const {
  if (value == size) return upto.back();
  const std::uint64_t r = range_of(value);
  return upto[r] + factors[r] * static_cast<double>(value - first_of(r));
}

PointCosts::PointCosts(const RunPlan& run) : points_(run.point_count()) {
  if (!run.is_large() || points_ > kMostListed || !read_product(run)) read_ranges(run);
}

void PointCosts::read_ranges(const RunPlan& run) {
  axes_.clear();
  std::vector<double> costs(std::min<std::uint64_t>(points_, kMostReadWhole));
  for (std::uint64_t r = 0; r < costs.size(); ++r) {
    const std::uint64_t first = Axis::first(r, points_, costs.size()), end = Axis::first(r + 1, points_, costs.size());
    costs[r] = cost_of(run, first + scattered(r) % (end - first));
  }
  if (std::all_of(costs.begin(), costs.end(), [](double c) { return c == 0; }))
    std::fill(costs.begin(), costs.end(), 1.0);
  axes_.emplace_back(points_, std::move(costs));
}

bool PointCosts::read_product(const RunPlan& run) {
  const std::optional<std::vector<config::SweepDimension>> keys = run.config.sweep_product();
  const double base = keys ? cost_of(run, 0) : 0;
  if (!(base > 0)) return false;
  std::uint64_t stride = points_;
  for (const config::SweepDimension& key : *keys) {
    const std::uint64_t size = std::visit([](const auto& values) { return values.size(); }, key.values);
    stride /= size;
    std::vector<double> factors(std::min(size, kMostOfKey));
    for (std::uint64_t r = 0; r < factors.size(); ++r) {
      const std::uint64_t first = Axis::first(r, size, factors.size()), end = Axis::first(r + 1, size, factors.size());
      factors[r] = cost_of(run, (first + (end - first) / 2) * stride) / base;
      if (!(factors[r] > 0)) return false;
    }
    axes_.emplace_back(size, std::move(factors));
  }
  std::vector<double> costs = axes_.front().factors;
  for (double& c : costs) c *= base;
  axes_.front() = Axis(axes_.front().size, std::move(costs));
  constexpr std::uint64_t kAsked = 200;
  constexpr double kAgrees = 0.05;
  for (std::uint64_t i = 0; i < kAsked; ++i) {
    const std::uint64_t point = scattered(i) % points_;
    const double cost = cost_of(run, point);
    if (cost > 0 && std::abs(at(point) - cost) > kAgrees * cost) return false;
  }
  return true;
}

double PointCosts::at(std::uint64_t point) const {
  double cost = 1;
  for (auto a = axes_.rbegin(); a != axes_.rend(); ++a) {
    cost *= a->at(point % a->size);
    point /= a->size;
  }
  return cost;
}

double PointCosts::before(std::uint64_t end) const {
  // Of the slowest key all values before its own, each with all values of the other keys; and so on down
  double sum = 0, of_own = 1;
  std::uint64_t stride = points_;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    double faster = 1;  // sum over the values of the faster keys
    for (std::size_t k = i + 1; k < axes_.size(); ++k) faster *= axes_[k].upto.back();
    stride /= axes_[i].size;
    const std::uint64_t own = end / stride;
    end %= stride;
    sum += of_own * axes_[i].before(own) * faster;
    if (own == axes_[i].size) break;  // all of it: nothing is left
    of_own *= axes_[i].at(own);
  }
  return sum;
}

std::vector<checkpoint::PointRange> PointCosts::ranges(std::uint64_t count) const {
  count = std::min(count, points_);
  const double all = before(points_);
  std::vector<checkpoint::PointRange> out;
  std::uint64_t first = 0;
  for (std::uint64_t g = 1; g <= count; ++g) {
    const double wanted = all * (static_cast<double>(g) / static_cast<double>(count));
    std::uint64_t lo = first, end = points_;  // the first end with as much before it
    while (g < count && lo < end) {
      const std::uint64_t middle = std::midpoint(lo, end);
      if (before(middle) < wanted)
        lo = middle + 1;
      else
        end = middle;
    }
    if (g < count && end > 0 && wanted - before(end - 1) < before(end) - wanted) --end;
    end = std::clamp(end, first + 1, points_ - (count - g));  // every range has a point
    out.push_back({first, end, 1});
    first = end;
  }
  return out;
}

}  // namespace surveymc::study
