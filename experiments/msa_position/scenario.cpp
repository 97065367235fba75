#include "msa_position/scenario.h"

#include <algorithm>

#include <fmt/format.h>

#include "analysis/msa_event.h"
#include "analysis/msa_prediction.h"
#include "config/meanings.h"
#include "estimate/estimators.h"
#include "estimate/sensitivity.h"
#include "events/linear_event.h"
#include "msa_position/study.h"
#include "scenario/drilling.h"
#include "scenario/scenario.h"

namespace surveymc::studies::msa_position {
namespace {

/// Survey, field, tool, noise and estimator.
void read_model(config::ConfigReader& c, Scenario& s) {
  s.field = scenario::read_field(c);
  s.survey = scenario::read_drilled_survey(c, s.field, s.seed);
  s.survey_place = c.place("survey.file");
  s.errors = scenario::read_magnetometer_errors(c);
  s.spread = scenario::read_tool_spread(c);
  s.noise = scenario::read_noise(c);
}

/// The rest of a config with `[[event]]`.
void read_event_scenario(config::ConfigReader& c, Scenario& s) {
  read_model(c, s);
  c.require(s.noise.law == sensor::NoiseLaw::gaussian, "noise.law",
            "events are regions of normals: must be \"gaussian\" where [[event]] is given");
  s.reference.laws = scenario::read_drawn_laws(c, s.noise);
  if (c.has("disturbance"))
    c.fail("disturbance", "not together with [[event]]: the normals of an event have no time; leave one out");
  s.estimator = scenario::read_estimator(c, analysis::input_errors(s.noise, s.spread, s.field), s.field);
  s.control_variate = false;
  events::refuse_beside_events(c, {"outputs", "tails", "calibration", "prediction"});
  s.event_run = events::read_event_run(c);
  s.annotations = events::read_event_annotations(c, events::linear_formulations(s.reference.laws.any()));
  std::vector<events::EventQuantity> quantities;
  for (std::size_t i = 0; i < analysis::kMsaEventQuantities.size(); ++i)
    quantities.push_back({analysis::kMsaEventQuantities[i], i >= analysis::kMsaInSd ? events::EventLimits::only_above
                                                            : i == analysis::kMsaDistance
                                                                ? events::EventLimits::positive
                                                                : events::EventLimits::either});
  s.events = events::read_events(c, quantities);
  c.finish();
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  if (events::has_events(c)) {
    read_event_scenario(c, s);
    return s;
  }
  s.save_samples =
      static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, config::meaning::kSaveSamples, 0));
  if (c.has("outputs")) {
    const std::vector<std::string> outputs =
        c.texts("outputs", "what is computed: 'parameters', 'position'; without it both");
    for (const std::string& o : outputs)
      c.require(o == "parameters" || o == "position", "outputs", "must be a list of \"parameters\", \"position\"");
    c.require(std::find(outputs.begin(), outputs.end(), "parameters") != outputs.end(), "outputs",
              "must contain \"parameters\", from which all else follows");
    s.with_position = std::find(outputs.begin(), outputs.end(), "position") != outputs.end();
  }
  read_model(c, s);
  s.reference = scenario::read_drawn_reference(c, s.survey, {}, s.field, s.noise);
  if (s.with_position) s.tails = compare::read_tail_rule(c, s.reference.laws);
  s.noise.antithetic = c.boolean("antithetic", config::meaning::kAntithetic, false);
  c.require(!s.noise.antithetic || sensor::symmetric(s.noise.law), "noise.law",
            "must be symmetric about zero (\"gaussian\", \"uniform\") where antithetic = true");
  // A controlled sd is near its prediction whatever is drawn, and that of a disturbance and of laws is in question.
  const bool has_laws = s.reference.laws.any(),
             has_memory = s.reference.disturbance && s.reference.disturbance->has_memory();
  s.control_variate =
      c.boolean("control_variate",
                "tally the first-order prediction of every trial beside it, which makes intervals shorter; not of a "
                "disturbance or of laws of the reference",
                !has_memory && !has_laws);
  c.require(!has_memory || !s.control_variate, "control_variate", "must be false with a [disturbance]");
  c.require(!has_laws || !s.control_variate, "control_variate", "must be false with reference_law");
  c.require(!s.reference.disturbance || !s.noise.antithetic || s.reference.disturbance->symmetric(), "antithetic",
            "a disturbance of kind \"series\" or \"diurnal\" and its negative are not equally likely");
  s.estimator = scenario::read_estimator(c, analysis::input_errors(s.noise, s.spread, s.field), s.field);
  s.assumed_noise = scenario::read_assumed_noise(c, s.estimator.name);
  c.require(s.assumed_noise == sensor::AssumedNoise::constant ||
                !(s.with_position || s.control_variate || s.noise.antithetic),
            "estimator.magnetometer_drawn",
            "weights that are drawn anew have no linear prediction: set outputs = [\"parameters\"] and "
            "control_variate = false, and no antithetic");
  s.orders = scenario::read_msa_orders(c, s.noise, s.estimator.name);
  c.require(!s.orders.any() || s.with_position, "prediction.orders",
            "are predictions of the position, which \"outputs\" leaves out");
  s.verdict = compare::read_verdict_rule(c);
  const std::vector<compare::Row> rows = rows_of(s);
  s.calibration = compare::read_calibration(c, rows);
  compare::require_calibrated_inputs(c, s.calibration, s.estimator, analysis::input_errors(s.noise, s.spread, s.field),
                                     s.errors);
  scenario::require_tables_of(c, s.reference, s.tails, s.orders, s.calibration);
  s.trial_plan = compare::read_trial_plan(c, rows, s.verdict);
  c.require(!s.noise.antithetic || s.trial_plan.trials % 2 == 0,
            s.trial_plan.looks.empty() ? "trials" : "stop.max_trials",
            "must be even where antithetic = true: trials come in pairs");
  s.annotations = compare::Annotations::read(c, compare::annotated_rows(rows, s.calibration));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::msa_position
