#include "chained_multistation/scenario.h"

#include <cmath>

#include "base/units.h"
#include "config/meanings.h"
#include "scenario/chain_sizes.h"
#include "scenario/scenario.h"

namespace surveymc::studies::chained_multistation {

const std::vector<std::string>& solver_names() {
  static const std::vector<std::string> names{
      "base", "single", "filter", "filter_independent", "smoother", "smoother_independent"};
  return names;
}

namespace {

/// `[profile]`: a made-up well with inclinations linear along the stations, or `[survey]`: a file's.
void read_profile(config::ConfigReader& c, Scenario& s) {
  if (c.has("survey.file")) {
    for (const char* key : {"stations", "inclination_from_deg", "inclination_to_deg", "magnetic_azimuth_deg"})
      c.require(!c.has(std::string("profile.") + key), std::string("profile.") + key, "not together with survey.file");
    const bool own = c.choice("profile.toolface", {"random", "survey"},
                              "'random': toolfaces are drawn; 'survey': those of the survey", "random") == "survey";
    const survey::Survey survey = scenario::read_survey(c, s.field, own);
    s.truth.random_toolface = !own;
    for (const survey::Station& station : survey.stations)
      s.truth.attitudes.push_back(survey::magnetic_attitude(station, s.field.declination));
    s.md = survey.md();
  } else {
    const int n = static_cast<int>(c.integer("profile.stations", 2, 100'000, "stations of the profile", 18));
    const double from = kDegree * c.number("profile.inclination_from_deg", config::Range::closed(0, 180),
                                           "inclination of the first station; it changes linearly", 10),
                 to = kDegree * c.number("profile.inclination_to_deg", config::Range::closed(0, 180),
                                         "inclination of the last station", 45),
                 azimuth = kDegree * c.number("profile.magnetic_azimuth_deg", config::Range::closed(-360, 360),
                                              "azimuth of the profile", 45),
                 spacing = c.number("profile.spacing_m", config::Range::positive(), "distance of the stations", 30);
    c.choice("profile.toolface", {"random"}, config::kMeaningElsewhere, "random");
    for (int k = 0; k < n; ++k) {
      s.truth.attitudes.push_back({from + (to - from) * k / (n - 1), azimuth, 0});
      s.md.push_back(spacing * k);
    }
  }
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed, Purpose purpose) {
  Scenario s;
  s.seed = seed;
  s.field = scenario::read_field(c);
  s.sizes = scenario::read_chain_sizes(c, s.field, purpose == Purpose::performance);
  read_profile(c, s);
  s.offset_stations =
      static_cast<int>(c.integer("model.offset_stations", 1, 100'000, config::meaning::kOffsetStations, s.stations()));
  const chained::Model m = s.model(chained::ChainReferences::chained);
  s.truth.gravity = m.gravity;
  s.truth.horizontal = m.horizontal;
  s.truth.down = m.down;
  s.truth.first_sd = m.prior_sd;
  s.truth.step_sd = m.link_sd;
  s.truth.noise = m.noise;
  if (c.choice("model.truth_references", {"chained", "constant"},
               "'constant': true reference errors have the sds `random_` and do not walk; what estimators assume stays",
               "chained") == "constant") {
    const std::array<chained::ChainSize, chained::kReferenceStates> references{s.sizes.gravity, s.sizes.field,
                                                                               s.sizes.field};
    for (std::size_t i = 0; i < chained::kReferenceStates; ++i) {
      s.truth.first_sd[i] = references[i].random;
      s.truth.step_sd[i] = 0;
    }
  }
  if (purpose != Purpose::events) s.verdict = compare::read_verdict_rule(c);
  return s;
}

Scenario read_scenario_of_fixed_length(config::ConfigReader& c, random::StudySeed seed) {
  if (c.has("stop"))
    c.fail(
        "stop",
        "only study = \"performance\" ends by its verdicts; the others have a fixed number of trials: give `trials`");
  Scenario s = read_scenario(c, seed, Purpose::chained_only);
  s.trial_plan = compare::read_verdict_plan(c, {}, s.verdict, kTrialLimits);
  return s;
}

}  // namespace surveymc::studies::chained_multistation
