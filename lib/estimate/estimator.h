#pragma once
/// A way of getting sensor errors out of a survey: one interface for all estimators.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "estimate/input_errors.h"
#include "survey/frames.h"
#include "survey/readings.h"
#include "survey/reference_field.h"

namespace surveymc::estimate {

/// Estimates of a batch of trials. Rows of `parameters`: gain x, y, z (1), bias x, y, z (nT).
struct EstimateBlock {
  explicit EstimateBlock(int trials)
      : parameters(survey::groups_for(trials), 6),
        reference(survey::groups_for(trials), 2),
        claimed_variance(survey::groups_for(trials), 6),
        cost(survey::groups_for(trials), 1),
        iterations(survey::groups_for(trials), 1),
        converged(survey::groups_for(trials), 1) {}

  survey::LaneArray parameters;
  survey::LaneArray reference;  ///< Bh, Bv (nT) at the first station, of estimators that estimate the reference
  survey::LaneArray
      claimed_variance;          ///< of the six parameters, of estimators whose claim depends on the trial's readings
  survey::LaneArray cost;        ///< sum of squared residuals at the minimum, nT^2
  survey::LaneArray iterations;  ///< evaluations of the model
  survey::LaneArray converged;   ///< 1, or 0 where the estimate is not to be used
};

/// Virtual once per batch of trials, never per trial: the loop over trials is inside. Stateless; solve() may be called
/// from several threads.
class Estimator {
 public:
  virtual ~Estimator() = default;
  virtual std::string name() const = 0;
  virtual bool estimates_reference() const { return false; }
  virtual void solve(const survey::ReadingBlock& readings, EstimateBlock& out) const = 0;
};

struct EstimatorOptions {
  std::string name = "msa";  ///< a line of the table of estimators (estimators.h); models: field_fit.h, wls.h
  /// "gauss_newton" (lanes), or "nlopt_neldermead", "nlopt_bobyqa", "nlopt_lbfgs" (one trial at a time; a second,
  /// independent way to the same minimum). wls is linear and has none.
  std::string solver = "gauss_newton";
  int max_iterations = 200;
  double step_tolerance = 1e-9;  ///< see NewtonOptions
  InputErrors assumed;           ///< not used by msa
  /// Which of gain x, y, z and bias x, y, z are unknowns. The others are taken as 1 and 0, whatever they are; their
  /// errors go into the estimates. Of wls all are.
  std::array<bool, 6> estimated{true, true, true, true, true, true};
  /// Of msa_weighted, msa_joint and wls_consider, where the derivative by a gain is taken (field_fit.h): "measured", at
  /// the reading, which is the minimum; or "fitted", at the fitted field, without its shift by noise. "": the one that
  /// the table of estimators names.
  std::string derivative;
};

/// Names of the table of estimators, of solvers and of derivatives, for messages and checks.
const std::vector<std::string>& estimator_names();
const std::vector<std::string>& solver_names();
const std::vector<std::string>& derivative_names();

/// `field` is the nominal reference: scale of the unknowns, and the point that weights are made at. `truth` (one entry
/// a station) is what wls has to know; the others use it only with `expected`: readings (nT, one entry a station) that
/// those to come will be near, in a simulation the readings without noise. With them msa may start from their solution
/// and share their matrix: the same minimum in a third of the time, to the step tolerance; where that does not lead to
/// a minimum it takes the way it takes without them. Throws InputError on an unknown name, an option out of range, a
/// missing truth.
std::unique_ptr<Estimator> make_estimator(const EstimatorOptions& options, const survey::ReferenceField& field,
                                          const std::vector<survey::StationFields>& truth = {},
                                          const std::vector<survey::Vec3<double>>& expected = {});

}  // namespace surveymc::estimate
