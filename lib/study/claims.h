#pragma once
/// Rows of comparison tables that judge a claim ("lower than", "in less than 5 %") instead of a prediction.
#include <string>
#include <vector>

#include "study/comparison.h"

namespace surveymc::study {

/// Mean of one number a realisation, with its interval; of one realisation the number alone.
ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                       const std::vector<double>& x, double confidence);

/// What speaks against, and for, the claim that a value lies below `bound` (or above it): p-values by the standard
/// error that the half of the interval towards the bound shows, on the logarithm if `logarithmic`. NaN without an
/// interval.
Evidence claim_evidence(double value, const stats::Interval& interval, double bound, bool below, double confidence,
                        bool logarithmic);

/// The verdict on the claim that the value of `row` lies below the bound, or above it: "agrees" or "differs" where the
/// whole interval (without one: the value) lies on one side. `confidence`: of the row's interval.
ComparisonRow judge_claim(ComparisonRow row, double bound, bool below, double confidence, const std::string& note);

}  // namespace surveymc::study
