#pragma once
/// Rows of comparison tables that judge a claim ("lower than", "in less than 5 %") instead of a prediction.
#include <string>
#include <vector>

#include "compare/comparison.h"

namespace surveymc::compare {

/// Mean of one number a realisation, with its interval by Student's t, as realisations may be few. Of one realisation,
/// or of equal ones, which do not show how much they scatter, the number alone.
ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                       const std::vector<double>& x, double confidence);

/// What speaks against, and for, the claim that a value lies below `bound` (or above it): p-values by the standard
/// error that the half of the interval towards the bound shows, on the logarithm if `logarithmic`. NaN without an
/// interval. `degrees`: of freedom, where the interval is by Student's t; infinite: it is by the normal law.
Evidence claim_evidence(double value, const stats::Interval& interval, double bound, bool below, double confidence,
                        bool logarithmic, double degrees = kInfinity);

/// The verdict on the claim that the value of `row` lies below the bound, or above it: "agrees" or "differs" where the
/// whole interval lies on one side, none without an interval. `confidence`: of the row's interval; `degrees`: see
/// claim_evidence().
ComparisonRow judge_claim(ComparisonRow row, double bound, bool below, double confidence, const std::string& note,
                          double degrees = kInfinity);
/// The same of a row that mean_row() made of the values x.
ComparisonRow judge_mean_claim(const std::string& formulation, const std::string& quantity,
                               const std::vector<double>& x, double bound, bool below, double confidence,
                               const std::string& note);

}  // namespace surveymc::compare
