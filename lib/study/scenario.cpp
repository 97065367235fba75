#include "study/scenario.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "base/units.h"
#include "estimate/estimators.h"
#include "montecarlo/run_blocks.h"
#include "survey/minimum_curvature.h"

namespace surveymc {

ReferenceField read_field(ConfigReader& c) {
  ReferenceField f;
  f.total = c.number("field.total_nT", Range::closed(1e3, 1e6));
  f.dip = c.number("field.dip_deg", Range::closed(-90, 90)) * kDegree;
  c.require(std::abs(f.dip) < 89.99 * kDegree, "field.dip_deg",
            "the horizontal field vanishes: there is no magnetic azimuth");
  f.declination = c.number("field.declination_deg", Range::closed(-180, 180), 0) * kDegree;
  f.convergence = c.number("field.convergence_deg", Range::closed(-180, 180), 0) * kDegree;
  f.gravity = c.number("field.gravity_mps2", Range::closed(9.7, 9.9), 9.80665);
  return f;
}

Survey read_survey(ConfigReader& c, const ReferenceField& field, bool needs_toolface) {
  SurveyConventions conventions;
  const std::vector<std::string> zeros{"x", "y"};
  const std::string zero =
      needs_toolface ? c.choice("survey.toolface_zero", zeros) : c.choice("survey.toolface_zero", zeros, "y");
  conventions.toolface_zero = zero == "x" ? ToolfaceZero::x : ToolfaceZero::y;
  const std::string north = c.choice("survey.azimuth_reference", {"true", "magnetic", "grid"}, "true");
  conventions.azimuth_reference = north == "magnetic" ? AzimuthReference::magnetic
                                  : north == "grid"   ? AzimuthReference::grid
                                                      : AzimuthReference::true_north;
  conventions.declination = field.declination;
  conventions.convergence = field.convergence;
  return survey_from_table(c.csv("survey.file"), conventions, needs_toolface);
}

std::vector<double> read_true_vertical_depths(ConfigReader& c, const Survey& survey) {
  std::vector<double> listed = tvd_from_table(c.csv("survey.file"));
  return listed.empty() ? true_vertical_depths(survey) : listed;
}

MagnetometerErrors read_magnetometer_errors(ConfigReader& c) {
  const std::vector<double> gain = c.numbers("sensor.gain", Range::open(0.1, 10), 3, {1, 1, 1});
  const std::vector<double> bias = c.numbers("sensor.bias_nT", Range::closed(-1e5, 1e5), 3, {0, 0, 0});
  return {{gain[0], gain[1], gain[2]}, {bias[0], bias[1], bias[2]}};
}

NoiseModel read_noise(ConfigReader& c) {
  NoiseModel n;
  const double scale = c.number("noise.scale", Range::positive(), 1);
  n.magnetometer = scale * c.number("noise.magnetometer_nT", Range::closed(0, 1e5));
  n.accelerometer = scale * c.number("noise.accelerometer_mps2", Range::closed(0, 1), 0);
  const std::string law =
      c.choice("noise.law", {"gaussian", "gaussian_half_open", "uniform", "uniform_half_open"}, "gaussian");
  n.law = law == "gaussian_half_open"  ? NoiseLaw::gaussian_half_open
          : law == "uniform"           ? NoiseLaw::uniform
          : law == "uniform_half_open" ? NoiseLaw::uniform_half_open
                                       : NoiseLaw::gaussian;
  const std::string per = c.choice("noise.reference.per", {"none", "run", "station"}, "none");
  n.reference = per == "run"       ? ReferenceNoise::per_run
                : per == "station" ? ReferenceNoise::per_station
                                   : ReferenceNoise::none;
  // Given but unused values stay allowed, so that `per` can be swept.
  const double total = c.number("noise.reference.total_nT", Range::closed(0, 1e5), 0);
  const double dip = c.number("noise.reference.dip_deg", Range::closed(0, 45), 0);
  if (n.reference != ReferenceNoise::none) {
    n.reference_total = scale * total;
    n.reference_dip = scale * dip * kDegree;
  }
  return n;
}

ToolSpread read_tool_spread(ConfigReader& c) {
  return {c.number("sensor.spread.gain", Range::closed(0, 0.3), 0),
          c.number("sensor.spread.bias_nT", Range::closed(0, 1e5), 0),
          c.number("sensor.spread.axial_bias_nT", Range::closed(0, 1e5), 0)};
}

namespace {

/// Estimators with this trait, for messages.
template <class Trait>
std::string names_with(const Trait& has_trait) {
  std::vector<std::string_view> names;
  for (const EstimatorKind& k : estimators())
    if (has_trait(k)) names.push_back(k.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

EstimatorOptions read_estimator(ConfigReader& c, const InputErrors& truth, const ReferenceField& field) {
  EstimatorOptions o;
  o.name = c.choice("estimator.name", estimator_names());
  const EstimatorKind& kind = estimator_kind(o.name);
  c.require(kind.predict != nullptr, "estimator.name",
            "this study compares with a prediction to first order, and \"" + o.name + "\" has none");
  o.solver = c.choice("estimator.solver", solver_names(), o.solver);
  c.require(kind.has_second_solvers || o.solver == "gauss_newton", "estimator.solver",
            o.name + " is solved in closed form: must be \"gauss_newton\"");
  o.max_iterations = static_cast<int>(c.integer("estimator.max_iterations", 1, 10000, o.max_iterations));
  o.step_tolerance = c.number("estimator.step_tolerance", Range{0, 1e-2, true, false}, o.step_tolerance);
  o.assumed = truth;
  if (!kind.derivative.empty())
    o.derivative = c.choice("estimator.derivative", derivative_names(), std::string(kind.derivative));
  else if (c.has("estimator.derivative"))
    c.fail("estimator.derivative",
           "only " + names_with([](const EstimatorKind& k) { return !k.derivative.empty(); }) + " have it");
  if (!kind.weighs) return o;
  o.assumed.magnetometer = c.number("estimator.magnetometer_nT", Range::closed(0, 1e5), truth.magnetometer);
  c.require(o.assumed.magnetometer > 0, "estimator.magnetometer_nT",
            "must be > 0: " + o.name + " weighs the readings by it");
  o.assumed.down =
      c.number("estimator.accelerometer_mps2", Range::closed(0, 1), truth.down * field.gravity) / field.gravity;
  o.assumed.total = c.number("estimator.reference.total_nT", Range::closed(0, 1e5), truth.total);
  o.assumed.dip = c.number("estimator.reference.dip_deg", Range::closed(0, 45), truth.dip / kDegree) * kDegree;
  o.assumed.gain = c.number("estimator.prior.gain", Range::closed(0, 10), truth.gain);
  o.assumed.bias = c.number("estimator.prior.bias_nT", Range::closed(0, 1e6), truth.bias);
  o.assumed.axial_bias = c.number("estimator.prior.axial_bias_nT", Range::closed(0, 1e6), truth.axial_bias);
  return o;
}

AssumedNoise read_assumed_noise(ConfigReader& c, const std::string& estimator) {
  if (!estimator_kind(estimator).weighs_each_reading) {
    if (c.has("estimator.magnetometer_drawn"))
      c.fail("estimator.magnetometer_drawn",
             "only " + names_with([](const EstimatorKind& k) { return k.weighs_each_reading; }) + " has it");
    return AssumedNoise::constant;
  }
  const std::string drawn = c.choice("estimator.magnetometer_drawn", {"constant", "sd", "variance"}, "constant");
  return drawn == "sd"         ? AssumedNoise::random_sd
         : drawn == "variance" ? AssumedNoise::random_variance
                               : AssumedNoise::constant;
}

VerdictRule read_verdict_rule(ConfigReader& c) {
  const VerdictRule usual;
  return {c.number("verdict.margin", Range::open(0, 1), usual.margin),
          c.number("verdict.confidence", Range::open(0, 1), usual.confidence),
          c.number("verdict.nees_margin", Range::open(0, 1), usual.nees_margin)};
}

TrialPlan read_trial_plan(ConfigReader& c, const std::vector<std::string>& stoppable, VerdictRule& verdict) {
  constexpr std::int64_t kMost = 1'000'000'000'000;
  TrialPlan plan;
  if (!c.has("stop")) {
    plan.trials = static_cast<std::uint64_t>(c.integer("trials", 2, kMost));
    return plan;
  }
  if (c.has("trials")) c.fail("trials", "not together with [stop]: there it is max_trials");
  plan.relative_ci = c.number("stop.relative_ci", Range::open(0, 1));
  plan.trials = static_cast<std::uint64_t>(c.integer("stop.max_trials", 4096, kMost));
  plan.quantities = c.texts("stop.quantities");
  for (const std::string& q : plan.quantities)
    if (std::find(stoppable.begin(), stoppable.end(), q) == stoppable.end())
      c.fail("stop.quantities", fmt::format("\"{}\" is none of {}", q, fmt::join(stoppable, ", ")));
  for (double n = 4096; n < static_cast<double>(plan.trials); n *= 1.5) {
    const auto blocks = static_cast<std::uint64_t>(n) / kBlockTrials;
    plan.looks.push_back(std::min(blocks * kBlockTrials, plan.trials));
  }
  plan.looks.push_back(plan.trials);
  verdict.confidence = 1 - (1 - verdict.confidence) / static_cast<double>(plan.looks.size());
  return plan;
}

}  // namespace surveymc
