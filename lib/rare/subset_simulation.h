#pragma once
/// Subset simulation (Au and Beck 2001; Papaioannou et al. 2015): a check of importance sampling, and the only method
/// where no direction leads to the event.
///
/// Levels at the tenth of the values of g; chains of ten from the survivors, z' = rho z + sqrt(1 - rho^2) x, kept where
/// g(z') <= level; rho follows an acceptance of 40 %. One replicate is one long trial: its own interval would not be
/// honest, so p is the mean of independent replicates, with the t interval over them.
#include <cstdint>

#include <Eigen/Core>

#include "random/stream.h"
#include "rare/limit_state.h"
#include "stats/moments.h"

namespace surveymc::rare {

struct SubsetReplicate {
  double probability = 0;
  std::uint64_t evaluations = 0, lost = 0;  ///< `lost`: evaluations without a result (NaN), not hits
  /// Probability of no result: of a level, its probability times the share of its evaluations; the largest of all.
  double lost_probability = 0;
  int levels = 0;
  Eigen::MatrixXd hits;  ///< the samples of the event among those of the last level, n x hits
};

/// `samples`: N of a level, at least 20. `replicate`: its draws are those of no other. Where the event
/// cannot be reached, ends after 100 levels with probability 0.
SubsetReplicate subset_simulation(const LimitState& state, const random::Stream& stream, std::uint64_t replicate,
                                  int samples);

/// Mean of replicates with its t interval.
struct SubsetEstimate {
  double probability = 0, lo = 0, hi = 0;
};
/// `probabilities`: moments of one quantity, at least two replicates, otherwise without an interval (NaN).
SubsetEstimate subset_estimate(const stats::Moments& probabilities, double confidence);

}  // namespace surveymc::rare
