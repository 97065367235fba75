/// Runs of `msa_position` with any parameters:
///
///   tool and noise drawn -> readings (analysis) -> fit (multistation) -> corrected readings, minimum curvature ->
///   tally
///
/// compared with the first-order prediction (analysis/multistation_prediction.h). Tables follow from the table of
/// parameters: nothing here knows how many there are.
#include "msa_position/parameter_set.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "base/units.h"
#include "compare/position_comparison.h"
#include "compare/table_rows.h"
#include "msa_position/scenario.h"
#include "random/study_stream.h"
#include "scenario/drilling.h"
#include "scenario/scenario.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

namespace {

/// Tallied: errors of p parameters, of the position (N, E, V; high side, lateral, along hole), squared distances.
struct Places {
  explicit Places(const multistation::ParameterSet& set)
      : position(set.size()), hole(position + 3), nees(hole + 3), nees_horizontal(nees + 1), count(nees + 2) {}
  int position, hole, nees, nees_horizontal, count;
};

/// `prediction`: null before the point is prepared.
std::vector<compare::Row> set_rows(const SetScenario& s, const analysis::MultistationPrediction* prediction) {
  using enum compare::Statistic;
  const multistation::ParameterSet& set = s.estimator.fit.parameters;
  const Places at(set);
  std::vector<compare::Row> rows;
  const RowAdder add(rows);
  const auto of = [&](auto value) { return prediction ? value(*prediction) : kNaN; };
  using P = analysis::MultistationPrediction;
  for (int i = 0; i < set.size(); ++i)
    add("parameters", "first_order", std::string("mean_error_") + set[i].name, set[i].unit, mean, i,
        of([i](const P& p) { return p.shift[i]; }));
  for (const bool claimed : {false, true})
    for (int i = 0; i < set.size(); ++i)
      add("parameters", claimed ? "claimed" : "first_order", std::string("sigma3_") + set[i].name, set[i].unit, sd, i,
          of([i, claimed](const P& p) { return std::sqrt(claimed ? p.claimed(i, i) : p.covariance(i, i)); }));
  add("parameters", "first_order", "nees", "1", squared_distance, at.nees, set.size()).predicted = false;
  for (int i = 0; i < 3; ++i)
    add("position", "joint", std::string("mean_error_") + kDirections[static_cast<std::size_t>(i)], "m", mean,
        at.position + i, of([i](const P& p) { return p.position[i]; }));
  for (int i = 0; i < 3; ++i)
    add("position", "joint", std::string("sigma3_") + kDirections[static_cast<std::size_t>(i)], "m", sd,
        at.position + i, of([i](const P& p) { return std::sqrt(p.position_covariance(i, i)); }));
  add("position", "joint", "nees_horizontal", "1", squared_distance, at.nees_horizontal, 2).predicted = false;
  const survey::Station& last = s.survey.stations.back();
  const Eigen::Matrix3d r = survey::rotation_hla_from_nev(last.inclination, last.azimuth);
  for (int i = 0; i < 3; ++i)
    add("position_hla", "joint", std::string("sigma3_") + kHoleDirections[static_cast<std::size_t>(i)], "m", sd,
        at.hole + i, of([&](const P& p) {
          const Eigen::Matrix3d c = r * p.position_covariance * r.transpose();
          return sd_above_rounding(c(i, i), c);
        }));
  return rows;
}

class SetPoint final : public study::StudyPoint {
 public:
  explicit SetPoint(const SetScenario& s)
      : s_(s),
        at_(s.estimator.fit.parameters),
        prediction_(analysis::predict_multistation(s.run, s.estimator.fit, s.estimator.cost())),
        rows_(set_rows(s_, &prediction_)),
        stop_(s_.trial_plan, s_.verdict,
              [this](const stats::Tally& t) {
                compare::RowsOfTables all;
                for (const char* table : kTables) all.push_back({table, rows_of_table(table, t)});
                return all;
              }),
        plan_(multistation::fit_plan(s.estimator.fit)),
        stream_(random::stream_of(s.seed)),
        weight_(prediction_.covariance.inverse()),
        horizontal_weight_(prediction_.position_covariance.topLeftCorner<2, 2>().inverse()) {
    const survey::Station& last = s_.survey.stations.back();
    hla_from_nev_ = survey::rotation_hla_from_nev(last.inclination, last.azimuth);
    true_position_ = survey::minimum_curvature_positions(s_.survey).back();
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override {
    return stop_.is_on() && tally.moments.count > 1 ? stop_.trials_needed(tally) : s_.trial_plan.trials;
  }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    constexpr int kBatch = 64;  // fits the caches; divides a block
    stats::Tally tally;
    Eigen::MatrixXd values(block.count + 8, at_.count);
    Eigen::Index kept = 0;
    for (int begin = 0; begin < block.count; begin += kBatch) {
      Batch b(std::min(kBatch, block.count - begin), s_);
      const std::uint64_t first = block.first + static_cast<std::uint64_t>(begin);
      simulate(first, b);
      for (int t = 0; t < b.readings.trials; ++t) {
        ++tally.trials;
        if (b.found.converged.value(t, 0) == 0) {
          tally.add_failed(first + static_cast<std::uint64_t>(t));
          continue;
        }
        observe(b, t, values.row(kept++));
      }
    }
    tally.moments = stats::Moments::of(values.topRows(kept));
    stop_.keep(block, tally);
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    for (const char* table : kTables) {
      std::vector<compare::ComparisonRow> rows = rows_of_table(table, tally);
      stop_.add_notes(table, rows, tally);
      r.tables.push_back(compare::comparison_table(table, long_name(table), rows, tally.trials, tally.failed, true));
    }
    r.tables.push_back(learnt_table());
    r.tables.push_back(observability_table());
    r.tables.push_back(benefit_table());
    if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
    if (const auto warnings = scenario::warn_of_limits(prediction_.limits); !warnings.empty())
      r.tables.push_back(compare::warnings_table(warnings));
    r.tables.push_back(compare::failed_trials_table("trials without a converged estimate", tally.failed_trials));
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    Batch b(simd::kGroup, s_);
    simulate(trial / simd::kGroup * simd::kGroup, b);
    const int lane = static_cast<int>(trial % simd::kGroup);
    std::string text = fmt::format("trial {}\n", trial);
    text += fmt::format("  reference        gravity {:.17g} m/s2, Bh {:.17g} nT, Bv {:.17g} nT (station 0)\n",
                        b.readings.reference.value(lane, 0), b.readings.reference.value(lane, 1),
                        b.readings.reference.value(lane, 2));
    const multistation::ParameterSet& set = s_.estimator.fit.parameters;
    for (int i = 0; i < set.size(); ++i)
      text += fmt::format("  {:<16} {:.17g} {}, true {:.17g}\n", set[i].name, b.found.estimate.value(lane, i),
                          set[i].unit, b.tools.value(lane, set.index(i)));
    const char* const ends = b.found.converged.value(lane, 0) != 0 ? "converged" : "NOT converged";
    if (is_robust()) {
      text += fmt::format("  scale            {:.17g} after {} reweightings, {}\n", b.robust.scale.value(lane, 0),
                          b.robust.reweightings.value(lane, 0), ends);
      for (int k = 0; k < s_.survey.size(); ++k)
        text += fmt::format("  weight {:<9} {:.17g}\n", k + 1, b.robust.weights.value(lane, k));
    } else {
      text += fmt::format("  cost             {:.17g} after {} evaluations, {}\n", b.found.cost.value(lane, 0),
                          b.found.iterations.value(lane, 0), ends);
    }
    for (int i = 0; i < 3; ++i)
      text += fmt::format("  {:<16} {:.17g} m\n", kDirections[static_cast<std::size_t>(i)], b.position.value(lane, i));
    return text;
  }

 private:
  static constexpr std::array<const char*, 3> kTables{"parameters", "position", "position_hla"};

  std::string long_name(std::string_view table) const {
    const std::string what = table == "parameters" ? "estimates less the errors of the trial's tool"
                             : table == "position" ? "final position of the corrected survey less the true one"
                                                   : "the same along high side, lateral and hole at the last station";
    return what + ", against the first-order prediction" + compare::at_confidence(s_.verdict);
  }

  bool is_robust() const { return s_.estimator.robust.loss != multistation::Loss::least_squares; }

  struct Batch {
    Batch(int trials, const SetScenario& s)
        : readings(trials, s.survey.size(), s.run.reference_per_station),
          tools(readings.groups(), multistation::kParameters),
          found(trials, s.estimator.fit),
          robust(trials, s.survey.size()),
          position(readings.groups(), 3) {}
    multistation::SixAxisBlock readings;  ///< after simulate() the corrected ones
    survey::LaneArray tools;
    multistation::FitBlock found;
    multistation::RobustBlock robust;  ///< of a robust loss
    survey::LaneArray position;
  };

  void simulate(std::uint64_t first, Batch& b) const {
    analysis::simulate_multistation(s_.run, stream_, first, b.readings, b.tools);
    multistation::fit_block_by_loss(b.readings, plan_, s_.estimator.fit.parameters, s_.estimator.robust, stream_, first,
                                    b.found, b.robust);
    multistation::correct_block(b.readings, plan_, s_.estimator.fit.parameters, b.found);
    analysis::multistation_positions(b.readings, s_.run.md, s_.run.field.declination, b.position);
  }

  template <class Row>
  void observe(const Batch& b, int t, Row&& x) const {
    const multistation::ParameterSet& set = s_.estimator.fit.parameters;
    const int p = set.size();
    for (int i = 0; i < p; ++i) x[i] = b.found.estimate.value(t, i) - b.tools.value(t, set.index(i));
    Eigen::VectorXd error(p);
    for (int i = 0; i < p; ++i) error[i] = x[i] - prediction_.shift[i];
    Eigen::Vector3d off;
    for (int i = 0; i < 3; ++i) x[at_.position + i] = off[i] = b.position.value(t, i) - true_position_[i];
    const Eigen::Vector3d hole = hla_from_nev_ * off;
    for (int i = 0; i < 3; ++i) x[at_.hole + i] = hole[i];
    x[at_.nees] = error.dot(weight_ * error);
    const Eigen::Vector2d horizontal = (off - prediction_.position).head<2>();
    x[at_.nees_horizontal] = horizontal.dot(horizontal_weight_ * horizontal);
  }

  std::vector<compare::ComparisonRow> rows_of_table(const std::string& table, const stats::Tally& tally) const {
    std::vector<compare::ComparisonRow> rows =
        compare::compare_rows(rows_, table, s_.verdict, tally.trials, tally.moments);
    s_.annotations.apply(table, rows);
    return rows;
  }

  store::Table learnt_table() const {
    const multistation::ParameterSet& set = s_.estimator.fit.parameters;
    compare::TableRows t("learnt", "what the run knows of each parameter, against its prior");
    for (int i = 0; i < set.size(); ++i) {
      t.word("parameter", "error that is estimated", set[i].name);
      t.word("unit", "its unit", set[i].unit);
      t.number("prior_sd", "1", "one sd of the prior about 0",
               s_.estimator.fit.prior_sd[static_cast<std::size_t>(set.index(i))]);
      t.number("claimed_sd", "1", "one sd after the run, by what the estimator assumes",
               std::sqrt(prediction_.claimed(i, i)));
      t.number("learnt_share", "1", "1 less the ratio of both variances; negative: the reference moves it by more",
               prediction_.learnt[i]);
      t.number("sd", "1", "one sd of estimate less truth to first order, by what is drawn",
               std::sqrt(prediction_.covariance(i, i)));
    }
    return t.take();
  }

  store::Table observability_table() const {
    const multistation::ParameterSet& set = s_.estimator.fit.parameters;
    const multistation::SetObservability& o = prediction_.observability;
    const estimate::Observability& c = o.combinations;
    compare::TableRows t("observability",
                         "combinations of parameters, weakest first: singular vectors of the Jacobian with columns of "
                         "unit length");
    for (int j = 0; j < set.size(); ++j) {
      const double index = c.condition_indices[j];
      t.count("parameters", "size of the set", set.size());
      t.count("rank", "combinations with an effect: condition index below 1e6", o.rank);
      t.count("learnt", "combinations that the run knows better than the priors do", o.learnt);
      t.word("combination", "the parameters that matter in it, and whether their errors go with or against",
             multistation::combination_name(o, set, j));
      t.number("singular_value", "1", "how strongly the residuals answer; 1 if no parameters are alike",
               c.singular_values[j]);
      t.number("condition_index", "1", "largest singular value over this; above 30 weak, above 100 severe", index);
      t.word("judgement", "determined, weak, severe or without effect",
             index >= estimate::kHopelessCondition ? "without effect"
             : index > estimate::kSevereCondition  ? "severe"
             : index > estimate::kWeakCondition    ? "weak"
                                                   : "determined");
      t.number("against_prior", "1", "singular value of J diag(prior sd), rising; above 1: learnt",
               o.against_prior[set.size() - 1 - j]);
    }
    return t.take();
  }

  store::Table benefit_table() const {
    const auto sd = [&](const Eigen::Matrix3d& c, int i) {
      return std::sqrt((hla_from_nev_ * c * hla_from_nev_.transpose())(i, i));
    };
    compare::TableRows t("benefit", "final position to first order, with and without the correction");
    for (int i = 0; i < 3; ++i) {
      const double before = sd(prediction_.uncorrected_covariance, i), after = sd(prediction_.position_covariance, i);
      t.word("direction", "at the last station", kHoleDirections[static_cast<std::size_t>(i)]);
      t.number("sd_uncorrected_m", "m", "one sd of the readings as they are", before);
      t.number("sd_corrected_m", "m", "one sd after the correction", after);
      t.number("ratio", "1", "corrected over uncorrected; above 1 the correction does harm", after / before);
    }
    return t.take();
  }

  SetScenario s_;
  Places at_;
  analysis::MultistationPrediction prediction_;
  std::vector<compare::Row> rows_;
  compare::VerdictStop stop_;
  multistation::FitPlan plan_;
  random::Stream stream_;
  Eigen::MatrixXd weight_;
  Eigen::Matrix2d horizontal_weight_;
  Eigen::Matrix3d hla_from_nev_;
  Eigen::Vector3d true_position_;
};

class SetPlan final : public study::PlanOf<SetScenario> {
 public:
  using PlanOf::PlanOf;
  double cost() const override { return 3.0 * s_.survey.size() * static_cast<double>(s_.trial_plan.trials); }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return s_.survey_place.with_place([&] { return std::make_unique<SetPoint>(s_); });
  }
};

}  // namespace

std::optional<SetScenario> read_set_scenario(config::ConfigReader& c, random::StudySeed seed) {
  if (!scenario::wants_parameter_set(c)) return std::nullopt;
  scenario::refuse_beside_parameters(
      c, {"event", "outputs", "save_samples", "antithetic", "control_variate", "prediction", "calibration", "tails",
          "reference_law", "disturbance.kind", "estimator.solver", "estimator.derivative", "estimator.step_tolerance",
          "estimator.prior", "estimator.magnetometer_drawn"});
  SetScenario s;
  s.seed = seed;
  const survey::ReferenceField field = scenario::read_field(c);
  const sensor::NoiseModel noise = scenario::read_noise(c);
  const analysis::MultistationRun sizes = scenario::multistation_sizes(c, noise);
  s.estimator = scenario::read_parameter_set(c, {noise.accelerometer, noise.magnetometer, sizes.reference}, field);
  s.survey = scenario::read_drilled_survey(c, field, seed);
  s.survey_place = c.place("survey.file");
  s.run = analysis::multistation_run(s.survey, field);
  const sensor::MagnetometerErrors tool = scenario::read_magnetometer_errors(c);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    s.run.tool[multistation::kMagnetometerScale + axis] = tool.gain[axis] - 1;
    s.run.tool[multistation::kMagnetometerBias + axis] = tool.bias[axis];
  }
  s.run.tool_sd = scenario::read_tool_sd(c, s.estimator.fit);
  s.run.accelerometer = sizes.accelerometer;
  s.run.magnetometer = sizes.magnetometer;
  s.run.reference = sizes.reference;
  s.run.reference_per_station = sizes.reference_per_station;
  s.verdict = compare::read_verdict_rule(c);
  const std::vector<compare::Row> rows = set_rows(s, nullptr);
  s.trial_plan = compare::read_verdict_plan(c, rows, s.verdict, {});
  s.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return s;
}

std::unique_ptr<study::PointPlan> set_plan(SetScenario scenario) {
  return std::make_unique<SetPlan>(std::move(scenario));
}

}  // namespace surveymc::studies::msa_position
