#include "estimate/estimator.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "base/error.h"
#include "estimate/estimators.h"

namespace surveymc::estimate {

const std::vector<std::string>& estimator_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const EstimatorKind& k : estimators()) all.emplace_back(k.name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& solver_names() {
  static const std::vector<std::string> names{"gauss_newton", "nlopt_neldermead", "nlopt_bobyqa", "nlopt_lbfgs"};
  return names;
}

const std::vector<std::string>& derivative_names() {
  static const std::vector<std::string> names{"measured", "fitted"};
  return names;
}

std::unique_ptr<Estimator> make_estimator(const EstimatorOptions& o, const survey::ReferenceField& field,
                                          const std::vector<survey::StationFields>& truth,
                                          const std::vector<survey::Vec3<double>>& expected) {
  const auto known = [](const std::vector<std::string>& names, const std::string& n) {
    return std::find(names.begin(), names.end(), n) != names.end();
  };
  const EstimatorKind& kind = estimator_kind(o.name);
  require(known(solver_names(), o.solver), "estimator.solver = \"{}\": must be one of {}", o.solver,
          fmt::join(solver_names(), ", "));
  require(o.derivative.empty() || known(derivative_names(), o.derivative),
          "estimator.derivative = \"{}\": must be one of {}", o.derivative, fmt::join(derivative_names(), ", "));
  require(o.max_iterations >= 1, "estimator.max_iterations = {}: must be at least 1", o.max_iterations);
  require(o.step_tolerance > 0, "estimator.step_tolerance = {}: must be > 0", o.step_tolerance);
  require(field.total > 0, "field.total_nT = {}: must be > 0", field.total);
  require(kind.has_second_solvers || o.solver == "gauss_newton",
          "estimator.solver = \"{}\": {} is solved in closed form", o.solver, o.name);
  require(o.estimates_all() || kind.takes_subset, "estimator.estimated: {} estimates {}", o.name,
          kind.estimates_all ? "all six parameters" : "its own parameters only");
  return kind.make({o, field, truth, expected});
}

}  // namespace surveymc::estimate
