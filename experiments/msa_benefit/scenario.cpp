#include "msa_benefit/scenario.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "analysis/msa_prediction.h"
#include "analysis/readings_analysis.h"
#include "base/units.h"
#include "config/suggest.h"
#include "estimate/estimators.h"
#include "estimate/observability.h"
#include "msa_benefit/study.h"
#include "scenario/reference_field.h"
#include "scenario/scenario.h"

namespace surveymc::studies::msa_benefit {
namespace {

analysis::WellDesign read_well(config::ConfigReader& c, random::StudySeed seed) {
  analysis::WellDesign w;
  w.seed = seed;
  w.kind = c.choice("well.kind", {"straight", "building"},
                    "'straight': one direction; 'building': vertical, then at the build rate to the last station") ==
                   "building"
               ? analysis::WellKind::building
               : analysis::WellKind::straight;
  w.stations = static_cast<int>(c.integer("well.stations", 2, 10000, "stations that MSA uses"));
  w.spacing = c.number("well.spacing_m", config::Range{0, 1000, true, false},
                       "distance of the stations; random errors depend on it", 30);
  // Given but unused values stay allowed, so that `kind` can be swept.
  const double per_30m =
      c.number("well.build_rate_deg_per_30m", config::Range{0, 90, true, false}, "build rate of the building well", 3);
  if (w.kind == analysis::WellKind::building) {
    w.build_rate = per_30m * kDegree / 30;
    c.require(w.build_rate * w.spacing <= kPi / 2, "well.build_rate_deg_per_30m",
              fmt::format("with well.spacing_m = {} there is more than 90 deg between two stations", w.spacing));
  }
  const std::string toolface = c.choice(
      "well.toolface", {"even", "random", "constant"},
      "'even': turns by 137.50776 deg a station; 'random': by the seed, the same for all directions; 'constant'",
      "even");
  w.toolface = toolface == "random"     ? analysis::ToolfaceSequence::random
               : toolface == "constant" ? analysis::ToolfaceSequence::constant
                                        : analysis::ToolfaceSequence::even;
  if (w.toolface == analysis::ToolfaceSequence::random && !c.has("seed"))
    c.fail("well.toolface", "\"random\" is drawn by the config's seed: give it, in the file's first lines");
  return w;
}

std::array<bool, 6> read_estimated(config::ConfigReader& c) {
  std::array<bool, 6> estimated{true, true, true, true, true, true};
  if (!c.has("estimator.estimated")) return estimated;
  estimated.fill(false);
  for (const std::string& name : c.texts("estimator.estimated",
                                         "parameters that are estimated, of gain_x to bias_z: the others are taken as "
                                         "1 and 0, whatever they are; without it all six")) {
    const auto* at = std::find(estimate::kParameterNames.begin(), estimate::kParameterNames.end(), name);
    if (at == estimate::kParameterNames.end())
      c.fail("estimator.estimated",
             config::none_of(name, {estimate::kParameterNames.begin(), estimate::kParameterNames.end()}));
    bool& flag = estimated[static_cast<std::size_t>(at - estimate::kParameterNames.begin())];
    c.require(!flag, "estimator.estimated", "\"" + name + "\" is there twice");
    flag = true;
  }
  return estimated;
}

void read_verified(config::ConfigReader& c, Scenario& s) {
  for (config::ConfigReader& entry : c.tables("verify", "directions of the map in which trials are drawn, too")) {
    VerifiedDirection v{
        entry.number("inclination_deg", config::Range::closed(0, 180), "inclination of the last station"),
        entry.number("azimuth_deg", config::Range::closed(0, 360), "azimuth of the last station")};
    // A vertical hole has nothing to compare: its azimuth is that of the tool.
    entry.require(v.inclination_deg >= 1 && v.inclination_deg <= 179, "inclination_deg",
                  "must be in [1, 179]: closer to the vertical an azimuth is not nearly linear in the readings");
    v.place = entry.place("inclination_deg");
    s.verify.push_back(std::move(v));
  }
  const std::array<bool, 2> given{c.has("trials"), c.has("stop")};
  if (s.verify.empty()) {
    for (std::size_t i = 0; i < given.size(); ++i)
      if (given[i]) c.fail(i == 0 ? "trials" : "stop", "without [[verify]] there is nothing to simulate: leave it out");
    return;
  }
  s.trial_plan = compare::read_trial_plan(c, rows_of(s), s.verdict);
}

constexpr double kOffVertical = 1e-6;  // rad

}  // namespace

bool is_vertical(double inclination_deg) {
  const double inclination = inclination_deg * kDegree;
  return std::min(inclination, kPi - inclination) <= kOffVertical;
}

survey::Survey benefit_well(const Scenario& s, double inclination_deg, double azimuth_deg) {
  return analysis::make_well(s.well, std::clamp(inclination_deg * kDegree, kOffVertical, kPi - kOffVertical),
                             azimuth_deg * kDegree);
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.inclination_deg = c.grid("inclination_deg", config::Range::closed(0, 180), "inclinations of the last station");
  s.azimuth_deg = c.grid("azimuth_deg", config::Range::closed(0, 360), "azimuths of the last station, from true north");
  s.field = scenario::read_field(c);
  s.well = read_well(c, seed);
  s.spread = scenario::read_tool_spread(c);
  s.noise = scenario::read_noise(c);
  c.require(sensor::symmetric(s.noise.law), "noise.law", "must be symmetric about zero (\"gaussian\", \"uniform\")");
  s.errors = analysis::input_errors(s.noise, s.spread, s.field);
  s.estimator = scenario::read_estimator(c, s.errors, s.field, analysis::readings_estimators());
  s.estimator.estimated = read_estimated(c);
  s.verdict = compare::read_verdict_rule(c);
  read_verified(c, s);
  const std::vector<compare::Row> rows = rows_of(s);
  s.calibration = compare::read_calibration(c, rows);
  c.require(!s.calibration.on || !s.verify.empty(), "calibration.margin",
            "without [[verify]] there are no trials to count: give a direction, or leave out [calibration]");
  // The maps claim a distribution for every estimator; one that weighs is right only about its priors.
  if (estimate::estimator_kind(s.estimator.name).weighs)
    compare::require_calibrated_inputs(c, s.calibration, s.estimator, s.errors, {});
  s.annotations = compare::Annotations::read(c, compare::annotated_rows(rows, s.calibration));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::msa_benefit
