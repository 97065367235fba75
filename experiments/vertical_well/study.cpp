/// Study: horizontal position uncertainty of a vertical well from constant cross-axis accelerometer biases, by Monte
/// Carlo and by the formulations of the literature. Source: C. Hanak, Superior QC, memo of 28 January 2016, figures 1
/// and 2.
///
///   ABX, ABY and toolfaces -> readings -> inclination, azimuth -> balanced tangential position (sensor) -> tally
///
/// compared with every formulation of propagate/vertical_well.h, right and wrong. North is magnetic north.
#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

#include "analysis/vertical_well_formulations.h"
#include "base/units.h"
#include "compare/annotations.h"
#include "compare/position_comparison.h"
#include "compare/trial_plan.h"
#include "compare/verdict_stop.h"
#include "config/meanings.h"
#include "config/suggest.h"
#include "random/study_stream.h"
#include "scenario/drilling.h"
#include "sensor/sensor_runs.h"
#include "stats/circular_scatter.h"
#include "stats/histogram.h"
#include "stats/tests.h"
#include "study/experiment.h"

namespace surveymc::studies::vertical_well {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

const std::string kToolfaceDependent = "toolface_dependent";

/// Numbers that are tallied of every trial: position (N, E); position over the sd of the run's own toolfaces (N, E);
/// the square of that sd over the sd of independent toolfaces; the squared Mahalanobis distance in each formulation.
enum Component { kPosition = 0, kOwn = 2, kSpread = 4, kNees = 5 };

/// Bins of the ratio of a run's own sd to that of eqs 41, 42 as random. The ratio is nearly Rayleigh distributed and
/// never exceeds 4.
constexpr stats::HistogramBins kRatioBins{4096, 4.0 / 4096};
constexpr std::array<std::pair<const char*, double>, 5> kQuantiles{
    {{"ratio_q05", .05}, {"ratio_q25", .25}, {"ratio_q50", .5}, {"ratio_q75", .75}, {"ratio_q95", .95}}};

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;
  std::uint64_t save_samples = 0;
  int legs = 0;
  double spacing = 0;  ///< m
  survey::ReferenceField field;
  double bias_sd = 0;  ///< m/s2
  survey::ToolfacePlan plan;
  std::vector<std::string> formulations;
  compare::VerdictRule verdict;
  compare::Annotations annotations;
};

std::vector<double> station_depths(int legs, double spacing) {
  std::vector<double> md;
  for (int k = 0; k <= legs; ++k) md.push_back(spacing * k);
  return md;
}

/// All rows; a quantile has no confidence sequence.
std::vector<compare::Row> rows_of(const Scenario& s) {
  std::vector<compare::Row> rows;
  for (const std::string& f : analysis::vertical_well_formulations())
    for (const std::string q : {"ellipse", "ratio_major", "ratio_minor"})
      rows.push_back({.table = "ellipse",
                      .formulation = f,
                      .quantity = q,
                      .predicted = q != "ellipse",
                      .available = std::find(s.formulations.begin(), s.formulations.end(), f) != s.formulations.end()});
  for (const auto& [name, probability] : kQuantiles)
    rows.push_back({.table = "toolface_sequences", .quantity = name, .predicted = false});
  rows.push_back({.table = "toolface_sequences", .quantity = "ratio_rms"});
  return rows;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.save_samples =
      static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, config::meaning::kSaveSamples, 0));
  const double depth =
      c.number("depth_m", config::Range::positive(), "depth of the well, at most 3000 intervals of `spacing_m`");
  s.spacing = c.number("spacing_m", config::Range::positive(), "distance of the stations");
  const double legs = depth / s.spacing;
  c.require(std::abs(legs - std::round(legs)) < 1e-9 * legs && legs > 0.5, "spacing_m",
            "must divide depth_m into whole intervals");
  c.require(legs < 3000.5, "spacing_m", "makes more than 3000 intervals");
  s.legs = static_cast<int>(std::lround(legs));
  s.field = scenario::read_field_of_magnetic_north(c);
  s.bias_sd = c.number("sensor_errors.accelerometer_bias_mps2", config::Range{0, 0.5, true, false},
                       "one sd of the biases of the accelerometers x and y, constant in a run");
  s.plan = scenario::read_drilling(c, station_depths(s.legs, s.spacing), 0, random::stream_of(seed));
  s.formulations = c.has("formulations") ? c.texts("formulations", "predictions that are compared; without it all")
                                         : analysis::vertical_well_formulations();
  const std::vector<std::string>& known = analysis::vertical_well_formulations();
  for (std::size_t f = 0; f < s.formulations.size(); ++f) {
    const auto begin = s.formulations.begin(), here = begin + static_cast<std::ptrdiff_t>(f);
    c.require(std::find(known.begin(), known.end(), *here) != known.end(), "formulations",
              config::none_of(*here, known));
    c.require(std::find(begin, here, *here) == here, "formulations", fmt::format("has \"{}\" twice", *here));
  }
  c.require(!s.formulations.empty(), "formulations", "must name at least one");
  s.verdict = compare::read_verdict_rule(c);
  s.trial_plan = compare::read_verdict_plan(c, rows_of(s), s.verdict, {20});
  s.annotations = compare::Annotations::read(c, rows_of(s));
  c.finish();
  return s;
}

sensor::SensorRunSetup run_setup(const Scenario& s) {
  survey::Survey survey;
  for (const double md : station_depths(s.legs, s.spacing)) survey.stations.push_back({md, 0, 0, 0});
  survey::SensorTermArray sd{};
  sd[survey::kAccelerometerBias] = sd[survey::kAccelerometerBias + 1] = s.bias_sd;
  return sensor::sensor_run_setup(survey, s.field, sd, s.plan, survey::PositionMethod::balanced_tangential, {s.legs});
}

class VerticalWell final : public study::StudyPoint {
 public:
  explicit VerticalWell(const Scenario& scenario)
      : s_(scenario),
        stream_(random::stream_of(s_.seed)),
        varies_(s_.plan.has(survey::ToolfaceSource::own)),
        setup_(run_setup(s_)),
        run_(analysis::vertical_well_run(s_.legs, s_.spacing, s_.field, s_.bias_sd, s_.plan, stream_)),
        independent_sd_(std::sqrt(analysis::vertical_well_covariance("ti_random", run_)(0, 0))),
        stop_(s_.trial_plan, s_.verdict, [this](const stats::Tally& t) {
          compare::RowsOfTables all;
          for (std::size_t f = 0; f < predicted_.size(); ++f) all.push_back({"ellipse", axis_rows(t, f)});
          all.push_back({"toolface_sequences", {rms_row(t)}});
          return all;
        }) {
    for (const std::string& f : s_.formulations) predicted_.push_back(analysis::vertical_well_covariance(f, run_));
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(3 * predicted_.size() + kRatioBins.bins, 0);
    Eigen::MatrixXd values(block.count, kNees + static_cast<Eigen::Index>(predicted_.size()));
    Eigen::Index row = 0;
    sensor::for_each_batch(
        setup_, stream_, block.first, block.count, [&](std::uint64_t first, const sensor::SensorRuns& runs) {
          for (int t = 0; t < runs.trials; ++t, ++row) {
            auto x = values.row(row);
            observe(runs, t, x, tally.counts);
            const std::uint64_t trial = first + static_cast<std::uint64_t>(t);
            if (trial >= s_.save_samples) continue;
            tally.samples.insert(tally.samples.end(),
                                 {static_cast<double>(trial), runs.errors.value(t, 0), runs.errors.value(t, 1),
                                  runs.positions.value(t, 0), runs.positions.value(t, 1), x[kSpread]});
          }
        });
    tally.trials = static_cast<std::uint64_t>(block.count);
    tally.moments = stats::Moments::of(values);
    stop_.keep(block, tally);
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    r.tables = {ellipse_table(tally), sequences_table(tally)};
    if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
    if (s_.save_samples > 0) r.samples = {samples_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const sensor::SensorRuns runs = sensor::runs_around(setup_, stream_, trial);
    const int lane = static_cast<int>(trial % simd::kGroup);
    std::string text = fmt::format("trial {}\n", trial);
    for (int i = 0; i < 2; ++i)
      text += fmt::format("  {}  {:.17g} m/s2\n", survey::kSensorTermCodes[static_cast<std::size_t>(i)],
                          runs.errors.value(lane, i));
    text += "  magnetic toolfaces (deg)";
    for (const double t : sensor::toolfaces_of_trial(s_.plan, stream_, trial))
      text += fmt::format(" {:.6g}", t / kDegree);
    text += "\n";
    for (const auto& [name, row] : {std::pair{"north", 0}, std::pair{"east", 1}})
      text += fmt::format("  {:<6} {:.17g} m\n", name, runs.positions.value(lane, row));
    return text;
  }

 private:
  template <class Row>
  void observe(const sensor::SensorRuns& runs, int t, Row& x, std::vector<std::uint64_t>& counts) const {
    const double n = runs.positions.value(t, 0), e = runs.positions.value(t, 1);
    double cosine = 0, sine = 0;
    for (int k = 0; k <= s_.legs; ++k) {
      cosine += run_.weights[static_cast<std::size_t>(k)] * runs.toolface.value(t, 2 * k);
      sine += run_.weights[static_cast<std::size_t>(k)] * runs.toolface.value(t, 2 * k + 1);
    }
    // Eqs 19 and 20 with this run's toolfaces: both biases add up to a circle.
    const double own_sd = run_.tilt_sd * std::sqrt(cosine * cosine + sine * sine);
    x[kPosition] = n;
    x[kPosition + 1] = e;
    x[kOwn] = n / own_sd;
    x[kOwn + 1] = e / own_sd;
    x[kSpread] = own_sd * own_sd / (independent_sd_ * independent_sd_);
    for (std::size_t f = 0; f < predicted_.size(); ++f) {
      const Matrix2d& c = predicted_[f];  // diagonal, all of them
      const bool own = s_.formulations[f] == kToolfaceDependent;
      const double squared = own ? (n * n + e * e) / (own_sd * own_sd) : n * n / c(0, 0) + e * e / c(1, 1);
      x[kNees + static_cast<Eigen::Index>(f)] = squared;
      compare::count_inside(squared, counts.data() + 3 * f);
    }
    ++counts[3 * predicted_.size() + kRatioBins.bin(own_sd / independent_sd_)];
  }

  compare::HorizontalSample sample_of(const stats::Tally& tally) const {
    const stats::Moments& m = tally.moments;
    return {tally.trials, 0, m.count, false, m.mean.head<2>(), m.covariance().topLeftCorner<2, 2>()};
  }

  bool has_own_ellipse(std::size_t formulation) const {
    return varies_ && s_.formulations[formulation] == kToolfaceDependent;
  }
  /// Covariance whose axes are compared. Where each run has its own ellipse: their mean square, which is what the cloud
  /// of all runs shows.
  Matrix2d compared_covariance(const stats::Moments& m, std::size_t formulation) const {
    return has_own_ellipse(formulation)
               ? Matrix2d(independent_sd_ * independent_sd_ * m.mean[kSpread] * Matrix2d::Identity())
               : predicted_[formulation];
  }
  /// Positions along the axes of a diagonal covariance, largest first: they are north and east.
  static std::array<stats::SampleSummary, 2> along_axes(const stats::Moments& m, const propagate::Ellipse& e) {
    std::array<stats::SampleSummary, 2> along;
    for (std::size_t a = 0; a < 2; ++a)
      along[a] =
          stats::summarise(m, std::abs(e.axes(0, static_cast<Eigen::Index>(a))) > 0.5 ? kPosition : kPosition + 1);
    return along;
  }
  /// The axes of a formulation of table `ellipse`, one by one.
  std::vector<compare::ComparisonRow> axis_rows(const stats::Tally& tally, std::size_t formulation) const;
  compare::ComparisonRow rms_row(const stats::Tally& tally) const;
  store::Table ellipse_table(const stats::Tally& tally) const;
  store::Table sequences_table(const stats::Tally& tally) const;
  store::Table samples_table(const stats::Tally& tally) const;

  Scenario s_;
  random::Stream stream_;
  bool varies_;  ///< the ellipse of eqs 19, 20 differs from run to run; that of a slide turns only, and it is a circle
  sensor::SensorRunSetup setup_;
  analysis::VerticalWellRun run_;
  double independent_sd_;            ///< m, of eqs 41, 42 as random
  std::vector<Matrix2d> predicted_;  ///< covariance of every formulation
  compare::VerdictStop stop_;
};

std::vector<compare::ComparisonRow> VerticalWell::axis_rows(const stats::Tally& tally, std::size_t f) const {
  const propagate::Ellipse e = propagate::ellipse(compared_covariance(tally.moments, f));
  const std::array<stats::SampleSummary, 2> along = along_axes(tally.moments, e);
  return {compare::labelled(s_.formulations[f], compare::compare_sd("ratio_major", "m", 1, along[0], e.semi_major,
                                                                    s_.verdict, tally.trials)),
          compare::labelled(s_.formulations[f], compare::compare_sd("ratio_minor", "m", 1, along[1], e.semi_minor,
                                                                    s_.verdict, tally.trials))};
}

store::Table VerticalWell::ellipse_table(const stats::Tally& tally) const {
  compare::TableRows t("ellipse", "horizontal one-sigma ellipses of the last position, and how Monte Carlo fills them" +
                                      compare::at_confidence(s_.verdict));
  const stats::Moments& m = tally.moments;
  const compare::HorizontalSample sample = sample_of(tally);
  compare::write_sample_ellipse(t, sample);
  for (std::size_t f = 0; f < predicted_.size(); ++f) {
    const std::string& name = s_.formulations[f];
    compare::EllipseRow row{name, Vector2d::Zero(), predicted_[f]};
    const auto nees = kNees + static_cast<Eigen::Index>(f);
    std::copy_n(tally.counts.begin() + static_cast<std::ptrdiff_t>(3 * f), 3, row.inside.begin());
    row.nees = stats::summarise(m, nees);
    row.predicted = compared_covariance(m, f);
    if (has_own_ellipse(f)) {
      row.wishart_p =
          stats::wishart_test(m.covariance().block<2, 2>(kOwn, kOwn), Matrix2d::Identity(), m.count).p_value;
      row.note = "axes: root mean square over the runs' toolfaces; coverage, nees, p: by each run's own ellipse";
    } else {
      row.wishart_p = varies_ ? kNaN : stats::wishart_test(sample.covariance, predicted_[f], m.count).p_value;
    }
    row.along = along_axes(m, propagate::ellipse(row.predicted));
    if (stop_.is_on()) {
      std::vector<compare::ComparisonRow> axes = axis_rows(tally, f);
      for (compare::ComparisonRow& axis : axes) axis.note.clear();  // what else there is to say of it
      stop_.add_notes("ellipse", axes, tally);
      for (const compare::ComparisonRow& axis : axes)
        if (!axis.note.empty())
          row.note += fmt::format("{}{}: {}", row.note.empty() ? "" : "; ", axis.quantity, axis.note);
    }
    row.expected = s_.annotations.expected("ellipse", name, "ellipse");
    std::vector<compare::ComparisonRow> published{compare::empty_row(name, "ratio_major", "1"),
                                                  compare::empty_row(name, "ratio_minor", "1")};
    s_.annotations.apply("ellipse", published);
    row.published_major = published[0].published;
    row.published_minor = published[1].published;
    compare::write_ellipse(t, row, sample, s_.verdict);
  }
  return t.take();
}

/// The sd of both directions over that of eqs 41, 42 as random.
compare::ComparisonRow VerticalWell::rms_row(const stats::Tally& tally) const {
  const stats::Moments& m = tally.moments;
  // Given its toolfaces a run is normal with the same sd in both directions, which are independent; over runs their
  // squares go together as far as that sd varies.
  const double square = independent_sd_ * independent_sd_;
  const double covariance_of_squares = varies_ ? square * square * m.variance(kSpread) : 0;
  const stats::CircularScatter both{m.count,
                                    m.variance(kPosition),
                                    m.variance(kPosition + 1),
                                    m.kurtosis(kPosition),
                                    m.kurtosis(kPosition + 1),
                                    covariance_of_squares};
  const stats::Interval sd = s_.verdict.at_all_looks ? stats::circular_sd_sequence(both, s_.verdict.confidence)
                                                     : stats::circular_sd_interval(both, s_.verdict.confidence);
  const char* right = varies_ ? "fictive_terms" : kToolfaceDependent.c_str();
  compare::ComparisonRow row = compare::compare_value(
      "ratio_rms", "1", {both.sd() / independent_sd_, {sd.lo / independent_sd_, sd.hi / independent_sd_}},
      std::sqrt(analysis::vertical_well_covariance(right, run_)(0, 0)) / independent_sd_, s_.verdict, tally.trials);
  row.note = varies_ ? "sd of all runs; analytic: fictive terms" : "sd of all runs; analytic: toolface_dependent";
  return row;
}

/// How far one toolface sequence is from the mean over all: eqs 41, 42 as random describe only the latter.
store::Table VerticalWell::sequences_table(const stats::Tally& tally) const {
  std::vector<compare::ComparisonRow> rows{rms_row(tally)};
  if (s_.plan.has(survey::ToolfaceSource::own) && !s_.plan.has(survey::ToolfaceSource::slide)) {
    const std::uint64_t* counts = tally.counts.data() + 3 * predicted_.size();
    for (const auto& [name, probability] : kQuantiles) {
      rows.push_back(compare::compare_quantile(name, "1", kRatioBins, counts, probability,
                                               std::sqrt(-std::log1p(-probability)), s_.verdict, tally.trials));
      rows.back().note = "of the runs' own sd (eqs 19, 20); analytic: Rayleigh, the limit of many stations";
    }
  }
  stop_.add_notes("toolface_sequences", rows, tally);
  s_.annotations.apply("toolface_sequences", rows);
  return compare::comparison_table(
      "toolface_sequences",
      "sd of a toolface sequence over that of eqs 41, 42 as random" + compare::at_confidence(s_.verdict), rows,
      tally.trials, 0);
}

store::Table VerticalWell::samples_table(const stats::Tally& tally) const {
  store::Table t{"realisations", "biases and last positions of the first trials"};
  t.columns = {compare::number_column("trial", "1", "number of the trial, from 0"),
               compare::number_column("bias_x_mps2", "m/s2", "accelerometer bias of the run"),
               compare::number_column("bias_y_mps2", "m/s2", "accelerometer bias of the run"),
               compare::number_column("north_m", "m", "error of the last position"),
               compare::number_column("east_m", "m", "error of the last position"),
               compare::number_column("own_variance_ratio", "1",
                                      "variance of this run's toolfaces over that of eqs 41, 42 as random")};
  return compare::table_of_numbers(std::move(t), tally.samples);
}

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::vertical_well,
                      "Cross-axis accelerometer bias in a vertical well: every weighting function against Monte Carlo",
                      "C. Hanak, Superior QC 2016, figures 1 and 2",
                      study::plan_of<study::PlanOfPoint<Scenario, VerticalWell>, read_scenario>};
  e.approximations = {"fictive_terms_accelerometer_toolface",
                      "ti_random",
                      "ti_systematic",
                      "spe_67616",
                      "copegrove_without_half_leg",
                      "copegrove_with_half_leg",
                      "fictive_terms"};
  return e;
}

}  // namespace surveymc::studies::vertical_well
