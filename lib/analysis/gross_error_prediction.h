#pragma once
/// Predictions for the trials of gross errors: rates of false alarms, detection and identification, by linear theory
/// (reliability/significance.h, reliability/identification.h) and by the solution of the nonlinear adjustment.
#include <vector>

#include "base/units.h"
#include "reliability/gross_error_trials.h"
#include "reliability/parity.h"
#include "reliability/significance.h"

namespace surveymc::analysis {

/// Shifts of the tests by the injected errors, without noise.
struct ErrorShift {
  std::vector<double> w;  ///< of each injected observation's test; NaN where the adjustment does not converge
  double omega = 0;       ///< noncentrality of the general test
};

/// All values with which the rates of the trials are compared.
struct GrossErrorPrediction {
  double two_sided_alpha, critical;     ///< of the single test: |w| or |tau|
  reliability::DimensionLevel general;  ///< B-method: the general test finds nabla_0 with the power of the single test
  double redundancy;
  ErrorShift linear, nonlinear;
  reliability::ParityModel model;  ///< at the error-free readings
  double false_alarm_any = kNaN;   ///< some test rejects though there is no error, linear theory
  double linear_any = kNaN;        ///< some test rejects, linear theory
  /// By the shift of the nonlinear adjustment and the tests at its solution; NaN: not known (linear_rates).
  double any = kNaN;
  double identified = kNaN;  ///< one error, strategy single; NaN, too, where noise may tie or untie its observation
  bool in_group = false;     ///< the observation in error is in a group: `identified` is the group's
  bool may_be_tied = false;  ///< it is in none, but noise may bring it into one now and then
};

/// With Pope's test (variance unknown) in place of the w-test if `pope`.
GrossErrorPrediction predict_gross_errors(const reliability::GrossErrorTrials& trials,
                                          const reliability::TestLevels& levels, bool pope);

/// Power of the single test of error k of the prediction, whose tests are shifted by `shift`; NaN where no theory gives
/// it.
double single_test_power(const GrossErrorPrediction& p, const ErrorShift& shift, std::size_t k, bool pope);

}  // namespace surveymc::analysis
