#include "collision/scenario.h"

#include <fmt/format.h>

#include "base/units.h"
#include "config/meanings.h"
#include "proximity/drawn_contact.h"
#include "scenario/reference_laws.h"
#include "scenario/scenario.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::collision {
namespace {

Eigen::Vector3d read_slot_sd(config::ConfigReader& c, const std::string& key) {
  const std::vector<double> sd =
      c.numbers(key, config::Range::non_negative(),
                "one sd of the place of the well: north, east, down; one draw a well", 3, std::vector<double>{0, 0, 0});
  return {sd[0], sd[1], sd[2]};
}

/// The well as surveyed.
proximity::DrawnPath path_of(const scenario::SurveyedWell& well) {
  const proximity::WellPath path = proximity::well_path(well.survey, well.slot);
  proximity::DrawnPath out;
  out.resize(path.stations());
  for (std::size_t k = 0; k < path.stations(); ++k) {
    const proximity::PathPoint p = path.at_station(k);
    out.set(k, p.position, p.tangent, k == 0 ? 0 : path.md(k) - path.md(k - 1));
  }
  return out;
}

/// Stations from which on the wells are apart: the first ones, or of a sidetrack those behind its kick-off where the
/// holes have left each other.
void set_first_stations(config::ConfigReader& entry, const Scenario& s, const scenario::SurveyedWell& offset,
                        WellExtras& extras) {
  const proximity::DrawnPath a = path_of(s.reference), b = path_of(offset);
  const double radii = (s.reference.hole_diameter + offset.hole_diameter) / 2;
  proximity::ContactScratch scratch;
  const auto nearest = [&] { return proximity::nearest_contact(a, extras.first, b, extras.first, kInfinity, scratch); };
  if (offset.kickoff) {
    extras.first = *offset.kickoff + 1;
    while (extras.first + 2 < a.stations() && extras.first + 2 < b.stations() && nearest().distance <= radii)
      ++extras.first;
  }
  const proximity::Contact c = nearest();
  if (c.distance > radii) return;
  const auto md = [](const scenario::SurveyedWell& w, std::size_t leg, double share) {
    const std::vector<double> depths = w.survey.md();
    return depths[leg] + share * (depths[leg + 1] - depths[leg]);
  };
  entry.fail(
      offset.kickoff ? "kickoff_md_m" : "slot_m",
      fmt::format("the holes touch as surveyed: centre lines are {:.4g} m apart at {:.6g} m of the reference and "
                  "{:.6g} m of this well, and the radii add up to {:.4g} m: the probability is 1; must be "
                  "wells that pass each other",
                  c.distance, md(s.reference, c.reference_leg, c.reference_share),
                  md(offset, c.offset_leg, c.offset_share), radii));
}

/// All of both wells is part of the event: a trial in which one has no place would say nothing.
void require_drawable(const Scenario& s) {
  const auto require = [&](const scenario::SurveyedWell& w, const scenario::ToolRuns& tools) {
    if (tools.runs.empty()) return;
    const propagate::WellErrors errors =
        propagate::well_errors(w.survey, w.tvd, tools.runs, w.field, w.latitude, 1, s.vertical);
    scenario::require_drawable(w.model_place, errors, w.survey.stations.size() - 1, w.name);
  };
  require(s.reference, s.reference.tools);
  for (const scenario::SurveyedWell& w : s.offsets) {
    require(w, w.tools);
    require(w, w.tools_from_kickoff);
  }
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  static_cast<scenario::WellPairs&>(s) = scenario::read_well_pairs(c);
  s.seed = seed;
  const Eigen::Vector3d reference_slot_sd = read_slot_sd(c, "survey.slot_sd_m");
  std::vector<config::ConfigReader> entries = c.tables("offset", config::kMeaningElsewhere);
  for (std::size_t o = 0; o < entries.size(); ++o) {
    WellExtras extras;
    if (s.offsets[o].kickoff) {
      entries[o].require(!entries[o].has("slot_sd_m"), "slot_sd_m",
                         "a sidetrack has the slot of the reference, and its error moves both: leave slot_sd_m out");
    } else {
      extras.reference_slot_sd = reference_slot_sd;
      extras.slot_sd = read_slot_sd(entries[o], "slot_sd_m");
    }
    set_first_stations(entries[o], s, s.offsets[o], extras);
    s.extras.push_back(extras);
  }
  for (const scenario::PairFormulation& f : s.formulations)
    c.require(f.kind != scenario::PairFormulation::Kind::zeroed, "separation.formulations",
              "\"zeroed\" is no way to draw wells: must be one by which they share draws");
  scenario::scale_models(c, s);
  s.vertical = c.choice("errors.vertical", {"tilt", "azimuth"}, config::meaning::kErrorsVertical, "tilt") == "azimuth"
                   ? propagate::VerticalRule::azimuth
                   : propagate::VerticalRule::tilt;
  require_drawable(s);
  s.laws = scenario::read_reference_laws(c, {.sizes = false});
  if (const auto& d = s.reference.disturbance) {
    c.require(d->process.kind == disturbance::Kind::ar1, "disturbance.kind",
              "only \"ar1\" is normal, and importance sampling draws normals: must be \"ar1\" here");
    scenario::require_few_disturbed(c, s);
    c.require(!s.laws.any() || !s.laws.random, "reference_law.modes",
              "must be of \"G\", \"W\" where a disturbance takes the place of the errors of mode R");
  }
  std::vector<const scenario::ToolRuns*> tools{&s.reference.tools};
  for (const scenario::SurveyedWell& offset : s.offsets) tools.push_back(&offset.tools);
  scenario::warn_of_idle_laws(c, s.laws, tools);
  s.run = events::read_event_run(c);
  std::vector<compare::Row> rows;
  for (const char* f : kFormulations) rows.push_back({"probability", f, "probability"});
  s.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return s;
}

}  // namespace surveymc::studies::collision
