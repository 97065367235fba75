#pragma once
/// Probabilities of large errors that are sums of heavy-tailed and of normal ones, without trials.
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "random/mixing_draws.h"

namespace surveymc::stats {

/// Part of an error along a direction: `weight` times a draw of the law. The square of the weight is the part's share
/// of the variance; its sign counts where the law is not symmetric.
struct HeavyPart {
  std::shared_ptr<const random::MixingLaw> law;
  double weight = 0;
};

/// Parts of an error whose draws have these effects `along` a direction, and this variance: draws that share a V are
/// one part. `slot_of`: one a draw; -1: normal.
std::vector<HeavyPart> heavy_parts(const std::vector<random::MixingSlot>& slots,
                                   const std::vector<std::int32_t>& slot_of,
                                   const Eigen::Ref<const Eigen::VectorXd>& along, double variance);

/// P(|x| > k) for x = sum weight_i H_i + sqrt(1 - sum weight_i^2) N of variance 1, all independent, for every k > 0.
/// One part: E_V of the normal tails of variance rho V + 1 - rho, by one quadrature over V. Several: by the product of
/// characteristic functions (Gil-Pelaez 1951; error of the sum over t: Davies 1973), to 1e-8: smaller ones are
/// NaN. Parts of several stations cost as many functions a value of t.
std::vector<double> beyond(const std::vector<HeavyPart>& parts, const std::vector<double>& k);

/// The k with P(|x| > k) = probability; NaN of several parts where the probability is less than 1e-8.
double quantile_beyond(const std::vector<HeavyPart>& parts, double probability);

}  // namespace surveymc::stats
