#pragma once
/// A way of getting sensor errors out of a survey: one interface for all estimators.
#include <memory>
#include <string>
#include <vector>

#include "field/reference_field.h"
#include "survey/readings.h"

namespace surveymc {

/// Estimates of a batch of trials. Rows of `parameters`: gain x, y, z (1), bias x, y, z (nT).
struct EstimateBlock {
  explicit EstimateBlock(int trials)
      : parameters(groups_for(trials), 6),
        cost(groups_for(trials), 1),
        iterations(groups_for(trials), 1),
        converged(groups_for(trials), 1) {}

  LaneArray parameters;
  LaneArray cost;        ///< sum of squared residuals at the minimum, nT^2
  LaneArray iterations;  ///< evaluations of the model
  LaneArray converged;   ///< 1, or 0 where the estimate is not to be used
};

/// Virtual once per batch of trials, never per trial: the loop over trials is inside. Stateless; solve() may be called
/// from several threads.
class Estimator {
 public:
  virtual ~Estimator() = default;
  virtual std::string name() const = 0;
  virtual void solve(const ReadingBlock& readings, EstimateBlock& out) const = 0;
};

struct EstimatorOptions {
  std::string name = "msa";
  /// "gauss_newton" (lanes), or "nlopt_neldermead", "nlopt_bobyqa", "nlopt_lbfgs" (one trial at a time; a second,
  /// independent way to the same minimum).
  std::string solver = "gauss_newton";
  int max_iterations = 200;
  double step_tolerance = 1e-9;  ///< see MsaOptions
};

/// Names that make_estimator knows, for messages and checks.
const std::vector<std::string>& estimator_names();
const std::vector<std::string>& solver_names();

/// `field` gives the scale of the unknowns. Throws InputError on an unknown name or option out of range.
std::unique_ptr<Estimator> make_estimator(const EstimatorOptions& options, const ReferenceField& field);

}  // namespace surveymc
