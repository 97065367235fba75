#pragma once
/// One point of the study `msa_position` (see study.cpp): the run of its trials and the tables they become.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/msa_prediction.h"
#include "compare/calibration.h"
#include "compare/verdict_stop.h"
#include "msa_position/scenario.h"
#include "orders/predictions.h"
#include "stats/control_variate.h"
#include "stats/sample_summary.h"
#include "stats/tests.h"
#include "study/experiment.h"

namespace surveymc::studies::msa_position {

/// Index of each quantity in the tallied vector. -1: not tallied in this scenario.
struct Components {
  static constexpr int parameter = 0, position = 6;  ///< errors of six parameters and three coordinates: always there
  int nees_parameters = 9;
  int nees_horizontal = -1;  ///< squared Mahalanobis distance, one per formulation
  int axes = -1;             ///< along major and minor axis of each formulation's horizontal ellipse
  int hole = -1;             ///< high side, lateral, along hole
  int reference = -1;        ///< errors of total field (nT) and dip (deg) of an estimator that estimates them
  int hanak = -1;            ///< six parameters in Hanak's convention
  int claimed = -1;          ///< variances of the six parameters that the estimator claims for the trial
  int count = 10;

  explicit Components(const Scenario& scenario);
};
/// Quantities of table `tails`.
inline const std::vector<std::string> kTailNames{"north", "east", "vertical", "high_side", "lateral", "along_hole"};

/// In place of a component: the squared distance by the claimed covariance; the tangent of the error of azimuth i.
constexpr int kClaimedDistance = -2, kAzimuth = -3;  // kAzimuth - i

/// Gain and bias of an axis in Hanak's convention, b = (2 - scale) m - offset.
struct HanakPair {
  double scale, offset;
};
inline HanakPair hanak_of(double gain, double bias) { return {2 - 1 / gain, bias / gain}; }

/// The inputs of the trials of a scenario, and the predictions with which they are compared.
struct Model {
  sensor::CleanReadings clean;
  analysis::MsaPrediction prediction;
  std::unique_ptr<estimate::Estimator> estimator;
  std::array<Eigen::Matrix2d, 3> horizontal_weight;  ///< inverse horizontal covariances
  std::array<Eigen::Matrix2d, 3> horizontal_axes;    ///< columns: major, minor
  Eigen::Matrix3d hla_from_nev;                      ///< of the true hole at the last station
  Eigen::Matrix<double, 6, 6> parameter_weight;
  std::optional<orders::Predictions> orders;  ///< beyond first order; displacements from the true position
  std::vector<std::string> inputs;            ///< names of the normals of `orders`
  Eigen::Vector3d true_position;              ///< N, E, V of the last station from the first
};
/// Predicts, and chooses the estimator on 64 trials. Throws InputError where the stations cannot determine the
/// parameters.
Model model_of(const Scenario& scenario);

/// All rows of the comparison tables, and those of the calibration, in the order of the tables; without a model they
/// have no predictions.
std::vector<compare::Row> rows_of(const Scenario& scenario, const Model* model = nullptr);

/// The events of a scenario that has some, with first-order predictions. Throws as model_of().
std::vector<events::TrialEvent> events_of(const Scenario& scenario);

class PositionPoint final : public study::StudyPoint {
 public:
  PositionPoint(Scenario scenario, Model model);

  std::uint64_t trials_needed(const stats::Tally& tally) const override;
  stats::Tally run_block(montecarlo::TrialBlock block) const override;
  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  struct Batch;
  void simulate(std::uint64_t first, Batch& b) const;
  void parameter_nees(const Batch& b, int group, double* nees) const;
  template <class Row>
  void observe(const Batch& b, int t, Row& x, std::vector<std::uint64_t>& inside) const;

  bool antithetic() const { return s_.noise.antithetic; }
  /// How many independent values there are: trials, or antithetic pairs.
  std::uint64_t units(const stats::Tally& tally) const {
    return antithetic() ? tally.pairs.count : tally.moments.count;
  }
  /// Statistics of one component, and the covariance of all; with fewer than two units there is none.
  stats::SampleSummary sample(const stats::Tally& tally, int component) const;
  Eigen::MatrixXd covariance(const stats::Tally& tally) const;
  /// Moments of the pairs' control columns for kControlledPairs[p]; null where the trials are independent.
  const stats::Moments* controlled_pairs(const stats::Tally& tally, std::size_t p) const {
    return antithetic() ? &tally.controlled_pairs[p] : nullptr;
  }
  /// The control columns of the trials that are not in the statistics; null where none failed.
  static stats::LostTrials lost_trials(const stats::Tally& tally, std::size_t p);
  stats::ControlledEstimate sd_estimate(const stats::Tally& tally, int component) const;

  /// The rows of a comparison table; none: this scenario has no such table.
  std::vector<compare::ComparisonRow> rows_of_table(const std::string& table, const stats::Tally& tally) const;
  void make_calibrated();
  /// `angles`: tangents of the errors of the azimuths, a column each; empty if none is wanted.
  void count_calibration(const Eigen::Ref<const Eigen::MatrixXd>& values, const Eigen::MatrixXd& angles,
                         std::vector<std::uint64_t>& counts) const;
  void predict_tails();
  void count_tails(const Eigen::Ref<const Eigen::MatrixXd>& values, std::uint64_t* counts) const;
  /// Where the counts of tails begin in a tally, and behind them those of the laws.
  std::size_t tail_counts() const { return kCounts + calibrated_.size() * stats::kPitSlots; }
  std::size_t law_counts() const { return tail_counts() + tails_.size() * s_.tails.k.size(); }
  /// Tangents of the errors of the azimuths of a group, at the stations of `azimuth_places_`.
  void azimuth_errors(Batch& b, int group) const;

  store::Table ellipse_table(const stats::Tally& tally) const;
  store::Table covariance_table(const stats::Tally& tally) const;
  /// Whether the 6 x 6 covariance of the estimates is that of the first-order prediction; nothing with few trials.
  std::optional<stats::WishartTest> parameter_test(const stats::Tally& tally) const;
  store::Table covariance_tests_table(const stats::Tally& tally) const;
  store::Table correlation_table(const stats::Tally& tally) const;
  store::Table control_variate_table(const stats::Tally& tally) const;
  store::Table pairs_table(const stats::Tally& tally) const;
  store::Table samples_table(const stats::Tally& tally) const;
  store::Table orders_table(const stats::Tally& tally) const;
  store::Table order_coverage_table(const stats::Tally& tally) const;
  store::Table profile_path_table() const;
  store::Table density_table() const;

  static constexpr std::size_t kCounts = kFormulations.size() * 3;  ///< trials in ellipses; calibration follows

  Scenario s_;
  std::vector<compare::Row> rows_;
  compare::VerdictStop stop_;
  sensor::CleanReadings clean_;
  std::vector<double> md_;
  sensor::ReferenceMixing mixing_;
  std::vector<compare::LawDraw> law_draws_;
  std::vector<compare::TailQuantity> tails_;
  analysis::MsaPrediction prediction_;
  std::optional<orders::Predictions> orders_;
  std::vector<std::string> inputs_;
  Eigen::Vector3d true_position_;
  random::Stream stream_;
  std::unique_ptr<estimate::Estimator> estimator_;
  Components at_;
  std::string intervals_;  ///< end of the long name of tables with intervals
  std::array<Eigen::Matrix2d, 3> horizontal_weight_, horizontal_axes_;
  Eigen::Matrix3d hla_from_nev_;
  Eigen::Matrix<double, 6, 6> parameter_weight_, claimed_weight_;
  std::vector<compare::Row> calibrated_rows_;            ///< empty: no calibration
  std::vector<compare::CalibratedQuantity> calibrated_;  ///< of these rows
  bool has_azimuths_ = false;                            ///< among the calibrated quantities
  std::array<std::size_t, 3> azimuth_places_{};
  std::array<double, 3> sin_azimuth_{}, cos_azimuth_{};  ///< magnetic, of the true hole there
};

/// Pairs of the first nine components whose second moments get a control variate.
constexpr std::array<std::array<int, 2>, 12> kControlledPairs{
    {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}, {8, 8}, {6, 7}, {6, 8}, {7, 8}}};

}  // namespace surveymc::studies::msa_position
