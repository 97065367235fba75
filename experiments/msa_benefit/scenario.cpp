#include "msa_benefit/scenario.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "analysis/msa_prediction.h"
#include "analysis/readings_analysis.h"
#include "base/units.h"
#include "estimate/estimators.h"
#include "msa_benefit/study.h"
#include "scenario/reference_field.h"
#include "scenario/scenario.h"
#include "scenario/well_design.h"

namespace surveymc::studies::msa_benefit {
namespace {

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

survey::Survey benefit_well(const analysis::WellDesign& design, double inclination_deg, double azimuth_deg) {
  return analysis::make_well(design, std::clamp(inclination_deg * kDegree, kOffVertical, kPi - kOffVertical),
                             azimuth_deg * kDegree);
}

survey::Survey benefit_well(const Scenario& s, double inclination_deg, double azimuth_deg) {
  return benefit_well(s.well, inclination_deg, azimuth_deg);
}

std::string direction_name(const VerifiedDirection& d) {
  return fmt::format("inclination {:g} azimuth {:g}", d.inclination_deg, d.azimuth_deg);
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.inclination_deg = c.grid("inclination_deg", config::Range::closed(0, 180), "inclinations of the last station");
  s.azimuth_deg = c.grid("azimuth_deg", config::Range::closed(0, 360), "azimuths of the last station, from true north");
  s.field = scenario::read_field(c);
  s.well = scenario::read_well_design(c, seed);
  s.spread = scenario::read_tool_spread(c);
  s.noise = scenario::read_noise(c);
  c.require(sensor::symmetric(s.noise.law), "noise.law", "must be symmetric about zero (\"gaussian\", \"uniform\")");
  s.reference = scenario::read_drawn_reference(c, benefit_well(s, s.inclination_deg.front(), s.azimuth_deg.front()),
                                               {.has_file = false, .is_drawn = c.has("verify")}, s.field, s.noise);
  s.tails = compare::read_tail_rule(c, s.reference.laws);
  s.errors = analysis::input_errors(s.noise, s.spread, s.field);
  s.estimator = scenario::read_estimator(c, s.errors, s.field, analysis::readings_estimators());
  s.estimator.estimated = scenario::read_estimated_parameters(c);
  s.orders = scenario::read_msa_orders(c, s.noise, s.estimator.name);
  s.verdict = compare::read_verdict_rule(c);
  read_verified(c, s);
  const std::vector<compare::Row> rows = rows_of(s);
  s.calibration = compare::read_calibration(c, rows);
  c.require(!s.calibration.on || !s.verify.empty(), "calibration.margin",
            "without [[verify]] there are no trials to count: give a direction, or leave out [calibration]");
  scenario::require_tables_of(c, s.reference, s.tails, s.orders, s.calibration);
  c.require(!s.tails.wanted || s.tails.predicted || !s.verify.empty(), "disturbance.kind",
            "only \"ar1\" is normal: of another disturbance there are no maps of tails, but trials: leave out [tails], "
            "or give [[verify]]");
  // The maps claim a distribution for every estimator; one that weighs is right only about its priors.
  if (estimate::estimator_kind(s.estimator.name).weighs)
    compare::require_calibrated_inputs(c, s.calibration, s.estimator, s.errors, {});
  s.annotations = compare::Annotations::read(c, compare::annotated_rows(rows, s.calibration));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::msa_benefit
