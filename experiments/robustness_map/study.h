#pragma once
/// One point of the study `robustness_map` (see study.cpp).
#include <memory>
#include <vector>

#include "analysis/robust_claim.h"
#include "compare/row.h"
#include "multistation/robust.h"
#include "robustness_map/scenario.h"
#include "sensor/disturbed_runs.h"
#include "study/experiment.h"
#include "survey/corrected_position.h"

namespace surveymc::studies::robustness_map {

/// What is tallied of each estimator: the informed fit first, then the scenario's losses.
enum Component {
  kLateral,      ///< contribution of the right stations to the lateral error of the last position, m
  kSquare,       ///< its square, m2
  kNees,         ///< squared Mahalanobis distance of the estimate by the claimed covariance
  kRightWeight,  ///< mean weight of the right stations
  kWrongWeight,  ///< of the wrong ones; 0 without any
  kComponents
};
inline int component(std::size_t estimator, Component which) {
  return static_cast<int>(estimator) * kComponents + which;
}
/// Name of an estimator of the tally.
std::string estimator_name(const Scenario& scenario, std::size_t estimator);

/// Rows of the table `prediction`. `variance_ratios`: of each loss by first order; empty: no predictions.
std::vector<compare::Row> rows_of(const Scenario& scenario, const std::vector<double>& variance_ratios = {});

/// A ratio of two root mean squares of the same trials.
compare::Estimate rms_ratio(const stats::Moments& moments, std::size_t estimator, std::size_t over, double confidence);

class RobustnessPoint final : public study::StudyPoint {
 public:
  explicit RobustnessPoint(Scenario scenario);

  stats::Tally run_block(montecarlo::TrialBlock block) const override;
  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  struct Outcome;  // of a batch
  Outcome simulate(std::uint64_t first, int count) const;
  std::vector<compare::ComparisonRow> prediction_rows(const stats::Tally& tally) const;

  Scenario s_;
  sensor::DisturbedRunSetup setup_;
  analysis::MeasuredStations stations_;
  survey::TiedSurvey tied_;
  multistation::FitPlan plan_;
  std::vector<multistation::RobustOptions> estimators_;  ///< of the informed fit, then of each loss
  std::vector<analysis::RobustClaim> claims_;
  std::vector<multistation::LossCost> costs_;
  std::vector<double> variance_ratios_;  ///< of each loss, first order
  std::vector<compare::Row> rows_;
};

/// One row an estimator: what gross errors do to it.
store::Table breakdown_table(const Scenario& scenario, const std::vector<double>& variance_ratios,
                             const stats::Tally& tally);

}  // namespace surveymc::studies::robustness_map
