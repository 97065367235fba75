#include "rare/subset_simulation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/units.h"
#include "random/rare_channels.h"
#include "rare/proposal.h"
#include "stats/intervals.h"

namespace surveymc::rare {
namespace {

constexpr int kMostLevels = 100, kChain = 10;
constexpr double kAcceptance = 0.4;

/// Standard normals for `count` samples of a step of a level: n x count.
Eigen::MatrixXd fresh_normals(const random::Stream& stream, std::uint64_t replicate, int level, int step, int n,
                              int count) {
  // The stream's trial: replicate, level, step and sample side by side.
  const std::uint64_t first =
      ((replicate << 7 | static_cast<std::uint64_t>(level)) << 4 | static_cast<std::uint64_t>(step)) << 20;
  DrawnTrials drawn;
  const int groups = survey::groups_for(count);
  draw_trials({}, addresses_in(random::kRareChain, {}, n), stream, first, groups, n, drawn);
  Eigen::MatrixXd z(n, count);
  for (int t = 0; t < count; ++t)
    for (int i = 0; i < n; ++i) z(i, t) = drawn.z.value(t, i);
  return z;
}

}  // namespace

SubsetReplicate subset_simulation(const LimitState& state, const random::Stream& stream, std::uint64_t replicate,
                                  int samples) {
  const int n = state.dimension(), survivors = samples / kChain, all = survivors * kChain;
  SubsetReplicate out;
  const auto evaluate = [&](const Eigen::MatrixXd& z) {
    Eigen::VectorXd g = values_at(state, z);
    out.evaluations += static_cast<std::uint64_t>(z.cols());
    for (double& x : g)
      if (std::isnan(x)) {
        ++out.lost;
        x = kInfinity;
      }
    return g;
  };
  Eigen::MatrixXd z = fresh_normals(stream, replicate, 0, 0, n, all);
  Eigen::VectorXd g = evaluate(z);
  double p = 1, log_step = std::log(0.6);  // of sqrt(1 - rho^2)
  std::uint64_t evaluations_before = 0, lost_before = 0;
  for (int level = 1;; ++level) {
    const auto lost_here = static_cast<double>(out.lost - lost_before);
    const auto evaluated_here = static_cast<double>(out.evaluations - evaluations_before);
    out.lost_probability = std::max(out.lost_probability, p * lost_here / evaluated_here);
    evaluations_before = out.evaluations, lost_before = out.lost;
    std::vector<int> order(static_cast<std::size_t>(all));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return g[a] < g[b]; });
    const double threshold = g[order[static_cast<std::size_t>(survivors - 1)]];
    out.levels = level;
    if (threshold <= 0 || level > kMostLevels || std::isinf(threshold)) {
      const auto hits = std::count_if(g.begin(), g.end(), [](double x) { return x <= 0; });
      out.probability = p * static_cast<double>(hits) / all;
      out.hits.resize(n, hits);
      for (Eigen::Index i = 0; i < hits; ++i) out.hits.col(i) = z.col(order[static_cast<std::size_t>(i)]);
      return out;
    }
    // Where many values are equal, more than a tenth lie at the level.
    const auto below = std::count_if(g.begin(), g.end(), [&](double x) { return x <= threshold; });
    p *= static_cast<double>(below) / all;
    Eigen::MatrixXd chains(n, survivors);
    Eigen::VectorXd g_chains(survivors);
    for (int c = 0; c < survivors; ++c) {
      chains.col(c) = z.col(order[static_cast<std::size_t>(c)]);
      g_chains[c] = g[order[static_cast<std::size_t>(c)]];
    }
    z.leftCols(survivors) = chains;
    g.head(survivors) = g_chains;
    for (int step = 1; step < kChain; ++step) {
      const double spread = std::min(1.0, std::exp(log_step)), rho = std::sqrt(1 - spread * spread);
      const Eigen::MatrixXd next = rho * chains + spread * fresh_normals(stream, replicate, level, step, n, survivors);
      const Eigen::VectorXd g_next = evaluate(next);
      int accepted = 0;
      for (int c = 0; c < survivors; ++c)
        if (g_next[c] <= threshold) {
          ++accepted;
          chains.col(c) = next.col(c);
          g_chains[c] = g_next[c];
        }
      log_step = std::min(0.0, log_step + (static_cast<double>(accepted) / survivors - kAcceptance) / std::sqrt(step));
      z.middleCols(step * survivors, survivors) = chains;
      g.segment(step * survivors, survivors) = g_chains;
    }
  }
}

SubsetEstimate subset_estimate(const stats::Moments& m, double confidence) {
  if (m.count == 0) return {kNaN, kNaN, kNaN};
  SubsetEstimate e{m.mean[0], kNaN, kNaN};
  if (m.count < 2) return e;
  const stats::Interval t = stats::student_mean_interval(m.mean[0], m.variance(0), m.count, confidence);
  e.lo = std::max(0.0, t.lo);
  e.hi = t.hi;
  return e;
}

}  // namespace surveymc::rare
