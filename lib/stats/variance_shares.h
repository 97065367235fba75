#pragma once
/// Share of the variance of values that their groups explain, with a standard error.
#include <cstdint>
#include <vector>

#include "base/units.h"

namespace surveymc::stats {

/// share = 1 - E[Var(y | group)] / Var(y): the correlation ratio, the index of first order (Sobol' 1993) of what makes
/// the groups. Var(y | group) is the sample variance of each group, so that chance alone explains
/// nothing on average; groups of one value are left out of the mean.
struct ExplainedShare {
  double share = kNaN;  ///< below 0 by chance; NaN of equal values, or where no group has two
  /// Part of the squares of these values that the groups explain: what `share` would be if chance explained nothing, as
  /// where a design fills the groups evenly.
  double of_squares = kNaN;
  /// Influence of each value on `share`, to first order: its standard error is sd(influence) / sqrt(n). Of
  /// sums and differences of shares of the same values, influences add up, too.
  std::vector<double> influence = {};
};

/// `group` has one number for each of `y`, below `groups`. `slopes`: values by which y is taken as linear within each
/// group (Var(y | group) is then that about this plane); those that do not vary within it are left out there, and so
/// are groups that have no more values than the plane has coefficients.
ExplainedShare explained_share(const std::vector<double>& y, const std::vector<std::uint32_t>& group,
                               std::uint32_t groups, const std::vector<const std::vector<double>*>& slopes = {});

/// sum n_g (mean_g - mean)^2 / sum (y - mean)^2: what the groups explain of these values, where they are all that there
/// is, such as the points of a product. NaN of equal values.
double share_of_groups(const std::vector<double>& y, const std::vector<std::uint32_t>& group, std::uint32_t groups);

/// Standard error that chance gives to a share of groups that explain nothing: `freedom` differences of means of n
/// independent normal values, whose part of the squares has a beta distribution,
///   sqrt(2 freedom / ((n - 1 - freedom) (n + 1)))
/// Of few values the influences may be smaller by chance.
double chance_of_share(double freedom, double n);

/// sd(influence) / sqrt(n)
double standard_error_of(const std::vector<double>& influence);

/// Correlation of ranks (Spearman), equal values having their mean rank; NaN where x or y are all equal.
double rank_correlation(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace surveymc::stats
