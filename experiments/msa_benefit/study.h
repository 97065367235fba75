#pragma once
/// One point of the study `msa_benefit` (see study.cpp): its maps, and the trials that verify them.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/verdict_stop.h"
#include "msa_benefit/scenario.h"
#include "orders/predictions.h"
#include "study/experiment.h"
#include "survey/readings.h"

namespace surveymc::studies::msa_benefit {

/// A direction of [[verify]], with the inputs of its trials.
struct VerifiedWell {
  VerifiedDirection direction;
  survey::Survey survey;
  sensor::CleanReadings clean;
  Eigen::RowVector3d lateral_N, position;  ///< the true ones
  analysis::Benefit benefit;
  std::optional<orders::Predictions> orders = {};  ///< beyond first order, of the position after MSA
  std::vector<std::string> inputs = {};            ///< names of its normals
};

/// All rows of the table verification and of the calibration, direction by direction, their direction as formulation,
/// and behind it the order of a prediction beyond the first. `wells`: those of [[verify]]; without them the rows have
/// no predictions.
std::vector<compare::Row> rows_of(const Scenario& scenario, const std::vector<VerifiedWell>& wells = {});

class BenefitPoint final : public study::StudyPoint {
 public:
  /// Throws InputError where the stations do not determine the estimated parameters.
  explicit BenefitPoint(Scenario scenario);

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }
  stats::Tally run_block(montecarlo::TrialBlock block) const override;
  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  struct Errors;  // of a batch
  /// `made`: the reference's draws of these trials where a disturbance makes them.
  Errors simulate(const VerifiedWell& v, std::uint64_t first, int count, const survey::LaneArray& made) const;
  /// Of table `verification`, direction by direction, which is their formulation.
  std::vector<compare::ComparisonRow> verification_rows(const stats::Tally& tally) const;
  store::Table verification_table(const stats::Tally& tally) const;
  store::Table tails_table(const stats::Tally& tally) const;
  /// Where the counts of tails begin in a tally, and behind them those of the laws.
  std::size_t tail_counts() const { return calibrated_.size() * stats::kPitSlots; }
  std::size_t law_counts() const { return tail_counts() + tails_.size() * s_.tails.k.size(); }
  store::Table orders_table(const stats::Tally& tally) const;
  /// Which order the lateral needs in every direction of the map: entry of orders::kOrderNames; NaN where MSA is not
  /// determined. Throws Interrupted.
  std::vector<double> orders_needed(const std::vector<analysis::Benefit>& benefits,
                                    const montecarlo::RunOptions& options) const;

  Scenario s_;
  compare::VerdictStop stop_;
  std::unique_ptr<estimate::Estimator> estimator_;
  survey::LaneArray uncorrected_;  ///< parameters that leave readings as they are
  std::vector<VerifiedWell> verified_;
  sensor::ReferenceMixing mixing_;
  std::vector<compare::LawDraw> law_draws_;
  std::vector<compare::TailQuantity> tails_;  ///< direction by direction: of kTailNames
  std::vector<compare::Row> rows_, calibrated_rows_;
  std::vector<compare::CalibratedQuantity> calibrated_;  ///< of the calibrated rows
};

/// Azimuth (deg) and lateral (m) after the correction, kTailNames: to first order a sum of normals and of the
/// reference's errors by their laws.
std::vector<compare::TailQuantity> tails_after(const analysis::Benefit& benefit, const sensor::ReferenceMixing& mixing);
/// Maps of how often they are beyond every tails.k predicted sd.
std::vector<store::Map> tail_maps(const Scenario& scenario, const std::vector<analysis::Benefit>& benefits,
                                  const sensor::ReferenceMixing& mixing);

/// `benefits` on the grid of the scenario, azimuth fastest. `orders`: those needed; empty: no such map.
std::vector<store::Map> benefit_maps(const Scenario& scenario, const std::vector<analysis::Benefit>& benefits,
                                     const std::vector<double>& orders);
/// A row each for azimuth and lateral: where MSA helps, where it harms.
store::Table benefit_summary(const Scenario& scenario, const std::vector<analysis::Benefit>& benefits);

}  // namespace surveymc::studies::msa_benefit
