#pragma once
/// What a block of trials leaves behind. Tallies of neighbouring blocks merge; nothing else of the trials is kept.
#include <cstdint>
#include <vector>

#include "stats/moments.h"

namespace surveymc::stats {

struct Tally {
  std::uint64_t trials = 0;     ///< all that were run
  std::uint64_t failed = 0;     ///< of them, those whose estimate did not converge: not in the moments
  std::uint64_t left_out = 0;   ///< converged, but the other of their antithetic pair failed: not in either
  Moments moments;              ///< of the study's quantities
  std::vector<Moments> groups;  ///< of groups of quantities, without what relates one group to another
  /// Of quantities with their control variates (control_variate.h), then of the controls of the trials that are not in
  /// `moments`; a block without such trials may leave the latter away.
  std::vector<Moments> controlled;
  Moments pairs;                             ///< of antithetic pairs (antithetic.h), beside `moments` of their trials
  std::vector<Moments> controlled_pairs;     ///< the same for `controlled`
  std::vector<std::uint64_t> counts;         ///< of the study's events
  std::vector<std::uint64_t> failed_trials;  ///< numbers of the first kMaxListed failed trials, for replay
  std::vector<double> samples;               ///< first realisations, row by row, as many as the study asked for

  static constexpr std::size_t kMaxListed = 1000;

  /// `next` holds trials that follow those of this tally. The order of merging is part of the result's bits.
  void merge(const Tally& next);
};

}  // namespace surveymc::stats
