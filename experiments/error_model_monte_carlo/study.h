#pragma once
/// One point of the study `error_model_monte_carlo` (see study.cpp): the run of its trials and the tables they become.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/verdict_stop.h"
#include "error_model_monte_carlo/scenario.h"
#include "orders/predictions.h"
#include "propagate/disturbed_errors.h"
#include "propagate/drawn_well.h"
#include "propagate/well_chain.h"
#include "stats/control_variate.h"
#include "study/experiment.h"

namespace surveymc::studies::error_model_monte_carlo {

/// A prediction of a point's position errors.
struct Formulation {
  std::string name;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m, N E V
  Eigen::Matrix3d covariance;                      ///< m2
  Eigen::Matrix3d axes;    ///< columns: largest first; beyond first order: those of minimum_curvature
  Eigen::Vector3d sd;      ///< along the axes, m
  Eigen::Matrix3d weight;  ///< inverse of the covariance; NaN where it has none
  Eigen::Matrix2d horizontal_axes, horizontal_weight;
};

/// One reported depth.
struct Depth {
  double md = 0;  ///< m
  propagate::WellPoint point;
  Eigen::Vector3d truth;     ///< position, N E V from the first station, m
  Eigen::Matrix3d hla;       ///< hla = m nev; the hole turns along the arc
  Eigen::Matrix3Xd effects;  ///< of every draw, exact first order: the control
  std::vector<Formulation> formulations;
  orders::Predictions orders;  ///< those that are wanted
  compare::WellTails tails;
};

/// A source at one depth, by one first-order formulation.
struct SourcePrediction {
  Eigen::Matrix3d covariance;
  std::vector<Eigen::Vector3d> axes;  ///< those that are compared: the effect's direction, or axes of several draws
  std::vector<double> sd;             ///< along them, m
  bool cancels = false;               ///< not judged: the effects of the stations nearly cancel here
};

/// A well that is drawn: of all sources, or of one.
struct Drawn {
  propagate::DrawnWell well;
  int source = -1;                       ///< -1: all
  std::vector<Eigen::Matrix3d> control;  ///< covariance of the control at every depth
};

/// The sd and the mean of a drawn well along a direction are estimated with the control of that direction.
struct Quantity {
  std::size_t drawn = 0, depth = 0;
  Eigen::Vector3d direction;
};

/// Columns of a depth's moments, beside the controlled ones: N, E, V; then for every formulation NEES less that of the
/// control, horizontal NEES, both horizontal axes.
constexpr Eigen::Index kPerFormulation = 4;
inline Eigen::Index column_of(std::size_t formulation, int which) {
  return 3 + kPerFormulation * static_cast<Eigen::Index>(formulation) + which;
}

/// The events of a scenario that has some. Throws InputError where a well cannot be drawn, or nothing moves it.
std::vector<events::TrialEvent> events_of(const Scenario& scenario);

class ErrorModelMonteCarlo final : public study::StudyPoint {
 public:
  explicit ErrorModelMonteCarlo(Scenario scenario);

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }
  stats::Tally run_block(montecarlo::TrialBlock block) const override;
  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

  /// All rows of a depth, their components being numbers of quantities; without a point they have no numbers.
  static std::vector<compare::Row> rows_of(const Scenario& scenario, const ErrorModelMonteCarlo* point = nullptr,
                                           std::size_t depth = 0);

 private:
  struct Found {
    compare::Estimate sd;
    stats::SampleSummary mean;  ///< of the error along the direction; its interval is the controlled one
  };

  void predict();
  void predict_sources();
  void predict_tails();
  void plan_draws();
  /// The covariance of what is drawn is in question, of a disturbance with a memory or of laws: a controlled sd is near
  /// the prediction whatever the draws are, so the trials alone answer.
  bool is_plain() const { return s_.laws.any() || (s_.disturbance && s_.disturbance->has_memory()); }
  /// Of one source alone at a point (m2).
  Eigen::Matrix3d source_covariance(std::size_t source, const propagate::WellPoint& point,
                                    propagate::FirstOrder which) const;
  /// The draws of a disturbance, if there is one.
  std::optional<survey::LaneArray> made_draws(std::uint64_t first_trial, int groups) const;
  /// Where the counts of tails begin in a tally, behind those of the ellipses; then those of the laws.
  std::size_t tail_counts() const { return 3 * s_.formulations.size() * depths_.size(); }
  std::size_t law_counts() const {
    return tail_counts() + (s_.tails.wanted ? depths_.size() * compare::kWellDirections.size() * s_.tails.k.size() : 0);
  }
  std::size_t add_quantity(std::size_t drawn, std::size_t depth, const Eigen::Vector3d& direction);
  Found found(const stats::Tally& tally, std::size_t quantity) const;
  stats::SampleSummary summary_of(const stats::Tally& tally, std::size_t depth, Eigen::Index column) const;
  std::uint64_t units(const stats::Tally& tally) const;
  Eigen::Matrix3d sample_covariance(const stats::Tally& tally, std::size_t depth) const;

  /// Tells rows of one name apart, where there are several depths.
  std::string place(std::size_t depth) const;
  compare::RowsOfTables judged_rows(const stats::Tally& tally) const;
  std::vector<compare::ComparisonRow> compared(const stats::Tally& tally, std::size_t depth,
                                               const std::string& table) const;
  /// axes, position and position_hla.
  std::vector<store::Table> judged_tables(const stats::Tally& tally) const;
  store::Table disturbance_runs_table() const;
  store::Table by_source_table(const stats::Tally& tally) const;
  store::Table ellipse_table(const stats::Tally& tally) const;
  store::Table orders_table(const stats::Tally& tally) const;
  store::Table order_coverage_table(const stats::Tally& tally) const;
  store::Table covariance_table(const stats::Tally& tally) const;
  store::Table additivity_table(const stats::Tally& tally) const;
  store::Table tails_table(const stats::Tally& tally) const;

  Scenario s_;
  random::Stream stream_;
  propagate::WellErrors errors_;
  orders::WantedOrders wanted_;
  std::vector<propagate::DrawPlace> places_;
  propagate::WellMixing mixing_;
  /// Of every element with a law that some draw has: such a draw.
  std::vector<compare::LawDraw> law_draws_;
  std::optional<propagate::DisturbedDraws> disturbed_;  ///< draws of errors_ that a disturbance makes
  propagate::WellErrors independent_;                   ///< errors_ by independent draws: for predictions
  std::vector<Depth> depths_;
  std::vector<std::size_t> single_;  ///< sources that are looked at alone
  /// sources_[i][depth][formulation] of single_[i]; first-order formulations in the order of `formulations`.
  std::vector<std::vector<std::vector<SourcePrediction>>> sources_;
  std::vector<Drawn> drawn_;
  std::vector<Quantity> quantities_;
  /// Numbers of quantities: nev_[drawn][depth] + axis; hla_[depth] + axis, axes_[formulation][depth] + axis of the
  /// whole; along_[i][depth][formulation] + axis of source single_[i], whole_axes_[i][depth] + axis along the whole's
  /// axes.
  std::vector<std::vector<std::size_t>> nev_, axes_, whole_axes_;
  std::vector<std::size_t> hla_, whole_sd_;  ///< whole_sd_: along the axes of the control
  std::vector<std::vector<std::vector<std::size_t>>> along_;
  compare::VerdictStop stop_;
};

}  // namespace surveymc::studies::error_model_monte_carlo
