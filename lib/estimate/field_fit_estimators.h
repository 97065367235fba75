#pragma once
#include <memory>
#include <string>

#include "estimate/estimator.h"
#include "estimate/field_fit.h"
#include "estimate/newton.h"

namespace surveymc::estimate {

/// The minimum of field_fit.h on lanes of trials.
std::unique_ptr<Estimator> make_field_fit(const std::string& name, const FieldFitModel& model,
                                          const NewtonOptions& options);

/// The same minimum by NLopt, one trial at a time; `algorithm` is "neldermead", "bobyqa" or "lbfgs".
std::unique_ptr<Estimator> make_field_fit_nlopt(const std::string& name, const std::string& algorithm,
                                                const FieldFitModel& model, const NewtonOptions& options);

}  // namespace surveymc::estimate
