#include "msa_position/scenario.h"

#include <algorithm>

#include <fmt/format.h>

#include "analysis/msa_event.h"
#include "analysis/msa_prediction.h"
#include "config/meanings.h"
#include "estimate/estimators.h"
#include "estimate/sensitivity.h"
#include "msa_position/study.h"
#include "scenario/disturbance.h"
#include "scenario/drilling.h"
#include "scenario/reference_laws.h"
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

/// Laws of the reference, and the sd that follow from its sizes.
void read_laws(config::ConfigReader& c, Scenario& s) {
  s.laws = scenario::read_reference_laws(c, {.declination = false, .modes = false, .terms = false});
  c.require(!s.laws.any() || s.noise.reference != sensor::ReferenceNoise::none, "reference_law",
            "is of a reference that is drawn: give noise.reference.per");
  s.noise.reference_total *= s.laws.of(random::ReferenceElement::total).sd;
  s.noise.reference_dip *= s.laws.of(random::ReferenceElement::dip).sd;
}

/// The errors of the reference that are new at every station become a function of time.
void read_disturbance(config::ConfigReader& c, Scenario& s) {
  s.disturbance = scenario::read_disturbance(c, s.survey);
  if (!s.disturbance) return;
  const disturbance::Disturbance& d = *s.disturbance;
  c.require(s.noise.reference == sensor::ReferenceNoise::per_station, "disturbance.kind",
            "takes the place of the reference's errors at every station: noise.reference.per must be \"station\"");
  constexpr std::array<disturbance::Element, 2> kElements{disturbance::kTotal, disturbance::kDip};
  std::vector<disturbance::StationDraw> draws;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(s.survey.size()); ++k)
    for (std::uint32_t i = 0; i < kElements.size(); ++i)
      draws.push_back({k, kElements[i], i, random::Channel::reference_field, 2 * k + i});
  s.disturbed = std::make_shared<const disturbance::StationDisturbance>(d, s.field, draws);
  const std::array<double*, 2> sizes{&s.noise.reference_total, &s.noise.reference_dip};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double own = s.disturbed->sizes()[kElements[i]];
    if (!d.match_variance) *sizes[i] = own;
    c.require(d.keeps_normals() || *sizes[i] == 0 || own > 0, "disturbance.match",
              fmt::format("the disturbance does not change the {}, which noise.reference has",
                          random::reference_elements()[kElements[i]]));
    *sizes[i] *= d.scale;
  }
}

/// The rest of a config with `[[event]]`.
void read_event_scenario(config::ConfigReader& c, Scenario& s) {
  read_model(c, s);
  c.require(s.noise.law == sensor::NoiseLaw::gaussian, "noise.law",
            "events are regions of normals: must be \"gaussian\" where [[event]] is given");
  read_laws(c, s);
  if (c.has("disturbance"))
    c.fail("disturbance", "not together with [[event]]: the normals of an event have no time; leave one out");
  s.estimator = scenario::read_estimator(c, analysis::input_errors(s.noise, s.spread, s.field), s.field);
  s.control_variate = false;
  s.event_run = events::read_event_run(c);
  s.annotations = events::read_event_annotations(c, {"first_order", "normal"});
  std::vector<events::EventQuantity> quantities;
  for (const char* q : analysis::kMsaEventQuantities) quantities.push_back({q});
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
  read_laws(c, s);
  if (s.with_position) s.tails = compare::read_tail_rule(c, s.laws);
  read_disturbance(c, s);
  s.noise.antithetic = c.boolean("antithetic", config::meaning::kAntithetic, false);
  c.require(!s.noise.antithetic || sensor::symmetric(s.noise.law), "noise.law",
            "must be symmetric about zero (\"gaussian\", \"uniform\") where antithetic = true");
  // A controlled sd is near its prediction whatever is drawn, and that of a disturbance and of laws is in question.
  const bool has_memory = s.disturbance && s.disturbance->has_memory();
  s.control_variate =
      c.boolean("control_variate",
                "tally the first-order prediction of every trial beside it, which makes intervals shorter; not of a "
                "disturbance or of laws of the reference",
                !has_memory && !s.laws.any());
  c.require(!has_memory || !s.control_variate, "control_variate", "must be false with a [disturbance]");
  c.require(!s.laws.any() || !s.control_variate, "control_variate", "must be false with reference_law");
  c.require(!s.disturbance || !s.noise.antithetic || s.disturbance->symmetric(), "antithetic",
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
  c.require(!s.laws.any() || !s.orders.any(), "prediction.orders",
            "are of normal errors: not together with reference_law");
  c.require(!s.disturbance || !s.laws.any(), "disturbance.kind", "not together with reference_law");
  c.require(!s.tails.wanted || !s.disturbance || s.disturbance->process.kind == disturbance::Kind::ar1,
            "disturbance.kind", "only \"ar1\" is normal: of another disturbance the table `tails` has no prediction");
  c.require(!s.orders.any() || !s.disturbance, "prediction.orders", "beyond \"first\" have no [disturbance]");
  s.verdict = compare::read_verdict_rule(c);
  const std::vector<compare::Row> rows = rows_of(s);
  s.calibration = compare::read_calibration(c, rows);
  compare::require_calibrated_inputs(c, s.calibration, s.estimator, analysis::input_errors(s.noise, s.spread, s.field),
                                     s.errors);
  c.require(!s.laws.any() || !s.calibration.on, "calibration",
            "is of a claimed normal distribution: not together with reference_law");
  s.trial_plan = compare::read_trial_plan(c, rows, s.verdict);
  c.require(!s.noise.antithetic || s.trial_plan.trials % 2 == 0,
            s.trial_plan.looks.empty() ? "trials" : "stop.max_trials",
            "must be even where antithetic = true: trials come in pairs");
  s.annotations = compare::Annotations::read(c, compare::annotated_rows(rows, s.calibration));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::msa_position
