#include "cli/sweep_pace.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/units.h"

namespace surveymc::cli {

SweepPace::SweepPace(std::vector<PacedPoint> points) : points_(std::move(points)), timed_(points_.size()) {
  for (const PacedPoint& p : points_) ends_.push_back(trials() + p.trials);
}

void SweepPace::note(std::uint64_t done, double elapsed) {
  // A call follows the end of a block: `done` trials end within the point, or at its end.
  const auto end = std::lower_bound(ends_.begin(), ends_.end(), done);
  if (end == ends_.end() || done == 0) return;
  Timed& t = timed_[static_cast<std::size_t>(end - ends_.begin())];
  if (!t.noted) t = {done, done, elapsed, elapsed, true};
  t.to = done;
  t.until = elapsed;
  done_ = done;
}

double SweepPace::seconds_per_trial(std::size_t point) const {
  const Timed& t = timed_[point];
  return t.to > t.from ? (t.until - t.since) / static_cast<double>(t.to - t.from) : kNaN;
}

std::vector<double> SweepPace::expected_per_trial() const {
  constexpr int kRounds = 100;         // of least squares, key by key; each takes ln(cost) nearer to a sum of effects
  constexpr double kConverged = 1e-9;  // of ln(cost)
  std::vector<std::size_t> timed;
  std::vector<double> rest(points_.size());
  double mean = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    rest[i] = std::log(seconds_per_trial(i));
    if (!std::isfinite(rest[i])) continue;
    timed.push_back(i);
    mean += rest[i];
  }
  if (timed.empty()) return std::vector<double>(points_.size(), kNaN);
  mean /= static_cast<double>(timed.size());
  for (const std::size_t i : timed) rest[i] -= mean;

  const std::size_t keys = points_.front().values.size();
  std::vector<std::map<std::string, double>> effects(keys);
  double change = 1;
  for (int round = 0; round < kRounds && change > kConverged; ++round) {
    change = 0;
    for (std::size_t k = 0; k < keys; ++k) {
      std::map<std::string, std::pair<double, double>> sums;
      for (const std::size_t i : timed) {
        auto& [sum, count] = sums[points_[i].values[k]];
        sum += rest[i];
        ++count;
      }
      for (const std::size_t i : timed) {
        const auto& [sum, count] = sums[points_[i].values[k]];
        rest[i] -= sum / count;
      }
      for (const auto& [value, total] : sums) {
        effects[k][value] += total.first / total.second;
        change = std::max(change, std::abs(total.first / total.second));
      }
    }
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    double log_cost = mean;
    for (std::size_t k = 0; k < keys; ++k)
      if (const auto known = effects[k].find(points_[i].values[k]); known != effects[k].end())
        log_cost += known->second;
    const double own = seconds_per_trial(i);
    out.push_back(std::isnan(own) ? std::exp(log_cost) : own);
  }
  return out;
}

double SweepPace::left() const {
  constexpr std::size_t kMostPoints = 1000;  // of more, the mean over many is good enough, and this would take long
  if (points_.size() > kMostPoints) return kNaN;
  const std::vector<double> expected = expected_per_trial();
  double seconds = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (ends_[i] <= done_) continue;
    const std::uint64_t begin = ends_[i] - points_[i].trials;
    seconds += expected[i] * static_cast<double>(ends_[i] - std::max(begin, done_));
  }
  return seconds;
}

}  // namespace surveymc::cli
