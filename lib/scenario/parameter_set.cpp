#include "scenario/parameter_set.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
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
      "constant errors that are estimated: '6': biases and scales of the magnetometers, as without the key; '9': 6 and "
      "the rotation of the magnetometers; '12': biases and scales of both triads; '15': 12 and the rotation; '18': 15 "
      "and magnetometer axes that are not orthogonal; '21': all; or a list of `abx` to `ayz`");
}

}  // namespace

bool wants_parameter_set(config::ConfigReader& c) {
  return c.has("estimator.parameters") && read_names(c) != std::vector<std::string>{"6"};
}

PerParameter<double> read_priors(config::ConfigReader& c, const PerParameter<double>& fallback) {
  static const PerParameter<std::string> prior_meanings = meanings("prior about 0");
  return read_each(c, "estimator.priors.", config::Range::positive(), prior_meanings, fallback);
}

multistation::FitOptions read_parameter_set(config::ConfigReader& c, const AssumedSizes& truth,
                                            const survey::ReferenceField& field) {
  const std::vector<std::string> names = read_names(c);
  multistation::FitOptions o;
  const bool is_set = names.size() == 1 && multistation::find_parameter(names[0]) < 0;
  o.parameters = c.place("estimator.parameters").with_place([&] {
    return is_set ? multistation::ParameterSet::named(names[0]) : multistation::ParameterSet::of(names);
  });
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
  o.total = field.total;
  o.dip = field.dip;
  o.reference.gravity =
      c.number("estimator.reference.gravity_mps2", config::Range::closed(0, 1),
               "one sd that the estimator assumes of the reference's gravity", truth.reference.gravity);
  o.reference.total = c.number("estimator.reference.total_nT", config::Range::closed(0, 1e5), config::kMeaningElsewhere,
                               truth.reference.total);
  o.reference.dip = c.number("estimator.reference.dip_deg", config::Range::closed(0, 45), config::kMeaningElsewhere,
                             truth.reference.dip / kDegree) *
                    kDegree;
  o.max_iterations = static_cast<int>(c.integer("estimator.max_iterations", 1, 10000, config::kMeaningElsewhere, 200));
  return o;
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
