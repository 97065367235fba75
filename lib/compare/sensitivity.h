#pragma once
/// Which keys of a sweep explain a quantity: [sensitivity] of a config, table `sensitivity` of its result.
#include <vector>

#include "config/sensitivity_rule.h"
#include "store/table.h"

namespace surveymc::compare {

/// Name of the table that sensitivity_table() makes.
inline constexpr const char* kSensitivityTable = "sensitivity";

/// Throws InputError where these tables of a point do not have the quantities of the rule as numbers.
void check_sensitivity(const config::SensitivityRule& rule, const std::vector<store::Table>& tables);

/// For every quantity Y (or ln Y), over all rows that the rule chooses, one a point; the keys X_i of the sweep are
/// independent. Shares of Var Y (Sobol' 1993):
///   first        S_i  = Var E(Y | X_i) / Var Y
///   pair         S_ij = Var E(Y | X_i, X_j) / Var Y - S_i - S_j
///   with pairs   S_i + sum_j S_ij
///   rest         1 - sum S_i - sum S_ij: of three and more keys together, and what groups of values leave out
/// X_i is grouped: words by word; numbers by value, or in m groups of equally many values, m = cbrt(n) in [3, 32]; in
/// pairs at most sqrt(n / 16), at least 3. S_i is about a line in each group, S_ij about a mean: what is left within a
/// group counts as unexplained. Intervals: estimate -+ z se, z for all rows of the quantity together (Bonferroni), and
/// beyond that towards what lines in the groups explain more than means (in pairs twice, as a curve leaves more), and,
/// where the design fills cells more evenly than chance (Sobol'), towards the part of the squares, from which nothing
/// is taken for chance. Within [0, 1], but where the estimate lies beyond. se is at least that of a share of nothing.
/// Where the points are a whole product, each value is a group, shares are those of these points (share_of_groups()),
/// and have no interval. `trend`: correlation of ranks of Y and a numeric key. Rows of first and with pairs fall by
/// their share, pairs likewise. Throws InputError as check_sensitivity(), and where a point has several rows, or less
/// than 20 points have one.
store::Table sensitivity_table(const config::SensitivityRule& rule, const std::vector<store::Table>& tables,
                               std::size_t points);

}  // namespace surveymc::compare
