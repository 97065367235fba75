#pragma once
/// The trials of one event: drawn by a proposal, by plain normals, from a union of half spaces, or replicates of subset
/// simulation. Blocks are independent of each other, so that any split has the same bits.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "random/stream.h"
#include "rare/limit_state.h"
#include "rare/proposal.h"
#include "rare/union_of_half_spaces.h"
#include "stats/tally.h"

namespace surveymc::rare {

/// One trial.
struct EventTrial {
  std::uint64_t trial = 0;
  int lane_index = 0;  ///< number of the trial in the batch that `visit` gets
  double g = 0;
  double weight = 1;
  std::uint32_t component = 0;
  const double* marks = nullptr;  ///< of LimitState::evaluate_marked()
};

/// What a tally's `weighted` holds, by index.
enum EventWeights : std::size_t { kAllHits = 0, kLost = 1, kFirstComponent = 2 };

class EventTrials {
 public:
  /// `state` must outlive this. A plain proposal gives plain trials.
  EventTrials(const LimitState& state, Proposal proposal, TrialAddresses from, random::Stream stream);

  const Proposal& proposal() const { return proposal_; }

  /// Trials first .. first + count - 1 (first a multiple of kGroup) as weighted[kAllHits], [kLost], and hits by
  /// component; trials without a result are `failed`, too. `visit` is called with every hit and the normals of its
  /// batch, in order.
  using Visit = std::function<void(const EventTrial&, const DrawnTrials&)>;
  stats::Tally run_block(std::uint64_t first, int count, const Visit& visit = {}) const;

  /// The same for one trial, hit or not.
  EventTrial replay(std::uint64_t trial, const Visit& visit = {}) const;

  /// How many trials are drawn at a time: normals and paths of two wells of 100 stations stay in the second cache.
  static constexpr int kBatch = 16;

 private:
  template <class EachTrial>
  void each(std::uint64_t first, int count, EachTrial each_trial) const;

  const LimitState& state_;
  Proposal proposal_;
  TrialAddresses from_;
  random::Stream stream_;
};

/// Trials of a union of half spaces; `weighted` as above, components are the half spaces. Every trial is a hit.
class UnionTrials {
 public:
  UnionTrials(UnionSampler sampler, std::size_t half_spaces, random::Stream stream)
      : sampler_(std::move(sampler)), half_spaces_(half_spaces), stream_(stream) {}
  stats::Tally run_block(std::uint64_t first, int count) const;
  const UnionSampler& sampler() const { return sampler_; }

 private:
  UnionSampler sampler_;
  std::size_t half_spaces_;
  random::Stream stream_;
};

/// Counts of replicates of subset simulation: evaluations, those of them without a result, replicates with such.
inline constexpr std::size_t kEvaluations = 0, kLostEvaluations = 1, kLostReplicates = 2, kSubsetCounts = 3;

/// Replicates of subset simulation as trials: `moments` of their probabilities, and of the probabilities of no result;
/// `counts` as above. `failed`: replicates with evaluations that had no result.
stats::Tally run_subset_replicates(const LimitState& state, const random::Stream& stream, std::uint64_t first,
                                   int count, int samples);

/// Of a run of several events, whose replicates have `groups` and `counts` side by side: the tally of one.
stats::Tally subset_part(const stats::Tally& all, std::size_t event);

}  // namespace surveymc::rare
