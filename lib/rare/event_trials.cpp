#include "rare/event_trials.h"

#include <algorithm>
#include <cmath>

#include "random/rare_channels.h"
#include "rare/subset_simulation.h"

namespace surveymc::rare {

EventTrials::EventTrials(const LimitState& state, Proposal proposal, TrialAddresses from, random::Stream stream)
    : state_(state), proposal_(std::move(proposal)), from_(std::move(from)), stream_(stream) {}

template <class EachTrial>
void EventTrials::each(std::uint64_t first, int count, EachTrial each_trial) const {
  DrawnTrials drawn;
  const auto marks = static_cast<std::size_t>(state_.marks());
  std::vector<double> g(kBatch), own(kBatch * std::max<std::size_t>(marks, 1));
  for (int done = 0; done < count; done += kBatch) {
    const int trials = std::min(kBatch, count - done), groups = survey::groups_for(trials);
    const std::uint64_t from = first + static_cast<std::uint64_t>(done);
    draw_trials(proposal_, from_, stream_, from, groups, state_.dimension(), drawn);
    state_.evaluate_marked(drawn.z, groups, g.data(), own.data());
    for (int t = 0; t < trials; ++t) {
      const auto at = static_cast<std::size_t>(t);
      each_trial(
          EventTrial{from + at, t, g[at], std::exp(drawn.log_weight[at]), drawn.component[at], own.data() + at * marks},
          drawn);
    }
  }
}

stats::Tally EventTrials::run_block(std::uint64_t first, int count, const Visit& visit) const {
  stats::Tally tally;
  tally.trials = static_cast<std::uint64_t>(count);
  tally.proposal = proposal_.hash();
  tally.weighted.resize(kFirstComponent + proposal_.components().size());
  each(first, count, [&](const EventTrial& t, const DrawnTrials& drawn) {
    if (std::isnan(t.g)) {
      tally.add_failed(t.trial);
      tally.weighted[kLost].add(t.weight);
    } else if (t.g <= 0) {
      tally.weighted[kAllHits].add(t.weight);
      if (!proposal_.is_plain()) tally.weighted[kFirstComponent + t.component].add(t.weight);
      if (visit) visit(t, drawn);
    }
  });
  return tally;
}

EventTrial EventTrials::replay(std::uint64_t trial, const Visit& visit) const {
  EventTrial found;
  const std::uint64_t first = trial / simd::kGroup * simd::kGroup;
  each(first, simd::kGroup, [&](const EventTrial& t, const DrawnTrials& drawn) {
    if (t.trial != trial) return;
    found = t;
    if (visit) visit(t, drawn);
  });
  return found;
}

stats::Tally UnionTrials::run_block(std::uint64_t first, int count) const {
  const int n = sampler_.dimension(), groups = survey::groups_for(count);
  stats::Tally tally;
  tally.trials = static_cast<std::uint64_t>(count);
  tally.proposal = sampler_.hash();
  tally.weighted.resize(kFirstComponent + half_spaces_);
  DrawnTrials drawn;
  draw_trials({}, addresses_in(random::kRareNormal, random::kRareChoice, n), stream_, first, groups, n, drawn);
  Eigen::VectorXd z(n);
  for (int t = 0; t < count; ++t) {
    for (int i = 0; i < n; ++i) z[i] = drawn.z.value(t, i);
    const auto u =
        stream_.uniforms<double>(first + static_cast<std::uint64_t>(t), random::kRareChoice, std::uint64_t{0});
    std::size_t chosen = 0;
    const double weight = sampler_.draw(u[0], u[1], z, chosen);
    tally.weighted[kAllHits].add(weight);
    tally.weighted[kFirstComponent + chosen].add(weight);
  }
  return tally;
}

stats::Tally run_subset_replicates(const LimitState& state, const random::Stream& stream, std::uint64_t first,
                                   int count, int samples) {
  stats::Tally tally;
  tally.trials = static_cast<std::uint64_t>(count);
  tally.counts.assign(kSubsetCounts, 0);
  Eigen::MatrixXd p(count, 2);
  for (int i = 0; i < count; ++i) {
    const SubsetReplicate r = subset_simulation(state, stream, first + static_cast<std::uint64_t>(i), samples);
    p(i, 0) = r.probability;
    p(i, 1) = r.lost_probability;
    tally.counts[kEvaluations] += r.evaluations;
    tally.counts[kLostEvaluations] += r.lost;
    tally.counts[kLostReplicates] += r.lost > 0;
  }
  tally.failed = tally.counts[kLostReplicates];
  tally.moments = stats::Moments::of(p);
  return tally;
}

stats::Tally subset_part(const stats::Tally& all, std::size_t event) {
  stats::Tally own;
  own.trials = all.trials;
  own.moments = all.groups.empty() ? stats::Moments(2) : all.groups[event];
  own.counts.assign(kSubsetCounts, 0);
  if (!all.counts.empty())
    std::copy_n(all.counts.begin() + static_cast<std::ptrdiff_t>(kSubsetCounts * event), kSubsetCounts,
                own.counts.begin());
  own.failed = own.counts[kLostReplicates];
  return own;
}

}  // namespace surveymc::rare
