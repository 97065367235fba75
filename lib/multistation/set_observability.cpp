#include "multistation/set_observability.h"

#include <cmath>

#include "stats/linear_algebra.h"

namespace surveymc::multistation {

SetObservability set_observability(const Eigen::MatrixXd& jacobian, const ParameterSet& set,
                                   const PerParameter<double>& prior_sd) {
  SetObservability out;
  Eigen::VectorXd sd(set.size()), sizes(set.size());
  for (int i = 0; i < set.size(); ++i) {
    const double given = prior_sd[static_cast<std::size_t>(set.index(i))];
    sizes[i] = set[i].prior_sd;
    sd[i] = std::isfinite(given) ? given : 1e6 * set[i].prior_sd;
  }
  out.combinations = estimate::observability(jacobian, sizes);
  out.against_prior = stats::singular_values(jacobian * sd.asDiagonal()).values;
  for (const double index : out.combinations.condition_indices) out.rank += index < estimate::kHopelessCondition;
  for (const double value : out.against_prior) out.learnt += value > 1;
  return out;
}

std::string combination_name(const SetObservability& o, const ParameterSet& set, int j) {
  std::vector<const char*> names;
  for (int i = 0; i < set.size(); ++i) names.push_back(set[i].name);
  return estimate::combination_name(o.combinations.directions.col(j), names);
}

}  // namespace surveymc::multistation
