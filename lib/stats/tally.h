#pragma once
/// The statistics of a block of trials. Tallies of neighbouring blocks merge; nothing else of the trials is kept.
#include <cstdint>
#include <vector>

#include "stats/moments.h"
#include "stats/weighted_hits.h"

namespace surveymc::stats {

struct Tally {
  std::uint64_t trials = 0;    ///< all that ran
  std::uint64_t failed = 0;    ///< of them, those whose estimate did not converge: not in the moments
  std::uint64_t left_out = 0;  ///< converged, but the other trial of the antithetic pair failed: not in the moments
  Moments moments = {};        ///< of the study's quantities
  std::vector<Moments> groups = {};  ///< of groups of quantities, without covariances between the groups
  /// Moments of quantities with their control variates (control_variate.h), then of the controls of the trials that are
  /// not in `moments`; a block without such trials may omit the latter.
  std::vector<Moments> controlled = {};
  Moments pairs = {};                          ///< of antithetic pairs (antithetic.h), beside `moments` of their trials
  std::vector<Moments> controlled_pairs = {};  ///< the same for `controlled`
  std::vector<std::uint64_t> counts = {};      ///< of the study's events
  std::vector<std::uint64_t> failed_trials = {};  ///< numbers of the first kMaxListed failed trials, for replay
  std::vector<double> samples = {};               ///< first realisations, row by row, as many as the study asked for
  std::vector<WeightedHits> weighted = {};        ///< of the study's events, where trials have weights
  /// Hash of the proposal that gave the weights; 0: none. Weights of two proposals do not add up.
  std::uint64_t proposal = 0;

  static constexpr std::size_t kMaxListed = 1000;

  /// Counts a trial that failed, and lists it.
  void add_failed(std::uint64_t trial);
  /// `next` holds trials that follow those of this tally. The order of merging is part of the result's bits.
  void merge(const Tally& next);
};

/// True if the two are of the same quantities, and their weights of one proposal: lists of equal length, where both
/// have any.
bool can_merge(const Tally& a, const Tally& b);

}  // namespace surveymc::stats
