#pragma once
/// The event that the remedy of chained multistation deletes a reading that is right, where another one of the run is
/// wrong, as a region of the normals of a run. Runs are solved one by one; without a solution a run has no result.
#include "chained/model.h"
#include "chained/reading_tests.h"
#include "random/stream.h"
#include "rare/limit_state.h"
#include "rare/proposal.h"
#include "sensor/chained_runs.h"

namespace surveymc::analysis {

/// The wrong reading.
struct WrongReading {
  int station = 0;  ///< from 0
  std::size_t axis = 0;
  double size = 0;  ///< m/s2 or nT
};

class OutlierDeletedWrong final : public rare::LimitState {
 public:
  /// `truth` and `model` must outlive this.
  OutlierDeletedWrong(const sensor::ChainedRunSetup& truth, const chained::Model& model, const WrongReading& wrong,
                      const chained::Gate& gate)
      : truth_(truth), model_(model), wrong_(wrong), gate_(gate) {}

  int dimension() const override { return 4 * (state_calls() + noise_calls() + toolface_calls()); }
  /// How far the readings that are right are from being deleted, in units of w. Toolfaces are the distribution function
  /// of their normals.
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override;
  /// States and noise where the study has them; the normals of toolfaces stand where it has uniforms.
  rare::TrialAddresses addresses(random::Channel choice) const;
  /// "state", "noise" or "toolface" of every row; "" where nothing is drawn.
  std::vector<std::string> names() const;

 private:
  int stations() const { return static_cast<int>(truth_.attitudes.size()); }
  int state_calls() const { return (9 * stations() + 3) / 4; }
  int noise_calls() const { return (6 * stations() + 3) / 4; }
  int toolface_calls() const { return truth_.random_toolface ? (stations() + 3) / 4 : 0; }

  const sensor::ChainedRunSetup& truth_;
  const chained::Model& model_;
  WrongReading wrong_;
  chained::Gate gate_;
};

}  // namespace surveymc::analysis
