#pragma once
/// The verdicts of many rows as a family. A row's verdict is the row's; the family says which "differs" survive Holm's
/// procedure at 5 %, and what share of the "agrees" may be wrong (Benjamini and Hochberg 1995). Wishart tests of whole
/// matrices join with their own p.
#include <vector>

#include "store/table.h"

namespace surveymc::compare {

inline constexpr double kFamilyLevel = 0.05;
/// Name of the table that apply_family() appends.
inline constexpr const char* kFamilyTable = "family";
/// What column `family` says of a row that differs.
inline constexpr const char *kDiffersInFamily = "differs", *kMayBeChance = "may be chance";

/// Which of these hypotheses Holm (1979) rejects at `level`: the k-th smallest of n p-values is compared with
/// level / (n - k + 1), until one is larger. P(any true hypothesis is rejected) <= level, whatever their dependence.
/// NaN: no hypothesis.
std::vector<bool> holm(const std::vector<double>& p, double level);

/// The share of wrong ones to be expected among those of `p` that are at most `accepted`: q of the last of them,
/// n p / k at most 1 with the k-th smallest p; 0 where there is none.
double benjamini_hochberg_share(const std::vector<double>& p, double accepted);

/// Fills column `family` of every table that has it and p_differs, verdict, and column `wishart_family` of every table
/// that has it and wishart_p, over all these p together; rows with expected = "differs" were asked beforehand and stay
/// out. Appends the table `family`, one row: verdicts, agrees, differs, undecided, differs_holm, agrees_q, tests,
/// tests_holm. Without rows nothing is done.
void apply_family(std::vector<store::Table>& tables);

}  // namespace surveymc::compare
