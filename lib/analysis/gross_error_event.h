#pragma once
/// Events of gross errors as regions of the normals of a trial: an error that no test shows, a false alarm, a wrong
/// reading blamed. Trials are adjusted one by one; without a converged adjustment a trial has no result.
#include <array>
#include <vector>

#include "analysis/gross_error_prediction.h"
#include "rare/limit_state.h"
#include "rare/union_of_half_spaces.h"

namespace surveymc::analysis {

enum class GrossErrorEventKind {
  missed,           ///< the errors are in, and no test rejects
  false_alarm_any,  ///< no error is in, and some test rejects
  identified_wrong  ///< the errors are in, and the reading of the largest test, which rejects, has none
};
/// In that order.
inline constexpr std::array<const char*, 3> kGrossErrorEvents{"missed", "false_alarm_any", "identified_wrong"};

class GrossErrorEvent final : public rare::LimitState {
 public:
  /// Tests by `prediction.critical`, Pope's if `pope`. `trials` and `prediction` must outlive this.
  GrossErrorEvent(const reliability::GrossErrorTrials& trials, const GrossErrorPrediction& prediction, bool pope,
                  GrossErrorEventKind kind)
      : trials_(trials), prediction_(prediction), pope_(pope), kind_(kind) {}

  /// Observations of the adjustment, up to a multiple of four: the places of a trial's draws.
  int dimension() const override { return (trials_.observations() + 3) / 4 * 4; }
  /// g in units of w (or tau), 0 where the event begins.
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override;

 private:
  double value(const Eigen::VectorXd& normals) const;

  const reliability::GrossErrorTrials& trials_;
  const GrossErrorPrediction& prediction_;
  bool pope_;
  GrossErrorEventKind kind_;
};

/// The tests of linear theory as half spaces in the normals of a trial without errors: |w_i| > critical for every
/// observation that can be tested; tests that are one (inseparable) stand there once.
std::vector<rare::HalfSpace> test_half_spaces(const reliability::GrossErrorTrials& trials,
                                              const GrossErrorPrediction& prediction);

}  // namespace surveymc::analysis
