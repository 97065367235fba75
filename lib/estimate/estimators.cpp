#include "estimate/estimators.h"

#include <fmt/ranges.h>

#include "base/error.h"
#include "estimate/field_fit_estimators.h"
#include "estimate/msa.h"
#include "estimate/wls.h"

namespace surveymc::estimate {
namespace {

NewtonOptions newton(const EstimatorOptions& o) { return {o.max_iterations, o.step_tolerance}; }

std::unique_ptr<Estimator> make_fit(const EstimatorInput& in) {
  const FieldFitModel model = field_fit_model(in.options, in.field);
  if (in.options.solver.starts_with("nlopt_"))
    return make_field_fit_nlopt(in.options.name, in.options.solver.substr(6), model, newton(in.options));
  return make_field_fit(in.options.name, model, newton(in.options));
}

/// msa of all six parameters has a kernel of its own.
std::unique_ptr<Estimator> make_unweighted(const EstimatorInput& in) {
  if (!in.options.estimates_all() || in.options.solver != "gauss_newton") return make_fit(in);
  return make_msa(newton(in.options), in.field, in.truth, in.expected);
}

/// A line of the table with what all fits of field_fit.h have.
EstimatorKind field_fit(EstimatorKind kind) {
  kind.takes_subset = kind.has_second_solvers = true;
  if (!kind.make) kind.make = make_fit;
  kind.predict = field_fit_sensitivity;
  return kind;
}

}  // namespace

const std::vector<EstimatorKind>& estimators() {
  static const std::vector<EstimatorKind> table{
      field_fit(
          {.name = "msa", .fits = "(Bh, Bv) of all stations to the reference, unweighted", .make = make_unweighted}),
      field_fit({.name = "msa_weighted",
                 .fits = "(Bh, Bv) with its covariance, the reference's error as if new at every station",
                 .weighs = true,
                 .derivative = "measured"}),
      field_fit({.name = "msa_joint",
                 .fits = "(Bh, Bv) with the sensors' covariance; the reference is unknown too, with priors",
                 .weighs = true,
                 .estimates_reference = true,
                 .derivative = "fitted"}),
      {.name = "wls",
       .fits = "readings to the true field in the tool frame, with priors",
       .needs_attitude = true,
       .weighs = true,
       .weighs_each_reading = true,
       .make = [](const EstimatorInput& in) { return make_wls(in.options.assumed, in.truth); },
       .predict = wls_sensitivity},
      field_fit({.name = "wls_consider",
                 .fits = "(Bh, Bv) with the sensors' covariance; the reference's error is considered, not estimated",
                 .weighs = true,
                 .derivative = "measured"}),
  };
  return table;
}

const EstimatorKind& estimator_kind(std::string_view name) {
  for (const EstimatorKind& k : estimators())
    if (k.name == name) return k;
  throw InputError(fmt::format("estimator.name = \"{}\": must be one of {}", name, fmt::join(estimator_names(), ", ")));
}

}  // namespace surveymc::estimate
