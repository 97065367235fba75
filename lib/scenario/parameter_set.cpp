#include "scenario/parameter_set.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/multistation_prediction.h"
#include "base/units.h"
#include "config/suggest.h"
#include "scenario/scenario.h"

namespace surveymc::scenario {

namespace {

using multistation::PerParameter;

/// "WHAT: MEANING OF THE PARAMETER, one sd in its unit", for all parameters; lives as long as the program does.
PerParameter<std::string> meanings(const std::string& what) {
  PerParameter<std::string> out;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = fmt::format("{}: {}, one sd, {}", what, multistation::kTable[i].meaning, multistation::kTable[i].unit);
  return out;
}

/// A number for each parameter, `prefix`NAME.
PerParameter<double> read_each(config::ConfigReader& c, const std::string& prefix, const config::Range& range,
                               const PerParameter<std::string>& meaning, PerParameter<double> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = c.number(prefix + multistation::kTable[i].name, range, meaning[i], values[i]);
  return values;
}

std::vector<std::string> read_names(config::ConfigReader& c) {
  return c.texts(
      "estimator.parameters",
      "constant errors that are estimated: '6': biases and scales of the magnetometers; '9': 6 and the rotation of the "
      "magnetometers; '12': biases and scales of both triads; '15': 12 and the rotation; '18': 15 and magnetometer "
      "axes "
      "that are not orthogonal; '21': all; or a list of `abx` to `ayz`. Without the key: six gains and biases by "
      "`estimator.name`, which is what '6' is where there is no `estimator.robust`; of `estimate` 'justified': the set "
      "with the least information criterion; of `robustness_map` '3': biases of the magnetometers");
}

}  // namespace

AskedParameters read_parameters(config::ConfigReader& c, const std::vector<std::string>& words) {
  const std::vector<std::string> names = read_names(c), &sets = multistation::set_names();
  const auto is_in = [&](const std::vector<std::string>& all) {
    return names.size() == 1 && std::find(all.begin(), all.end(), names[0]) != all.end();
  };
  if (is_in(words)) return {{}, names[0]};
  if (is_in(sets)) return {multistation::ParameterSet::named(names[0]), {}};
  for (const std::string& name : names) {
    if (multistation::find_parameter(name) >= 0) continue;
    std::vector<std::string> known;
    if (names.size() == 1) {  // a word, or a list of one
      known = words;
      known.insert(known.end(), sets.begin(), sets.end());
    }
    for (const multistation::Parameter& p : multistation::kTable) known.emplace_back(p.name);
    c.fail("estimator.parameters", config::none_of(name, known));
  }
  return {c.place("estimator.parameters").with_place([&] { return multistation::ParameterSet::of(names); }), {}};
}

bool wants_parameter_set(config::ConfigReader& c) {
  const bool is_robust = c.has("estimator.robust");
  if (!c.has("estimator.parameters")) {
    c.require(!is_robust, "estimator.robust",
              "is of estimators by estimator.parameters: name them, \"6\" for biases and scales of the magnetometers");
    return false;
  }
  return is_robust || read_names(c) != std::vector<std::string>{"6"};
}

void refuse_beside_parameters(config::ConfigReader& c, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    c.require(!c.has(key), key,
              "is not of estimators by estimator.parameters and estimator.robust: leave it, or these two, out");
}

AskedLoss read_loss(config::ConfigReader& c) {
  c.require(!c.has("estimator.robust.name"), "estimator.robust", "is a table: write { loss = \"cauchy\" }");
  const std::vector<std::string>& losses = multistation::loss_names();
  const std::string loss = c.choice("estimator.robust.loss", losses,
                                    "loss of the fit: all but 'least_squares' give stations with large residuals less "
                                    "weight; 'tukey' starts at the least median of squares",
                                    "least_squares");
  const std::string start =
      c.choice("estimator.robust.start", {"least_squares", "lmeds"},
               "where a robust loss starts: 'lmeds', the least median of squares of subsets; 'tukey' always does",
               "least_squares");
  return {static_cast<multistation::Loss>(std::find(losses.begin(), losses.end(), loss) - losses.begin()),
          start == "lmeds" ? multistation::RobustStart::lmeds : multistation::RobustStart::least_squares};
}

multistation::ReferenceErrors read_reference_errors(config::ConfigReader& c,
                                                    const multistation::ReferenceErrors& fallback) {
  return {c.number("estimator.reference.gravity_mps2", config::Range::closed(0, 1),
                   "one sd that the estimator assumes of the reference's gravity", fallback.gravity),
          c.number("estimator.reference.total_nT", config::Range::closed(0, 1e5), config::kMeaningElsewhere,
                   fallback.total),
          c.number("estimator.reference.dip_deg", config::Range::closed(0, 45), config::kMeaningElsewhere,
                   fallback.dip / kDegree) *
              kDegree};
}

PerParameter<double> read_priors(config::ConfigReader& c, const PerParameter<double>& fallback) {
  static const PerParameter<std::string> prior_meanings = meanings("prior about 0");
  return read_each(c, "estimator.priors.", config::Range::positive(), prior_meanings, fallback);
}

SetEstimator read_parameter_set(config::ConfigReader& c, const AssumedSizes& truth,
                                const survey::ReferenceField& field) {
  SetEstimator out;
  multistation::FitOptions& o = out.fit;
  o.parameters = *read_parameters(c).set;
  const AskedLoss asked = read_loss(c);
  out.robust = multistation::robust_options(asked.loss, asked.start);
  c.require(asked.loss == multistation::Loss::least_squares || truth.magnetometer > 0, "estimator.robust.loss",
            "weighs stations by what noise leaves in them: give noise.magnetometer_nT");
  if (c.has("estimator.robust.start") &&
      (asked.loss == multistation::Loss::least_squares || out.robust.start != asked.start))
    c.warn("estimator.robust.start", "has no effect on this loss",
           "leave it out, or give estimator.robust.loss \"l1\", \"huber\" or \"cauchy\"");
  const std::string name = c.choice("estimator.name", {"msa", "msa_joint"}, config::kMeaningElsewhere);
  o.estimates_reference = name == "msa_joint";
  o.prior_sd = read_priors(c, truth.prior_sd);
  const double accelerometer = c.number("estimator.accelerometer_mps2", config::Range::closed(0, 1),
                                        config::kMeaningElsewhere, truth.accelerometer),
               magnetometer = c.number("estimator.magnetometer_nT", config::Range::closed(0, 1e5),
                                       config::kMeaningElsewhere, truth.magnetometer);
  c.require(magnetometer > 0, "estimator.magnetometer_nT", "must be > 0: readings are weighed by it");
  c.require(accelerometer > 0 || !o.parameters.corrects_accelerometers(), "estimator.accelerometer_mps2",
            "must be > 0 where errors of the accelerometers are estimated: |g| is weighed by it");
  // Noise of the accelerometers turns down: it moves Bh by Bv, and Bv by Bh.
  const double turn = accelerometer / field.gravity, horizontal = field.total * std::cos(field.dip),
               vertical = field.total * std::sin(field.dip);
  o.sizes = {accelerometer > 0 ? accelerometer : 1, std::hypot(magnetometer, turn * vertical),
             std::hypot(magnetometer, turn * horizontal)};
  o.gravity_is_noisy = accelerometer > 0 && truth.accelerometer > 0;
  o.total = field.total;
  o.dip = field.dip;
  o.reference = read_reference_errors(c, truth.reference);
  o.max_iterations = static_cast<int>(c.integer("estimator.max_iterations", 1, 10000, config::kMeaningElsewhere, 200));
  out.robust.newton_steps = o.max_iterations;
  return out;
}

std::vector<compare::Warning> warn_of_limits(const analysis::RobustLimits& limits) {
  std::vector<compare::Warning> out;
  const auto add = [&out](const std::string& what, const char* way_out) {
    out.push_back(
        {"warning", "estimator.robust.loss", "", what + ": sds to first order may be off by more than 5 %", way_out});
  };
  if (limits.shared > analysis::kLargeSharedResidual)
    add(fmt::format("of errors that stations share the fit leaves {:.2f} times the stations' own", limits.shared),
        "estimate the reference with the tool (estimator.name = \"msa_joint\"), and what errors the tool has");
  if (limits.uneven > analysis::kLargeUnevenness)
    add(fmt::format("a loss takes what is drawn at stations as even in units of the sizes that are assumed, but it is "
                    "{:.2g} times as large in one direction as in another",
                    limits.uneven),
        "let estimator.magnetometer_nT and estimator.accelerometer_mps2 be what is drawn");
  return out;
}

PerParameter<double> read_tool_sd(config::ConfigReader& c, const multistation::FitOptions& estimator) {
  PerParameter<double> sd{};
  for (int i = 0; i < estimator.parameters.size(); ++i) {
    const auto at = static_cast<std::size_t>(estimator.parameters.index(i));
    sd[at] = estimator.prior_sd[at];
  }
  if (const sensor::ToolSpread spread = read_tool_spread(c); spread.any())
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sd[multistation::kMagnetometerScale + axis] = spread.sd(axis);
      sd[multistation::kMagnetometerBias + axis] = spread.sd(3 + axis);
    }
  static const PerParameter<std::string> spread_meanings = meanings("drawn anew for every run");
  return read_each(c, "sensor.spread.parameters.", config::Range::non_negative(), spread_meanings, sd);
}

analysis::MultistationRun multistation_sizes(config::ConfigReader& c, const sensor::NoiseModel& noise) {
  const double gravity = c.number("noise.reference.gravity_mps2", config::Range::closed(0, 1),
                                  "one sd of the reference's gravity, drawn as total field and dip are; with "
                                  "`estimator.parameters`",
                                  0);
  c.require(noise.law == sensor::NoiseLaw::gaussian, "noise.law", "must be \"gaussian\" with estimator.parameters");
  analysis::MultistationRun run;
  run.accelerometer = noise.accelerometer;
  run.magnetometer = noise.magnetometer;
  if (noise.reference != sensor::ReferenceNoise::none)
    run.reference = {gravity, noise.reference_total, noise.reference_dip};
  run.reference_per_station = noise.reference == sensor::ReferenceNoise::per_station;
  return run;
}

}  // namespace surveymc::scenario
