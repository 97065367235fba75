/// Study: sensor errors left by multi-station analysis, and the position uncertainty they make, by Monte Carlo and by
/// three analytic propagations. Source: S. Vis, TU Delft 2019 (tables 5 and 8, figures 6 and 7).
///
///   truth -> readings (sensor) -> gains and biases (estimate) -> corrected survey, minimum curvature (survey) -> tally
///
/// held against the first-order prediction: covariance of the estimate (estimate), carried to the position as
///   joint       full 6x6 covariance, the reference field as common-mode consider parameter, plus station noise
///   systematic  the six sensor errors independent of each other, constant in the run   (wrong: drops correlations)
///   random      independent from station to station                                     (wrong: drops everything)
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "base/error.h"
#include "base/units.h"
#include "experiments.h"
#include "msa_prediction.h"
#include "propagate/ellipse.h"
#include "stats/antithetic.h"
#include "stats/control_variate.h"
#include "stats/tests.h"
#include "study/annotations.h"
#include "study/scenario.h"
#include "study/table_writer.h"
#include "survey/corrected_position.h"

namespace surveymc {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

constexpr std::uint32_t kStudyId = 1;  // address of this study's random numbers

constexpr std::array<const char*, 6> kParameters{"gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z"};
constexpr std::array<const char*, 6> kParameterUnits{"1", "1", "1", "nT", "nT", "nT"};
constexpr std::array<const char*, 3> kDirections{"north", "east", "vertical"};
constexpr std::array<const char*, 3> kFormulations{"joint", "systematic", "random"};  // as in MsaPrediction

/// Components of the tallied vector: errors of six parameters and three coordinates, four squared Mahalanobis
/// distances.
enum Component { kParameter = 0, kPosition = 6, kNeesHorizontal = 9, kNeesParameters = 12, kComponents = 13 };

/// Pairs of the first nine components whose second moments get a control variate.
constexpr std::array<std::array<int, 2>, 12> kControlledPairs{
    {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}, {8, 8}, {6, 7}, {6, 8}, {7, 8}}};

struct Scenario {
  std::uint64_t seed = 0, save_samples = 0;
  TrialPlan plan;
  bool with_position = true;    ///< false: parameters only, for throughput
  bool control_variate = true;  ///< tally the first-order prediction of every trial beside it
  ReferenceField field;
  Survey survey;
  MagnetometerErrors errors;
  NoiseModel noise;
  EstimatorOptions estimator;
  VerdictRule verdict;
  Annotations annotations;
};

std::vector<RowName> row_names() {
  std::vector<RowName> rows;
  for (const char* p : kParameters)
    for (const char* what : {"mean_", "sigma3_"}) rows.push_back({"parameters", "", std::string(what) + p});
  rows.push_back({"parameters", "", "nees"});
  for (const char* d : kDirections) {
    rows.push_back({"position", "", std::string("correction_") + d});
    for (const char* f : kFormulations) rows.push_back({"position", f, std::string("sigma3_") + d});
  }
  for (const char* f : kFormulations) rows.push_back({"ellipse", f, "ellipse"});
  return rows;
}

Scenario read_scenario(ConfigReader& c, std::uint64_t seed) {
  Scenario s;
  s.seed = seed;
  s.save_samples = static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, 0));
  if (c.has("outputs")) {
    const std::vector<std::string> outputs = c.texts("outputs");
    for (const std::string& o : outputs)
      c.require(o == "parameters" || o == "position", "outputs", "must be a list of \"parameters\", \"position\"");
    c.require(std::find(outputs.begin(), outputs.end(), "parameters") != outputs.end(), "outputs",
              "must contain \"parameters\", from which all else follows");
    s.with_position = std::find(outputs.begin(), outputs.end(), "position") != outputs.end();
  }
  s.control_variate = c.boolean("control_variate", true);
  s.field = read_field(c);
  s.survey = read_survey(c, s.field, true);
  s.errors = read_magnetometer_errors(c);
  s.noise = read_noise(c);
  s.noise.antithetic = c.boolean("antithetic", false);
  c.require(!s.noise.antithetic || symmetric(s.noise.law), "noise.law",
            "must be symmetric about zero (\"gaussian\", \"uniform\") where antithetic = true");
  s.estimator = read_estimator(c);
  s.verdict = read_verdict_rule(c);
  std::vector<std::string> stoppable;
  for (const RowName& row : row_names())
    if (row.quantity.starts_with("sigma3_") && (s.with_position || row.table == "parameters") &&
        std::find(stoppable.begin(), stoppable.end(), row.quantity) == stoppable.end())  // once, not per formulation
      stoppable.push_back(row.quantity);
  s.plan = read_trial_plan(c, stoppable, s.verdict);
  c.require(!s.noise.antithetic || s.plan.trials % 2 == 0, s.plan.looks.empty() ? "trials" : "stop.max_trials",
            "must be even where antithetic = true: trials come in pairs");
  s.annotations = Annotations::read(c, row_names());
  c.finish();
  return s;
}

class MsaPosition final : public StudyPoint {
 public:
  explicit MsaPosition(Scenario scenario)
      : s_(std::move(scenario)),
        clean_(clean_readings(s_.survey, s_.field, s_.errors)),
        md_(s_.survey.md()),
        prediction_(predict_msa(s_.survey, s_.field, s_.errors, s_.noise, clean_)),
        estimator_(make_estimator(s_.estimator, s_.field)),
        stream_(s_.seed, kStudyId),
        intervals_(at_confidence(s_.verdict.confidence)) {
    for (std::size_t f = 0; f < kFormulations.size(); ++f) {
      const Matrix2d horizontal = prediction_.position_covariance[f].topLeftCorner<2, 2>();
      // An ellipse without area (all errors in one direction) has no Mahalanobis distance and covers nothing.
      horizontal_weight_[f] =
          ellipse(horizontal).semi_minor > 0 ? Matrix2d(horizontal.inverse()) : Matrix2d::Constant(std::nan(""));
    }
    parameter_weight_ = prediction_.parameter_covariance.inverse();
  }

  std::uint64_t trials() const override { return s_.plan.trials; }
  std::vector<std::uint64_t> looks() const override { return s_.plan.looks; }

  std::uint64_t trials_needed(const Tally& tally) const override {
    if (units(tally) < 2) return s_.plan.trials;  // nothing to predict from
    double needed = 0;
    for (const std::string& quantity : s_.plan.quantities) {
      const ControlledEstimate e = sd_estimate(tally, component_of(quantity));
      const bool controlled = s_.control_variate && tally.failed == 0;
      const Interval ci = controlled ? e.controlled_interval : e.plain_interval;
      const double width = (ci.hi - ci.lo) / 2 / (controlled ? e.controlled : e.plain) / s_.plan.relative_ci;
      needed = std::max(needed, std::isfinite(width) ? static_cast<double>(tally.trials) * width * width : 1e18);
    }
    return static_cast<std::uint64_t>(std::ceil(needed));
  }

  Tally run_block(TrialBlock block) const override {
    // A batch is what fits the first-level caches, and below the size that the allocator returns to the system each
    // time; it changes no bit of the result.
    const int bytes_per_trial = s_.survey.size() * 3 * static_cast<int>(sizeof(double));
    const int batch = std::clamp(65536 / bytes_per_trial / kGroup * kGroup, kGroup, kBlockTrials);
    Batch b(std::min(batch, block.count), s_);
    Tally tally;
    tally.counts.assign(kFormulations.size() * 3, 0);
    // One quantity a column; a few spare rows, or all columns would fall into the same sets of the cache.
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(block.count + 8, kComponents);
    Eigen::MatrixXd controls = Eigen::MatrixXd::Zero(s_.control_variate ? block.count + 8 : 0, NoiseWeights::kSums);
    Eigen::Index kept = 0;
    for (int begin = 0; begin < block.count; begin += batch) {
      const int count = std::min(batch, block.count - begin);
      if (count != b.readings.trials) b = Batch(count, s_);
      const std::uint64_t first = block.first + static_cast<std::uint64_t>(begin);
      simulate(first, b);
      for (int t = 0; t < count; ++t) {
        const std::uint64_t trial = first + static_cast<std::uint64_t>(t);
        ++tally.trials;
        const auto converged = [&b](int i) { return b.estimates.converged.value(i, 0) != 0; };
        if (!converged(t)) {
          ++tally.failed;
          if (tally.failed_trials.size() < Tally::kMaxListed) tally.failed_trials.push_back(trial);
          continue;
        }
        if (antithetic() && !converged(t ^ 1)) {
          ++tally.left_out;
        } else {
          auto x = values.row(kept);
          observe(b, t, x, tally.counts);
          if (s_.control_variate)
            for (int q = 0; q < NoiseWeights::kSums; ++q)
              controls(kept, q) = b.sums.value(t, q) - prediction_.linear.mean[q];
          ++kept;
        }
        if (trial < s_.save_samples) {
          tally.samples.push_back(static_cast<double>(trial));
          for (int i = 0; i < 6; ++i) tally.samples.push_back(b.estimates.parameters.value(t, i));
          for (int i = 0; i < 3; ++i) tally.samples.push_back(b.position.value(t, i));
        }
      }
    }
    tally.moments = Moments::of(values.topRows(kept));
    if (antithetic()) tally.pairs = Moments::of(pair_columns(values.topRows(kept)));
    for (std::size_t p = 0; p < kControlledPairs.size() && s_.control_variate; ++p) {
      const auto [i, j] = kControlledPairs[p];
      const Eigen::MatrixXd columns = control_columns(values.col(i).head(kept), values.col(j).head(kept),
                                                      controls.col(i).head(kept), controls.col(j).head(kept));
      tally.controlled.push_back(Moments::of(columns));
      if (antithetic()) tally.controlled_pairs.push_back(Moments::of(pair_means(columns)));
    }
    return tally;
  }

  PointResult finish(const Tally& tally) const override {
    PointResult r;
    r.tables = {parameters_table(tally)};
    if (s_.with_position)
      for (const auto table :
           {&MsaPosition::position_table, &MsaPosition::ellipse_table, &MsaPosition::covariance_table})
        r.tables.push_back((this->*table)(tally));
    r.tables.push_back(correlation_table(tally));
    if (s_.control_variate) r.tables.push_back(control_variate_table(tally));
    r.tables.push_back(failures_table(tally));
    if (antithetic()) r.tables.push_back(pairs_table(tally));
    if (s_.save_samples > 0) r.samples = {samples_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const std::uint64_t first = trial / kGroup * kGroup;
    const int lane = static_cast<int>(trial % kGroup);
    Batch b(kGroup, s_);
    simulate(first, b);
    std::string text = fmt::format("trial {}\n", trial);
    text += fmt::format("  reference field  Bh {:.17g} nT, Bv {:.17g} nT (station 0)\n",
                        b.readings.reference.value(lane, 0), b.readings.reference.value(lane, 1));
    for (int i = 0; i < 6; ++i)
      text += fmt::format("  {:<16} {:.17g} {}\n", kParameters[static_cast<std::size_t>(i)],
                          b.estimates.parameters.value(lane, i), kParameterUnits[static_cast<std::size_t>(i)]);
    text += fmt::format("  cost             {:.17g} nT2 after {} evaluations, {}\n", b.estimates.cost.value(lane, 0),
                        b.estimates.iterations.value(lane, 0),
                        b.estimates.converged.value(lane, 0) != 0 ? "converged" : "NOT converged");
    for (int i = 0; i < 3 && s_.with_position; ++i)
      text += fmt::format("  {:<16} {:.17g} m\n", kDirections[static_cast<std::size_t>(i)], b.position.value(lane, i));
    return text;
  }

 private:
  /// Everything that a batch of trials is made of; reused from batch to batch.
  struct Batch {
    Batch(int trials, const Scenario& s)
        : readings(make_reading_block(trials, s.survey.size(), s.noise)),
          estimates(trials),
          position(groups_for(trials), 3),
          sums(groups_for(trials), NoiseWeights::kSums) {}
    ReadingBlock readings;
    EstimateBlock estimates;
    LaneArray position, sums;
  };

  void simulate(std::uint64_t first, Batch& b) const {
    simulate_readings(clean_, s_.field, s_.noise, stream_, first, b.readings,
                      s_.control_variate ? &prediction_.weights : nullptr, &b.sums);
    estimator_->solve(b.readings, b.estimates);
    if (s_.with_position)
      corrected_final_positions(b.readings, b.estimates.parameters, md_, s_.field.declination, b.position);
  }

  /// Index of "sigma3_<name>" among the first nine components.
  static int component_of(const std::string& quantity) {
    for (std::size_t i = 0; i < 6; ++i)
      if (quantity == std::string("sigma3_") + kParameters[i]) return kParameter + static_cast<int>(i);
    for (std::size_t i = 0; i < 3; ++i)
      if (quantity == std::string("sigma3_") + kDirections[i]) return kPosition + static_cast<int>(i);
    throw std::logic_error("no component " + quantity);
  }

  bool antithetic() const { return s_.noise.antithetic; }

  /// How many independent values there are: trials, or antithetic pairs.
  std::uint64_t units(const Tally& tally) const { return antithetic() ? tally.pairs.count : tally.moments.count; }
  /// Of one component, and the covariance of all; with fewer than two units there is none.
  SampleSummary sample(const Tally& tally, int component) const {
    if (units(tally) < 2) return {};
    return antithetic() ? summarise_pairs(tally.moments, tally.pairs, component) : summarise(tally.moments, component);
  }
  Eigen::MatrixXd covariance(const Tally& tally) const {
    return antithetic() ? paired_covariance(tally.moments, tally.pairs) : tally.moments.covariance();
  }
  /// Moments of the pairs' control columns for kControlledPairs[p]; null where the trials are independent.
  const Moments* controlled_pairs(const Tally& tally, std::size_t p) const {
    return antithetic() ? &tally.controlled_pairs[p] : nullptr;
  }

  ControlledEstimate sd_estimate(const Tally& tally, int component) const {
    const auto p = static_cast<std::size_t>(component);  // kControlledPairs begins with the nine variances
    if (s_.control_variate)
      return controlled_sd(tally.controlled[p], prediction_.linear.covariance(component, component),
                           s_.verdict.confidence, controlled_pairs(tally, p));
    ControlledEstimate e;
    const SampleSummary s = sample(tally, component);
    e.plain = std::sqrt(s.variance);
    e.plain_interval = sd_interval(s, s_.verdict.confidence);
    return e;
  }

  /// The tallied vector of trial `t` of a batch, and the ellipses it lies in.
  template <class Row>
  void observe(const Batch& b, int t, Row& x, std::vector<std::uint64_t>& inside) const {
    std::array<double, 6> error;
    for (int i = 0; i < 6; ++i)
      error[static_cast<std::size_t>(i)] = x[kParameter + i] =
          b.estimates.parameters.value(t, i) - prediction_.parameters[i];
    double nees = 0;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        nees += error[static_cast<std::size_t>(i)] * parameter_weight_(i, j) * error[static_cast<std::size_t>(j)];
    x[kNeesParameters] = nees;
    if (!s_.with_position) return;
    for (int i = 0; i < 3; ++i) x[kPosition + i] = b.position.value(t, i) - prediction_.position[i];
    const double n = x[kPosition], e = x[kPosition + 1];
    for (std::size_t f = 0; f < kFormulations.size(); ++f) {
      const Matrix2d& w = horizontal_weight_[f];
      const double squared = w(0, 0) * n * n + 2 * w(0, 1) * n * e + w(1, 1) * e * e;
      x[kNeesHorizontal + static_cast<int>(f)] = squared;
      for (std::size_t k = 1; k <= 3; ++k)
        if (squared <= static_cast<double>(k * k)) ++inside[3 * f + k - 1];
    }
  }

  Table parameters_table(const Tally& tally) const {
    std::vector<ComparisonRow> rows;
    for (int i = 0; i < 6; ++i) {
      const auto a = static_cast<std::size_t>(i);
      rows.push_back(compare_mean(std::string("mean_") + kParameters[a], kParameterUnits[a],
                                  sample(tally, kParameter + i), prediction_.parameters[i], prediction_.parameters[i],
                                  s_.verdict, tally.trials));
    }
    for (int i = 0; i < 6; ++i) {
      const auto a = static_cast<std::size_t>(i);
      rows.push_back(compare_sd(std::string("sigma3_") + kParameters[a], kParameterUnits[a], 3,
                                sample(tally, kParameter + i), std::sqrt(prediction_.parameter_covariance(i, i)),
                                s_.verdict, tally.trials));
    }
    rows.push_back(nees_row("nees", tally, kNeesParameters, 6));
    if (units(tally) > 20) {
      const WishartTest test =
          wishart_test(covariance(tally).topLeftCorner<6, 6>(), prediction_.parameter_covariance, units(tally));
      rows.back().note += fmt::format("; Wishart test of the 6x6 covariance: p = {:.2g}", test.p_value);
    }
    s_.annotations.apply("parameters", rows);
    return comparison_table("parameters",
                            "MSA estimates of gains and biases against the first-order prediction" + intervals_, rows,
                            tally.trials, tally.failed);
  }

  /// Mean squared Mahalanobis distance; its prediction is the dimension.
  ComparisonRow nees_row(const std::string& name, const Tally& tally, int component, double dimension) const {
    ComparisonRow row;
    row.quantity = name;
    row.unit = "1";
    row.analytic = dimension;
    if (units(tally) < 2) return row;
    const SampleSummary s = sample(tally, component);
    row.monte_carlo = s.mean;
    row.interval = mean_interval(s, s_.verdict.confidence);
    row.ratio = dimension / row.monte_carlo;
    row.ratio_interval = {dimension / row.interval.hi, dimension / row.interval.lo};
    // The distance goes with the square of the sd, so the same margin in sd is twice as wide here.
    row.verdict = judge(row.ratio_interval, 2 * s_.verdict.margin, tally.trials).word;
    const Interval band = nees_band(dimension, units(tally), s_.verdict.confidence);
    row.note = fmt::format("consistent estimates give {:.3f} .. {:.3f}", band.lo, band.hi);
    return row;
  }

  Table position_table(const Tally& tally) const {
    std::vector<ComparisonRow> rows;
    for (int i = 0; i < 3; ++i) {
      const double correction = prediction_.position[i] - prediction_.uncorrected[i];
      rows.push_back(compare_mean(std::string("correction_") + kDirections[static_cast<std::size_t>(i)], "m",
                                  sample(tally, kPosition + i), correction, correction, s_.verdict, tally.trials));
    }
    for (std::size_t f = 0; f < kFormulations.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        rows.push_back(compare_sd(std::string("sigma3_") + kDirections[static_cast<std::size_t>(i)], "m", 3,
                                  sample(tally, kPosition + i), std::sqrt(prediction_.position_covariance[f](i, i)),
                                  s_.verdict, tally.trials));
        rows.back().formulation = kFormulations[f];
      }
    s_.annotations.apply("position", rows);
    return comparison_table("position",
                            "final position of the corrected survey against three propagations" + intervals_, rows,
                            tally.trials, tally.failed);
  }

  /// Horizontal error ellipses, Monte Carlo first. Ratios are taken along the *predicted* axes: the sorted axes of a
  /// sample ellipse are biased.
  Table ellipse_table(const Tally& tally) const;
  Table covariance_table(const Tally& tally) const;
  Table correlation_table(const Tally& tally) const;
  Table control_variate_table(const Tally& tally) const;
  Table failures_table(const Tally& tally) const;
  Table pairs_table(const Tally& tally) const;
  Table samples_table(const Tally& tally) const;

  Scenario s_;
  CleanReadings clean_;
  std::vector<double> md_;
  MsaPrediction prediction_;
  std::unique_ptr<Estimator> estimator_;
  Stream stream_;
  std::string intervals_;  ///< end of the long name of tables with intervals
  std::array<Matrix2d, 3> horizontal_weight_;
  Eigen::Matrix<double, 6, 6> parameter_weight_;
};

Table MsaPosition::ellipse_table(const Tally& tally) const {
  Table t{"ellipse",
          "horizontal one-sigma ellipses of the final position, and how Monte Carlo fills them" + intervals_};
  t.columns = {word_column("formulation", "monte_carlo, or which analytic prediction"),
               number_column("center_north_m", "m", "centre of the ellipse"),
               number_column("center_east_m", "m", "centre of the ellipse"),
               number_column("semi_major_m", "m", "one standard deviation along the major axis"),
               number_column("semi_minor_m", "m", "one standard deviation along the minor axis"),
               number_column("major_azimuth_deg", "deg", "direction of the major axis, clockwise from north")};
  add_with_interval(t, "mc_sd_major_m", "m", "Monte-Carlo standard deviation along this row's major axis");
  add_with_interval(t, "mc_sd_minor_m", "m", "Monte-Carlo standard deviation along this row's minor axis");
  add_with_interval(t, "ratio_major", "1", "analytic / Monte Carlo along the major axis");
  add_with_interval(t, "ratio_minor", "1", "analytic / Monte Carlo along the minor axis");
  for (const char* k : {"1", "2", "3"})
    add_with_interval(
        t, std::string("coverage_") + k + "sigma", "1",
        fmt::format("share of trials inside the {}-sigma ellipse; {:.4f} if normal", k, ellipse_coverage(k[0] - '0')));
  add_with_interval(t, "nees", "1", "mean squared Mahalanobis distance from the truth; 2 if consistent");
  t.columns.push_back(number_column("wishart_p", "1", "p-value of the likelihood-ratio test of the 2x2 covariance"));
  t.columns.push_back(word_column("verdict", "both axes agree, one differs, or undecided"));
  t.columns.push_back(word_column("expected", "the verdict this row should have"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));

  const double nan = std::nan("");
  const Moments& m = tally.moments;
  const std::uint64_t n = units(tally);
  const bool usable = n > 2;
  const double confidence = s_.verdict.confidence;
  Matrix2d found = Matrix2d::Constant(nan);
  if (usable) found = covariance(tally).block<2, 2>(kPosition, kPosition);
  TableWriter w(std::move(t));
  const auto interval = [&](double x, const Interval& i) { w << x << i.lo << i.hi; };
  const Interval none{nan, nan};
  const auto trials = static_cast<std::int64_t>(tally.trials), failed = static_cast<std::int64_t>(tally.failed);

  if (usable) {
    const Ellipse e = ellipse(found);
    w << std::string("monte_carlo") << prediction_.position[0] + m.mean[kPosition]
      << prediction_.position[1] + m.mean[kPosition + 1] << e.semi_major << e.semi_minor << e.azimuth / kDegree;
    for (int i = 0; i < 8; ++i) interval(nan, none);
    w << nan << std::string() << std::string() << trials << failed;
  }
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const Matrix2d predicted = prediction_.position_covariance[f].topLeftCorner<2, 2>();
    const Ellipse e = ellipse(predicted);
    w << std::string(kFormulations[f]) << prediction_.position[0] << prediction_.position[1] << e.semi_major
      << e.semi_minor << e.azimuth / kDegree;
    std::array<double, 2> sd{nan, nan};
    std::array<Interval, 2> sd_ci{none, none}, ratio_ci{none, none};
    std::array<std::string, 2> word;
    const std::array<double, 2> predicted_sd{e.semi_major, e.semi_minor};
    for (std::size_t a = 0; a < 2 && usable; ++a) {
      const Eigen::Vector2d axis = e.axes.col(static_cast<int>(a));
      const double variance = axis.dot(found * axis);
      // The kurtosis along an oblique axis is not tallied: the larger one of north and east is on the safe side.
      const double kurtosis =
          std::max(sample(tally, kPosition).unit_kurtosis, sample(tally, kPosition + 1).unit_kurtosis);
      sd[a] = std::sqrt(variance);
      sd_ci[a] = sd_interval(variance, n, kurtosis, confidence);
      ratio_ci[a] = {predicted_sd[a] / sd_ci[a].hi, predicted_sd[a] / sd_ci[a].lo};
      word[a] = judge(ratio_ci[a], s_.verdict.margin, tally.trials).word;
    }
    for (std::size_t a = 0; a < 2; ++a) interval(sd[a], sd_ci[a]);
    for (std::size_t a = 0; a < 2; ++a) interval(predicted_sd[a] / sd[a], ratio_ci[a]);
    const bool has_area = usable && e.semi_minor > 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t inside = tally.counts.empty() ? 0 : tally.counts[3 * f + k];
      if (has_area)
        interval(
            static_cast<double>(inside) / static_cast<double>(m.count),
            antithetic() ? paired_binomial_interval(inside, n, confidence) : binomial_interval(inside, n, confidence));
      else
        interval(nan, none);
    }
    const int nees = kNeesHorizontal + static_cast<int>(f);
    if (has_area)
      interval(m.mean[nees], mean_interval(sample(tally, nees), confidence));
    else
      interval(nan, none);
    w << (has_area ? wishart_test(found, predicted, n).p_value : nan);
    const std::string verdict = word[0] == "differs" || word[1] == "differs" ? "differs"
                                : word[0] == word[1]                         ? word[0]
                                                                             : "undecided";
    w << verdict << s_.annotations.expected("ellipse", kFormulations[f], "ellipse") << trials << failed;
  }
  return w.take();
}

Table MsaPosition::covariance_table(const Tally& tally) const {
  Table t{"position_covariance", "covariance of the final position, true north"};
  t.columns = {word_column("formulation", "monte_carlo, or which analytic prediction")};
  for (const char* name : {"nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"})
    t.columns.push_back(number_column(name, "m2", "element of the covariance"));
  TableWriter w(std::move(t));
  const auto row = [&](const std::string& name, const Matrix3d& c) {
    w << name << c(0, 0) << c(1, 1) << c(2, 2) << c(0, 1) << c(0, 2) << c(1, 2);
  };
  if (units(tally) > 1) row("monte_carlo", covariance(tally).block<3, 3>(kPosition, kPosition));
  for (std::size_t f = 0; f < kFormulations.size(); ++f) row(kFormulations[f], prediction_.position_covariance[f]);
  return w.take();
}

Table MsaPosition::correlation_table(const Tally& tally) const {
  Table t{"parameter_correlation",
          "correlation of the estimates; near -1 or 1: the two can hardly be told apart" + intervals_};
  t.columns = {word_column("parameter_a", "first parameter"), word_column("parameter_b", "second parameter")};
  add_with_interval(t, "monte_carlo", "1", "correlation of the Monte-Carlo estimates");
  t.columns.push_back(number_column("analytic", "1", "correlation by the first-order covariance"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));
  const auto correlation = [](const auto& c, int i, int j) { return c(i, j) / std::sqrt(c(i, i) * c(j, j)); };
  TableWriter w(std::move(t));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) {
      double r = std::nan("");
      Interval ci{r, r};
      if (units(tally) > 4) {
        r = correlation(tally.moments.squares, i, j);
        // Fisher's z
        const double half =
            normal_quantile(1 - (1 - s_.verdict.confidence) / 2) / std::sqrt(static_cast<double>(units(tally)) - 3);
        ci = {std::tanh(std::atanh(r) - half), std::tanh(std::atanh(r) + half)};
      }
      w << std::string(kParameters[static_cast<std::size_t>(j)])
        << std::string(kParameters[static_cast<std::size_t>(i)]) << r << ci.lo << ci.hi
        << correlation(prediction_.parameter_covariance, i, j) << static_cast<std::int64_t>(tally.trials)
        << static_cast<std::int64_t>(tally.failed);
    }
  return w.take();
}

/// Plain and controlled estimates side by side. The controlled one removes what the first-order prediction says of the
/// very noise of each trial: its interval is narrower, and its difference from the analytic value is nonlinearity.
Table MsaPosition::control_variate_table(const Tally& tally) const {
  Table t{"control_variate",
          "estimates without and with the first-order prediction of each trial as control variate" + intervals_};
  t.columns = {word_column("quantity", "what is estimated"), word_column("unit", "unit of the values in this row")};
  add_with_interval(t, "plain", "1", "Monte-Carlo estimate");
  add_with_interval(t, "controlled", "1", "Monte-Carlo estimate with control variate");
  t.columns.push_back(number_column("analytic", "1", "first-order prediction, exact for this noise"));
  add_with_interval(t, "ratio", "1", "analytic / controlled; absent for means and covariances");
  t.columns.push_back(
      number_column("variance_reduction", "1",
                    "how many times more independent trials the plain estimate needs for the same interval"));
  t.columns.push_back(word_column("verdict", "agrees, differs or undecided, by the controlled estimate"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));
  TableWriter w(std::move(t));
  // Without the trials that failed, the mean of the control is no longer known.
  if (tally.failed > 0 || units(tally) < 20) return w.take();

  const double nan = std::nan("");
  const auto put = [&](const std::string& quantity, const std::string& unit, const ControlledEstimate& e, double offset,
                       double factor, double analytic, bool judged) {
    const auto interval = [&](double x, const Interval& i) {
      w << offset + factor * x << offset + factor * i.lo << offset + factor * i.hi;
    };
    w << quantity << unit;
    interval(e.plain, e.plain_interval);
    interval(e.controlled, e.controlled_interval);
    w << offset + factor * analytic;
    const Interval ratio{analytic / e.controlled_interval.hi, analytic / e.controlled_interval.lo};
    if (judged)
      w << analytic / e.controlled << ratio.lo << ratio.hi;
    else
      w << nan << nan << nan;
    w << e.variance_reduction << (judged ? judge(ratio, s_.verdict.margin, tally.trials).word : std::string())
      << static_cast<std::int64_t>(tally.trials) << static_cast<std::int64_t>(tally.failed);
  };
  const double confidence = s_.verdict.confidence;
  const auto& linear = prediction_.linear.covariance;
  const auto both = [&](int i, const std::string& name, const std::string& mean_name, const std::string& unit,
                        double offset) {
    const auto p = static_cast<std::size_t>(i);
    const Moments *m = &tally.controlled[p], *pairs = controlled_pairs(tally, p);
    put(mean_name, unit, controlled_mean(*m, linear(i, i), confidence, pairs), offset, 1, 0, false);
    put("sigma3_" + name, unit, controlled_sd(*m, linear(i, i), confidence, pairs), 0, 3, std::sqrt(linear(i, i)),
        true);
  };
  for (std::size_t i = 0; i < 6; ++i)
    both(static_cast<int>(i), kParameters[i], std::string("mean_") + kParameters[i], kParameterUnits[i],
         prediction_.parameters[static_cast<int>(i)]);
  if (s_.with_position) {
    for (std::size_t i = 0; i < 3; ++i)
      both(kPosition + static_cast<int>(i), kDirections[i], std::string("correction_") + kDirections[i], "m",
           prediction_.position[static_cast<int>(i)] - prediction_.uncorrected[static_cast<int>(i)]);
    for (std::size_t p = 9; p < kControlledPairs.size(); ++p) {
      const auto [i, j] = kControlledPairs[p];
      put(fmt::format("covariance_{}_{}", kDirections[static_cast<std::size_t>(i - kPosition)],
                      kDirections[static_cast<std::size_t>(j - kPosition)]),
          "m2", controlled_covariance(tally.controlled[p], linear(i, j), confidence, controlled_pairs(tally, p)), 0, 1,
          linear(i, j), false);
    }
  }
  return w.take();
}

Table MsaPosition::failures_table(const Tally& tally) const {
  Table t{"failed_trials", "trials without a converged estimate; replay one with `surveymc run CONFIG --trial K`"};
  std::vector<std::int64_t> numbers(tally.failed_trials.begin(), tally.failed_trials.end());
  t.columns = {{"trial", "1", "number of the trial, from 0", std::move(numbers)}};
  return t;
}

Table MsaPosition::pairs_table(const Tally& tally) const {
  Table t{"antithetic_pairs", "trials 2j and 2j + 1 with opposite draws; a pair is the unit of all intervals"};
  const auto column = [&](const char* name, const char* what, std::uint64_t count) {
    t.columns.push_back({name, "1", what, std::vector<std::int64_t>{static_cast<std::int64_t>(count)}});
  };
  column("trials", "trials run", tally.trials);
  column("failed", "trials without a converged estimate, not in the statistics", tally.failed);
  column("left_out", "converged trials not in the statistics: the other of their pair failed", tally.left_out);
  column("pairs", "pairs in the statistics", tally.pairs.count);
  return t;
}

Table MsaPosition::samples_table(const Tally& tally) const {
  Table t{"realisations", "estimates and final positions of the first converged trials"};
  t.columns = {number_column("trial", "1", "number of the trial, from 0")};
  for (std::size_t i = 0; i < 6; ++i)
    t.columns.push_back(number_column(i < 3 ? kParameters[i] : fmt::format("{}_nT", kParameters[i]), kParameterUnits[i],
                                      "MSA estimate"));
  const std::size_t with_position = t.columns.size() + 3;
  if (s_.with_position)
    for (const char* d : kDirections)
      t.columns.push_back(number_column(fmt::format("{}_m", d), "m", "final position relative to the first station"));
  const std::size_t columns = t.columns.size();
  TableWriter w(std::move(t));
  for (std::size_t i = 0; i < tally.samples.size(); ++i)
    if (i % with_position < columns) w << tally.samples[i];
  return w.take();
}

}  // namespace

Experiment msa_position_experiment() {
  return {"msa_position", "Multi-station analysis: errors left in parameters and final position",
          "S. Vis, TU Delft 2019, tables 5 and 8, figures 6 and 7",
          [](ConfigReader& config, std::uint64_t seed) -> std::unique_ptr<StudyPoint> {
            Scenario scenario = read_scenario(config, seed);
            try {
              return std::make_unique<MsaPosition>(std::move(scenario));
            } catch (const InputError& e) {  // the survey's geometry: say which survey, in which case of a sweep
              config.fail("survey.file", e.what());
            }
          }};
}

}  // namespace surveymc
