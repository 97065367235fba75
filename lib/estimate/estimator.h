#pragma once
/// The interface of all estimators of sensor errors from a survey.
#include <algorithm>
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
  survey::LaneArray converged;   ///< 1, or 0 where the estimate must not be used
};

/// One virtual call per batch of trials, never per trial: the loop over trials is inside. An estimator has no state;
/// several threads may call solve().
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
  /// independent way to the same minimum). wls is linear and needs no solver.
  std::string solver = "gauss_newton";
  int max_iterations = 200;
  double step_tolerance = 1e-9;  ///< see NewtonOptions
  InputErrors assumed = {};      ///< not used by msa
  /// Which of gain x, y, z and bias x, y, z are unknowns. The others are taken as 1 and 0, whatever their true values;
  /// their errors go into the estimates. For wls all six are unknowns.
  std::array<bool, 6> estimated{true, true, true, true, true, true};
  /// Where msa_weighted, msa_joint and wls_consider take the derivative by a gain (field_fit.h): "measured", at the
  /// reading, which gives the minimum; or "fitted", at the fitted field, which avoids the shift of gains by noise. "":
  /// the default of the table of estimators.
  std::string derivative = {};

  /// True if none of the six is left out.
  bool estimates_all() const { return std::find(estimated.begin(), estimated.end(), false) == estimated.end(); }
};

/// Names of the table of estimators, of solvers and of derivatives, for messages and checks.
const std::vector<std::string>& estimator_names();
const std::vector<std::string>& solver_names();
const std::vector<std::string>& derivative_names();

/// `field` is the nominal reference: scale of the unknowns, and the point at which weights are computed. `truth` (one
/// entry a station) is the field that wls has to know; the other estimators use it only with `expected`. `expected` are
/// readings (nT, one entry a station) close to those of all trials, in a simulation the readings without noise. With
/// `expected`, msa starts all trials from the solution of these readings and uses their matrix: the same minimum to the
/// step tolerance, in a third of the time. A trial for which this finds no minimum is solved as without
/// `expected`. Throws InputError on an unknown name, an option out of range, a missing truth.
std::unique_ptr<Estimator> make_estimator(const EstimatorOptions& options, const survey::ReferenceField& field,
                                          const std::vector<survey::StationFields>& truth = {},
                                          const std::vector<survey::Vec3<double>>& expected = {});

}  // namespace surveymc::estimate
