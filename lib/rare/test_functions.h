#pragma once
/// Limit states with known probabilities, to test methods for rare events.
///
/// | name        | g                                                     | parameters             |
/// | linear      | beta - sum x / sqrt n                                 | dimension, beta        |
/// | union       | min_k (beta_k - x_k)                                  | dimension, betas       |
/// | product     | level - |x1 x2|                                       | level                  |
/// | sphere      | radius - |x|                                          | dimension, radius      |
/// | disc        | |mean + sd x| - radius                                | mean, sd, radius       |
/// | rp77        | u - v - w for w <= 5, else w - v; u = 10 + x1/2, v = x2, w = 4 + x3              |
/// | rp107       | 5 sqrt 10 - sum of ten x                                                         |
/// | rp110       | min(x1 <= 3.5 ? 0.85 - 0.1 x1 : 4 - x1, x2 <= 2 ? 2.3 - x2 : 0.5 - 0.1 x2)           |
/// | rp111       | 12.5 - |x1 x2|                                                                   |
/// | rp25        | max(x1^2 - 8 x2 + 16, -16 x1 + x2 + 32)                                          |
/// | four_branch | min(3 + d^2/10 -+ s / sqrt 2, 7/sqrt 2 -+ d), s = x1 + x2, d = x1 - x2           |
///
/// rp..: the black-box reliability challenge 2019 (Rozsas and Slobbe), as otbenchmark has them; four_branch: Waarts
/// (2000).
#include <memory>
#include <string>
#include <vector>

#include "rare/limit_state.h"
#include "rare/union_of_half_spaces.h"

namespace surveymc::rare {

struct TestProblem {
  std::string name;
  int dimension = 2;
  std::vector<double> beta = {};                   ///< linear: one; union: at most `dimension`
  double level = 0;                                ///< product; > 0
  double radius = 0;                               ///< sphere, disc; > 0
  std::vector<double> mean = {0, 0}, sd = {1, 1};  ///< disc; sd > 0
};

/// In the order of the list above.
const std::vector<std::string>& test_problem_names();

/// Completes `dimension` of problems that have a fixed one.
TestProblem with_dimension(TestProblem problem);

std::unique_ptr<LimitState> test_limit_state(const TestProblem& problem);

/// P(g <= 0), by closed forms and by Gauss-Kronrod quadrature in one variable, accurate to nine digits.
double exact_probability(const TestProblem& problem);

/// "linear" and "union" as a union of half spaces; empty for others.
std::vector<HalfSpace> half_spaces_of(const TestProblem& problem);

}  // namespace surveymc::rare
