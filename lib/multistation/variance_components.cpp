#include "multistation/variance_components.h"

#include <cmath>

namespace surveymc::multistation {
namespace {

constexpr int kMostIterations = 100;
constexpr double kChange = 1e-3;
constexpr double kSmallestFactor = 1e-12;  // residuals that vanish: a weight stays finite

}  // namespace

VarianceComponents variance_components(const std::vector<int>& group, int groups,
                                       const std::function<GroupedFit(const std::vector<double>&)>& fit) {
  VarianceComponents out;
  out.groups.resize(static_cast<std::size_t>(groups));
  std::vector<double> factors(static_cast<std::size_t>(groups), 1.0);
  for (out.iterations = 1; out.iterations <= kMostIterations; ++out.iterations) {
    const GroupedFit f = fit(factors);
    std::vector<double> squares(static_cast<std::size_t>(groups), 0.0), redundancy(squares);
    for (Eigen::Index i = 0; i < f.weights.size(); ++i) {
      const auto g = static_cast<std::size_t>(group[static_cast<std::size_t>(i)]);
      squares[g] +=
          f.weights[i] * f.residuals[i] * f.residuals[i];  // without the factor: s^2 as a whole, not its change
      const double leverage = f.jacobian.row(i) * f.inverse * f.jacobian.row(i).transpose();
      if (f.weights[i] > 0) redundancy[g] += 1 - f.weights[i] / factors[g] * leverage;
    }
    double change = 0;
    for (std::size_t g = 0; g < factors.size(); ++g) {
      VarianceComponent& c = out.groups[g];
      c.redundancy = redundancy[g];
      c.estimated = redundancy[g] >= kFewestRedundant;
      c.factor = c.estimated ? std::max(squares[g] / redundancy[g], kSmallestFactor) : 1;
      c.sd = c.estimated ? c.factor * std::sqrt(2 / redundancy[g]) : 0;
      change = std::max(change, std::abs(c.factor / factors[g] - 1));
      factors[g] = c.factor;
    }
    if (change < kChange) {
      out.converged = true;
      break;
    }
  }
  return out;
}

}  // namespace surveymc::multistation
