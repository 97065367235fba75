#pragma once
/// One point of the study `corrected_codes` (see study.cpp).
#include <memory>
#include <optional>
#include <vector>

#include "compare/row.h"
#include "corrected_codes/runs.h"
#include "corrected_codes/scenario.h"
#include "orders/predictions.h"
#include "study/experiment.h"

namespace surveymc::studies::corrected_codes {

/// Quantities of the last position, in the order in which they are tallied: before the correction, then after it.
inline constexpr std::array<analysis::CodeQuantity, 5> kPositions{
    analysis::CodeQuantity::lateral, analysis::CodeQuantity::high_side, analysis::CodeQuantity::north,
    analysis::CodeQuantity::east, analysis::CodeQuantity::worst};
inline constexpr std::size_t kPositionCount = kPositions.size();
inline constexpr std::size_t kTails = 2;  ///< counted beyond two and three claimed sd

/// The rows of table `prediction`: the ratio of what is there to what is claimed, by first order and by Monte Carlo.
/// `comparison`: of the well; without it the rows have no predictions.
/// `orders`: of the errors of the last position, where the scenario wants some.
std::vector<compare::Row> rows_of(const Scenario& scenario, const analysis::CodeComparison* comparison = nullptr,
                                  const orders::Predictions* orders = nullptr);

/// One row of table `claims`: a quantity at a depth, in one scope. Lengths in m, of azimuth sinI dA in rad.
struct Claim {
  analysis::CodeQuantity quantity = {};
  analysis::CodeScope scope = {};
  std::size_t station = 0;  ///< entry of MeasuredStations
  double md = 0;            ///< m
  analysis::CodeSds sds;    ///< first order
  /// Monte Carlo: NaN without trials.
  double before = kNaN, after = kNaN, mean = kNaN;
  stats::Interval before_interval{kNaN, kNaN}, after_interval{kNaN, kNaN};
  bool lost = false;                        ///< more than 1 % of the trials have no solution
  std::int64_t beyond2 = -1, beyond3 = -1;  ///< trials outside of so many claimed sd; -1: not known
};

/// "holds", "broken", "undecided", "undetermined", by first order and by Monte Carlo, and the class.
struct Judged {
  std::string predicted, predicted_class, verdict, judged_class;
};
Judged judge(const Claim& claim, double margin);

class CorrectedCodesPoint final : public study::StudyPoint {
 public:
  explicit CorrectedCodesPoint(Scenario scenario);

  stats::Tally run_block(montecarlo::TrialBlock block) const override;
  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  struct Errors;  // of a batch
  Errors simulate(std::uint64_t first, int count) const;
  std::vector<Claim> claims_of(const stats::Tally& tally) const;
  store::Table orders_table(const stats::Tally& tally) const;
  void predict_tails();
  /// Where the counts of tails begin in a tally; those of the laws follow.
  std::size_t tail_counts() const {
    return kTails * (kPositionCount + static_cast<std::size_t>(runs_->stations())) + 1;
  }

  Scenario s_;
  std::optional<analysis::CodeComparison> comparison_;  ///< of the well
  std::vector<compare::Row> rows_;
  std::optional<CorrectedRuns> runs_;          ///< where there are trials, or orders beyond the first
  std::optional<orders::Predictions> orders_;  ///< none where the correction is not determined
  std::array<Eigen::RowVector3d, kPositionCount> directions_;
  std::array<double, kPositionCount> claimed_{};  ///< sd along each of them, scope magnetic, m
  std::vector<compare::TailQuantity> tails_;      ///< of kPositions after the correction
  std::vector<compare::LawDraw> law_draws_;       ///< of the run
  std::vector<double> claimed_azimuth_;           ///< sd of sinI dA at each measured station, rad
};

/// Names and settings of a point's row, and the tables made of them.
store::Table claims_table(const Scenario& scenario, const std::vector<Claim>& claims, const stats::Tally& tally);
store::Table budget_table(const Scenario& scenario, const analysis::CodeComparison& comparison);
store::Table requirement_table(const Scenario& scenario, const analysis::CodeComparison& comparison);
store::Table terms_table(const Scenario& scenario);
/// The zone about magnetic east and west where axial correction does not keep the claim.
store::Table zone_table(const Scenario& scenario);
store::Table validity_table(const Scenario& scenario, const analysis::CodeComparison* comparison,
                            const stats::Tally& tally);
/// Maps ratio_lateral, ratio_azimuth, ratio_worst, class, kappa, half_angle, and order_needed where the profile is
/// wanted; table `shares` of the classes.
/// `limits`: grow to the largest of a cell. Throws Interrupted.
std::vector<store::Map> code_maps(const Scenario& scenario, const montecarlo::RunOptions& options,
                                  analysis::RobustLimits& limits);
store::Table shares_table(const Scenario& scenario, const std::vector<store::Map>& maps);

}  // namespace surveymc::studies::corrected_codes
