#pragma once
/// Rows of comparison tables that judge a claim ("lower than", "in less than 5 %") instead of a prediction.
#include <string>
#include <vector>

#include "study/comparison.h"

namespace surveymc::study {

/// Mean of one number a realisation, with its interval; of one realisation the number alone.
ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                       const std::vector<double>& x, double confidence);

/// The verdict on the claim that the value of `row` lies below the bound, or above it: "agrees" or "differs" where the
/// whole interval (without one: the value) lies on one side.
ComparisonRow judge_claim(ComparisonRow row, double bound, bool below, const std::string& note);

}  // namespace surveymc::study
