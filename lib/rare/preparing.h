#pragma once
/// Preparation of a proposal for any limit state: finds the modes of the event and fits the mixture that draws it. A
/// pure function of the limit state and of the stream, in a fixed order of sums: every process gets the same bits.
///
///   1  four subset pilots give samples of the event: a single one loses modes
///   2  the nearest of them, improved by a shrinking random search and by Hasofer-Lind-Rackwitz steps with central
///      differences, is the first design point z_1, beta_1 = |z_1|. Jumps and deceptive slopes defeat gradients alone,
///      many dimensions the search alone
///   3  while a sample of the event has a weight above 3 exp(-beta_1^2/2) / (largest share), it gets a design point of
///      its own: so every mode that a pilot has met is covered
///   4  rounds with unit covariances and a wide component look for more; then rounds that adapt means, covariances and
///      shares by the cross entropy of what lies below a level
/// The mixture: adapted components; shifted ones N(z_k, 1), which bound the weights behind the tangent planes; a wide
/// one N(0, s^2), which sees every direction.
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "random/stream.h"
#include "rare/limit_state.h"
#include "rare/proposal.h"

namespace surveymc::rare {

/// The point of the event nearest to the origin, or nearest of its mode.
struct DesignPoint {
  Eigen::VectorXd z;
  double beta = 0;  ///< |z|
};

struct PreparingOptions {
  int pilot = 1000;                                    ///< evaluations of a round
  int subset_pilot = 500;                              ///< samples of a pilot by subset simulation
  int max_components = 12;                             ///< design points at most
  double adapted = 0.75, shifted = 0.20, wide = 0.05;  ///< shares, > 0, sum 1
};

struct Prepared {
  Proposal proposal;                 ///< plain where no sample of the event was found
  std::vector<DesignPoint> designs;  ///< nearest first
  std::uint64_t evaluations = 0;
};

/// Throws nothing: where the pilots find no event there is no design point. `starts`: points where a prediction expects
/// the event to begin; each is a sample beside those of the pilots if the event is there or up to twice as far out.
Prepared prepare_proposal(const LimitState& state, const random::Stream& stream, const PreparingOptions& options,
                          const std::vector<Eigen::VectorXd>& starts = {});

/// Of an event whose design points are known, at least one: those within 2.5 of the least distance and the rounds of
/// step 4 that adapt, nothing that looks for more. Pilots in hundreds of normals find modes that are none, and each
/// adds a direction.
Prepared prepare_from(const LimitState& state, const random::Stream& stream, const PreparingOptions& options,
                      const std::vector<Eigen::VectorXd>& points);

/// The directions of the mixture: all where n <= 4, otherwise the span of the design points.
Eigen::MatrixXd basis_of(const std::vector<DesignPoint>& designs, int n);

/// Shares of the shifted components: as exp(-(beta_k^2 - beta_1^2) / 4), sum 1.
std::vector<double> shares_of(const std::vector<DesignPoint>& designs);

/// Rounds of adaptation in a given basis: every design point has an adapted and a shifted component. Each round draws
/// `pilot` trials, takes those below the level max(0, tenth of the values of g) with their weights, and sets means,
/// covariances (times 1.3) and shares of the adapted components; it ends after `rounds` rounds, and where `until_hit`
/// after the second one whose level was 0.
Proposal adapt_proposal(const LimitState& state, const random::Stream& stream, const std::vector<DesignPoint>& designs,
                        const Eigen::MatrixXd& basis, const PreparingOptions& options, double wide_sd, int rounds,
                        bool until_hit, std::uint64_t& evaluations);

}  // namespace surveymc::rare
