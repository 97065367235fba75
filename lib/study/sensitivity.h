#pragma once
/// Which keys of a sweep explain a quantity: [sensitivity] of a config, table `sensitivity` of its result.
#include <vector>

#include "config/sensitivity_rule.h"
#include "store/table.h"

namespace surveymc::study {

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
/// X_i is grouped: words by word; numbers by value, or in m groups of equally many values, m = cbrt(n) in [2, 32]; in
/// pairs at most sqrt(n / 16). What varies within a group counts as unexplained, so S_i is below, not above, that of
/// the key itself. Intervals: estimate -+ z se, z for all rows of the quantity together (Bonferroni), within [0, 1] but
/// for the estimate itself; se is at least that of a share of nothing. Where the points are a whole product, each value
/// is a group, shares are those of these points (share_of_groups()), and have no interval.
/// `trend`: correlation of ranks of Y and a numeric key. Rows of first and with pairs fall by their share, pairs
/// likewise. Throws InputError as check_sensitivity(), and where a point has several rows, or less than 20 points have
/// one.
store::Table sensitivity_table(const config::SensitivityRule& rule, const std::vector<store::Table>& tables,
                               std::size_t points);

}  // namespace surveymc::study
