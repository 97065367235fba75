/// Study: position uncertainty of any survey from twelve constant sensor errors, by nonlinear Monte Carlo and by the
/// first-order covariance model. Where does linear theory fail? (Sizes: ISCWSA MWD error model.)
///
///   errors and toolfaces -> readings -> inclination, azimuth -> minimum curvature (sensor) -> tally at several depths
///
/// compared with
///   toolface_dependent  the errors through their derivatives at each station's toolface (mean over drawn toolfaces)
///   ti_systematic       ISCWSA's toolface-independent terms, all of them constant: right for a slid hole on average
///   ti_random           those that turn with the toolface random from station to station: right for a rotated hole
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/sensor_prediction.h"
#include "base/units.h"
#include "compare/annotations.h"
#include "compare/position_comparison.h"
#include "compare/trial_plan.h"
#include "compare/verdict_stop.h"
#include "config/meanings.h"
#include "random/study_stream.h"
#include "scenario/drilling.h"
#include "scenario/scenario.h"
#include "sensor/sensor_runs.h"
#include "stats/layout.h"
#include "stats/tests.h"
#include "study/experiment.h"
#include "survey/survey.h"

namespace surveymc::studies::sensor_monte_carlo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostDepths = 50;

constexpr std::array<const char*, 3> kDirections{"north", "east", "vertical"};
constexpr auto& kFormulations = analysis::kSensorFormulations;

/// Tallied at every depth: position error, the same along the axes of each formulation's ellipsoid and horizontal
/// ellipse, squared Mahalanobis distances of the horizontal and of all three coordinates in each formulation.
struct Components : stats::Layout {
  stats::Slots position = slots(3), axes = slots(3, 3), nees_horizontal = slots(3), nees = slots(3),
               horizontal_axes = slots(3, 2);
};
constexpr Components kAt;
int at(const stats::Slots& slots, int i, int j = 0) {
  return static_cast<int>(slots(static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
}

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;
  std::uint64_t save_samples = 0;
  survey::ReferenceField field;
  survey::Survey survey;
  survey::ToolfacePlan plan;
  survey::SensorTermArray sd{};
  std::vector<int> reported;  ///< stations, ascending
  bool first_is_tie_on = false;
  compare::VerdictRule verdict;
  compare::Annotations annotations;
};

/// All rows at a depth; without `truth` and predictions they have no numbers. A NEES has no confidence sequence.
std::vector<compare::Row> rows_of(const Vector3d& truth = Vector3d::Constant(kNaN),
                                  const analysis::PositionPredictions* predictions = nullptr) {
  using enum compare::Statistic;
  std::vector<compare::Row> rows;
  for (int i = 0; i < 3; ++i)
    rows.push_back({.table = "axes",
                    .quantity = std::string("mean_") + kDirections[i],
                    .unit = "m",
                    .statistic = mean,
                    .component = at(kAt.position, i),
                    .offset = truth[i],
                    .prediction = truth[i]});
  for (int f = 0; f < 3; ++f) {
    const std::string name = kFormulations[f];
    const Vector3d predicted = predictions ? (*predictions)[f].sd : Vector3d::Constant(kNaN);
    for (int a = 0; a < 3; ++a)
      rows.push_back({.table = "axes",
                      .formulation = name,
                      .quantity = fmt::format("sd_axis_{}", a + 1),
                      .unit = "m",
                      .statistic = sd,
                      .component = at(kAt.axes, f, a),
                      .prediction = predicted[a]});
    rows.push_back({.table = "axes",
                    .formulation = name,
                    .quantity = "nees",
                    .statistic = squared_distance,
                    .component = at(kAt.nees, f),
                    .prediction = 3,
                    .predicted = false,
                    .available = predicted[2] != 0});
    rows.push_back({.table = "ellipse", .formulation = name, .quantity = "ellipse", .predicted = false});
  }
  return rows;
}

/// `report_md_m` or `report_md_ft`: measured depths of stations; the last station if absent.
std::vector<int> read_reported(config::ConfigReader& c, const survey::Survey& survey) {
  const bool feet = c.has("report_md_ft");
  const std::string key = feet ? "report_md_ft" : "report_md_m";
  if (!c.has(key)) return {survey.size() - 1};
  c.require(!feet || !c.has("report_md_m"), key, "not together with report_md_m");
  const std::vector<double> depths = c.numbers(key, {}, config::meaning::kReportDepths);
  c.require(depths.size() <= kMostDepths, key, fmt::format("must have 1 to {} depths", kMostDepths));
  std::vector<int> reported;
  for (const double depth : depths) {
    const int station = static_cast<int>(survey::station_at(survey, depth * (feet ? kFoot : 1)).value_or(0));
    c.require(station > 0, key,
              fmt::format("{} is not the measured depth of a station after the first", config::format_number(depth)));
    c.require(reported.empty() || station > reported.back(), key, "must increase");
    reported.push_back(station);
  }
  return reported;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.save_samples =
      static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, config::meaning::kSaveSamples, 0));
  s.field = scenario::read_field(c);
  std::vector<std::string> modes = scenario::kDrillingModes;
  modes.push_back("survey");
  const bool surveyed = c.choice("drilling.mode", modes, config::kMeaningElsewhere) == "survey";
  s.survey = scenario::read_survey(c, s.field, surveyed);
  // read_survey() has asked for it where the file's toolfaces are used.
  const double zero =
      c.choice("survey.toolface_zero", {"x", "y"}, config::meaning::kToolfaceZero, "y") == "x" ? kPi / 2 : 0.0;
  s.plan = scenario::read_drilling(c, s.survey.md(), zero, random::stream_of(seed), modes);
  if (surveyed) s.plan = survey::surveyed_toolfaces(s.survey);
  s.sd = scenario::read_sensor_errors(c);
  c.require(std::any_of(s.sd.begin(), s.sd.end(), [](double x) { return x > 0; }), "sensor_errors",
            "must have one size greater than 0");
  s.reported = read_reported(c, s.survey);
  s.first_is_tie_on =
      c.choice("first_station", {"measured", "tie_on"},
               "'measured': by the tool, as the other stations are; 'tie_on': the first station is without error",
               "measured") == "tie_on";
  s.verdict = compare::read_verdict_rule(c);
  s.trial_plan = compare::read_verdict_plan(c, rows_of(), s.verdict, {20});
  s.annotations = compare::Annotations::read(c, rows_of());
  c.finish();
  return s;
}

std::vector<Vector3d> reported_positions(const Scenario& s) {
  const std::vector<Vector3d> positions = survey::minimum_curvature_positions(s.survey);
  std::vector<Vector3d> reported;
  for (const int k : s.reported) reported.push_back(positions[static_cast<std::size_t>(k)]);
  return reported;
}

class SensorMonteCarlo final : public study::StudyPoint {
 public:
  explicit SensorMonteCarlo(const Scenario& scenario)
      : s_(scenario),
        setup_(sensor::sensor_run_setup(s_.survey, s_.field, s_.sd, s_.plan, survey::PositionMethod::minimum_curvature,
                                        s_.reported)),
        stream_(random::stream_of(s_.seed)),
        truth_(reported_positions(s_)),
        predictions_(
            analysis::predict_sensor_runs(s_.survey, s_.field, s_.sd, s_.plan, s_.reported, s_.first_is_tie_on)),
        stop_(s_.trial_plan, s_.verdict,
              [this](const stats::Tally& t) {
                compare::RowsOfTables all;
                for (std::size_t d = 0; d < truth_.size(); ++d) all.push_back({"axes", axes_rows(t, d), place(d)});
                return all;
              },
              {truth_.size(), truth_.size()}) {
    setup_.first_is_tie_on = s_.first_is_tie_on;
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    const std::size_t depths = truth_.size();
    stats::Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    tally.counts.assign(9 * depths, 0);
    std::vector<Eigen::MatrixXd> values(depths, Eigen::MatrixXd(block.count, static_cast<Eigen::Index>(kAt.size())));
    Eigen::Index kept = 0;
    sensor::for_each_batch(
        setup_, stream_, block.first, block.count, [&](std::uint64_t first, const sensor::SensorRuns& runs) {
          for (int t = 0; t < runs.trials; ++t) {
            const std::uint64_t trial = first + static_cast<std::uint64_t>(t);
            if (!has_positions(runs, t)) {
              tally.add_failed(trial);
              continue;
            }
            for (std::size_t d = 0; d < depths; ++d) {
              auto x = values[d].row(kept);
              observe(runs, t, d, x, tally.counts.data() + 9 * d);
              if (trial < s_.save_samples)
                tally.samples.insert(tally.samples.end(), {md(d), static_cast<double>(trial), x[0], x[1], x[2]});
            }
            ++kept;
          }
        });
    for (const Eigen::MatrixXd& v : values) tally.groups.push_back(stats::Moments::of(v.topRows(kept)));
    stop_.keep(block, tally);
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    r.tables = {axes_table(tally), ellipse_table(tally), covariance_table(tally)};
    if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
    if (s_.save_samples > 0) r.samples = {compare::position_samples_table(tally.samples)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const sensor::SensorRuns runs = sensor::runs_around(setup_, stream_, trial);
    const int lane = static_cast<int>(trial % simd::kGroup);
    constexpr std::array<const char*, 4> kUnits{"m/s2", "1", "nT", "1"};
    std::string text = fmt::format("trial {}\n", trial);
    for (std::size_t i = 0; i < survey::kSensorTerms; ++i)
      text += fmt::format("  {}  {:.17g} {}\n", survey::kSensorTermCodes[i],
                          runs.errors.value(lane, static_cast<int>(i)), kUnits[i / 3]);
    for (std::size_t d = 0; d < truth_.size(); ++d) {
      text += fmt::format("  at {:.10g} m:", md(d));
      for (int i = 0; i < 3; ++i)
        text += fmt::format(" {} {:.17g} m", kDirections[static_cast<std::size_t>(i)],
                            runs.positions.value(lane, 3 * static_cast<int>(d) + i));
      text += "\n";
    }
    return text;
  }

 private:
  double md(std::size_t depth) const { return s_.survey.stations[static_cast<std::size_t>(s_.reported[depth])].md; }
  /// Tells rows of one name apart, where there are several depths.
  std::string place(std::size_t depth) const {
    return truth_.size() > 1 ? fmt::format("{:.10g} m", md(depth)) : std::string();
  }
  /// No position where the errors turned the field along gravity.
  bool has_positions(const sensor::SensorRuns& runs, int t) const {
    for (int i = 0; i < 3 * static_cast<int>(truth_.size()); ++i)
      if (!std::isfinite(runs.positions.value(t, i))) return false;
    return true;
  }

  template <class Row>
  void observe(const sensor::SensorRuns& runs, int t, std::size_t depth, Row& x, std::uint64_t* inside) const {
    Vector3d error;
    for (int i = 0; i < 3; ++i)
      x[at(kAt.position, i)] = error[i] = runs.positions.value(t, 3 * static_cast<int>(depth) + i) - truth_[depth][i];
    for (int f = 0; f < 3; ++f) {
      const analysis::PositionPrediction& p = predictions_[depth][static_cast<std::size_t>(f)];
      double nees = 0;
      for (int a = 0; a < 3; ++a) {
        const double along = x[at(kAt.axes, f, a)] = p.axes.col(a).dot(error);
        nees += along * along / (p.sd[a] * p.sd[a]);
      }
      const Vector2d h = error.head<2>();
      for (int a = 0; a < 2; ++a) x[at(kAt.horizontal_axes, f, a)] = p.horizontal_axes.col(a).dot(h);
      const double horizontal = h.dot(p.horizontal_weight * h);
      x[at(kAt.nees_horizontal, f)] = horizontal;
      x[at(kAt.nees, f)] = p.sd[2] > 0 ? nees : kNaN;
      compare::count_inside(horizontal, inside + 3 * f);
    }
  }

  std::vector<compare::ComparisonRow> axes_rows(const stats::Tally& tally, std::size_t depth) const;
  store::Table axes_table(const stats::Tally& tally) const;
  store::Table ellipse_table(const stats::Tally& tally) const;
  store::Table covariance_table(const stats::Tally& tally) const;

  Scenario s_;
  sensor::SensorRunSetup setup_;
  random::Stream stream_;
  std::vector<Vector3d> truth_;                             ///< at every reported depth
  std::vector<analysis::PositionPredictions> predictions_;  ///< at every reported depth
  compare::VerdictStop stop_;
};

std::vector<compare::ComparisonRow> SensorMonteCarlo::axes_rows(const stats::Tally& tally, std::size_t d) const {
  std::vector<compare::ComparisonRow> rows =
      compare::compare_rows(rows_of(truth_[d], &predictions_[d]), "axes", s_.verdict, tally.trials, tally.groups[d]);
  for (compare::ComparisonRow& row : rows)
    if (row.analytic == 0 && !row.formulation.empty()) {
      row.ratio = row.ratio_interval.lo = row.ratio_interval.hi = kNaN;
      compare::leave_unjudged(row, "zero to first order");
    }
  return rows;
}

store::Table SensorMonteCarlo::axes_table(const stats::Tally& tally) const {
  store::Table all;
  for (std::size_t d = 0; d < truth_.size(); ++d) {
    std::vector<compare::ComparisonRow> rows = axes_rows(tally, d);
    stop_.add_notes("axes", rows, tally, place(d));
    s_.annotations.apply("axes", rows);
    compare::append_at_depth(
        all,
        compare::comparison_table(
            "axes",
            "position errors, and their sd along the axes of the predicted ellipsoids, largest first" +
                compare::at_confidence(s_.verdict),
            rows, tally.trials, tally.failed),
        md(d));
  }
  return all;
}

store::Table SensorMonteCarlo::ellipse_table(const stats::Tally& tally) const {
  const bool drawn = s_.plan.has(survey::ToolfaceSource::slide) || s_.plan.has(survey::ToolfaceSource::own);
  compare::TableRows t(
      "ellipse", "horizontal one-sigma ellipses, and how Monte Carlo fills them" + compare::at_confidence(s_.verdict));
  for (std::size_t d = 0; d < truth_.size(); ++d) {
    const stats::Moments& m = tally.groups[d];  // those of looks follow
    if (m.count < 3) continue;
    const Vector2d truth = truth_[d].head<2>();
    const compare::HorizontalSample sample{
        tally.trials, tally.failed, m.count, false, truth + m.mean.head<2>(), m.covariance().topLeftCorner<2, 2>()};
    t.number("md_m", "m", "measured depth", md(d));
    compare::write_sample_ellipse(t, sample);
    for (std::size_t f = 0; f < kFormulations.size(); ++f) {
      compare::EllipseRow row{kFormulations[f], truth, predictions_[d][f].covariance.topLeftCorner<2, 2>()};
      const int which = static_cast<int>(f);
      std::copy_n(tally.counts.begin() + static_cast<std::ptrdiff_t>(9 * d + 3 * f), 3, row.inside.begin());
      row.nees = stats::summarise(m, at(kAt.nees_horizontal, which));
      for (int a = 0; a < 2; ++a)
        row.along[static_cast<std::size_t>(a)] = stats::summarise(m, at(kAt.horizontal_axes, which, a));
      // Drawn toolfaces make a mixture of normal distributions, which the test would refuse whatever its covariance.
      row.wishart_p = drawn ? kNaN : stats::wishart_test(sample.covariance, row.predicted, m.count).p_value;
      row.expected = s_.annotations.expected("ellipse", row.formulation, "ellipse");
      t.number("md_m", "m", "measured depth", md(d));
      compare::write_ellipse(t, row, sample, s_.verdict);
    }
  }
  return t.take([&] {
    t.number("md_m", "m", "measured depth", 0);
    compare::write_ellipse(t, {"", Vector2d::Zero(), Eigen::Matrix2d::Zero()}, {}, s_.verdict);
  });
}

store::Table SensorMonteCarlo::covariance_table(const stats::Tally& tally) const {
  compare::TableRows t("position_covariance", "covariance of the position, true north");
  for (std::size_t d = 0; d < truth_.size(); ++d) {
    const auto row = [&](const std::string& name, const Matrix3d& c) {
      t.number("md_m", "m", "measured depth", md(d));
      t.word("formulation", "monte_carlo, or which analytic prediction", name);
      t.covariance("nev", "element of the covariance", c);
    };
    if (tally.groups[d].count > 1) row("monte_carlo", tally.groups[d].covariance().topLeftCorner<3, 3>());
    for (std::size_t f = 0; f < kFormulations.size(); ++f) row(kFormulations[f], predictions_[d][f].covariance);
  }
  return t.take();
}

class SensorMonteCarloPlan final : public study::PlanOfPoint<Scenario, SensorMonteCarlo> {
 public:
  using PlanOfPoint::PlanOfPoint;
  double cost() const override { return 1.0 * s_.survey.size() * static_cast<double>(s_.trial_plan.trials); }
};

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::sensor_monte_carlo,
                      "Twelve constant sensor errors through any survey, against the covariance model",
                      "ISCWSA MWD error model, sensor terms; Torkildsen and Bang 2000",
                      study::plan_of<SensorMonteCarloPlan, read_scenario>};
  e.approximations = {"ti_systematic", "ti_random"};
  return e;
}

}  // namespace surveymc::studies::sensor_monte_carlo
