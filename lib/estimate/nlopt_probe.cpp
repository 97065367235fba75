#include "estimate/nlopt_probe.h"

#include <cstddef>
#include <stdexcept>

#include <nlopt.hpp>

namespace surveymc::estimate {
namespace {

/// Rosenbrock's function of any number of unknowns.
double valley(const std::vector<double>& x, std::vector<double>& gradient, void*) {
  double sum = 0;
  for (double& g : gradient) g = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const double across = x[i + 1] - x[i] * x[i], along = 1 - x[i];
    sum += 100 * across * across + along * along;
    if (gradient.empty()) continue;
    gradient[i] -= 400 * across * x[i] + 2 * along;
    gradient[i + 1] += 200 * across;
  }
  return sum;
}

}  // namespace

std::vector<double> nlopt_probe() {
  constexpr unsigned kUnknowns = 6;
  constexpr int kEvaluations = 60;  // on the way: at the minimum, roundings are forgotten
  std::vector<double> values;
  for (const nlopt::algorithm algorithm : {nlopt::LN_NELDERMEAD, nlopt::LN_BOBYQA, nlopt::LD_LBFGS}) {
    nlopt::opt opt(algorithm, kUnknowns);
    opt.set_min_objective(valley, nullptr);
    opt.set_maxeval(kEvaluations);
    opt.set_initial_step(0.1);
    std::vector<double> x{-1.2, 1.0, 0.7, -0.3, 0.4, 1.3};
    double value = 0;
    try {
      opt.optimize(x, value);
    } catch (const std::runtime_error&) {  // x holds the best point so far
    }
    values.insert(values.end(), x.begin(), x.end());
  }
  return values;
}

}  // namespace surveymc::estimate
