#include "estimate/estimator.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "base/error.h"
#include "estimate/field_fit_estimators.h"
#include "estimate/msa.h"
#include "estimate/wls.h"

namespace surveymc {

const std::vector<std::string>& estimator_names() {
  static const std::vector<std::string> names{"msa", "msa_weighted", "msa_joint", "wls", "wls_consider"};
  return names;
}

const std::vector<std::string>& solver_names() {
  static const std::vector<std::string> names{"gauss_newton", "nlopt_neldermead", "nlopt_bobyqa", "nlopt_lbfgs"};
  return names;
}

std::unique_ptr<Estimator> make_estimator(const EstimatorOptions& o, const ReferenceField& field,
                                          const std::vector<StationFields>& truth,
                                          const std::vector<Vec3<double>>& expected) {
  const auto known = [](const std::vector<std::string>& names, const std::string& n) {
    return std::find(names.begin(), names.end(), n) != names.end();
  };
  require(known(estimator_names(), o.name), "estimator.name = \"{}\": must be one of {}", o.name,
          fmt::join(estimator_names(), ", "));
  require(known(solver_names(), o.solver), "estimator.solver = \"{}\": must be one of {}", o.solver,
          fmt::join(solver_names(), ", "));
  require(o.max_iterations >= 1, "estimator.max_iterations = {}: must be at least 1", o.max_iterations);
  require(o.step_tolerance > 0, "estimator.step_tolerance = {}: must be > 0", o.step_tolerance);
  require(field.total > 0, "field.total_nT = {}: must be > 0", field.total);
  const bool nlopt = o.solver.starts_with("nlopt_");
  const bool all = std::find(o.estimated.begin(), o.estimated.end(), false) == o.estimated.end();
  if (o.name == "wls") {
    require(!nlopt, "estimator.solver = \"{}\": wls is linear, it is solved in closed form", o.solver);
    require(all, "estimator.estimated: wls estimates all six parameters");
    return make_wls(o.assumed, truth);
  }
  const NewtonOptions newton{o.max_iterations, o.step_tolerance};
  if (o.name == "msa" && !nlopt && all) return make_msa(newton, field, truth, expected);
  const FieldFitModel model = field_fit_model(o, field);
  if (nlopt) return make_field_fit_nlopt(o.name, o.solver.substr(6), model, newton);
  return make_field_fit(o.name, model, newton);
}

}  // namespace surveymc
