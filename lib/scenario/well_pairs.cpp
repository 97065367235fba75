#include "scenario/well_pairs.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "config/meanings.h"
#include "config/suggest.h"
#include "propagate/disturbed_errors.h"
#include "scenario/disturbance.h"
#include "scenario/input_remarks.h"
#include "scenario/scenario.h"
#include "scenario/survey_spacing.h"
#include "survey/minimum_curvature.h"
#include "survey/survey.h"

namespace surveymc::scenario {
namespace {

using error_model::PropagationMode;
using proximity::Interpolation;
using proximity::JoiningSource;
using proximity::Sharing;
using Formulation = PairFormulation;
using Well = SurveyedWell;
using Scenario = WellPairs;

constexpr double kInch = 0.0254;
const config::Range kPlace = config::Range::closed(-1e7, 1e7);  // m: farther apart no two wells are
constexpr double kSameAngle = 1e-9;                             // rad

/// `<prefix>_in` or `<prefix>_m`; without one, `fallback`, or an error if that is 0.
double read_hole_diameter(config::ConfigReader& c, const std::string& prefix, double fallback) {
  const std::string inches = prefix + "_in", metres = prefix + "_m";
  if (c.has(inches) && c.has(metres)) c.fail(inches, "not together with " + metres);
  const bool is_metres = c.has(metres) || (fallback == 0 && !c.has(inches));
  if (!is_metres && !c.has(inches)) return fallback;
  const std::string& key = is_metres ? metres : inches;
  const double diameter =
      (is_metres ? 1 : kInch) *
      c.number(key, config::Range::positive(), "diameter of the hole; an offset without it has that of the reference");
  constexpr double kWidest = 1.5;
  if (diameter > kWidest)
    c.warn(key, fmt::format("a hole of {:.4g} m is wider than any that is drilled for a well", diameter),
           "is the unit right?");
  return diameter;
}

Eigen::Vector3d vector_of(const std::vector<double>& x) { return {x[0], x[1], x[2]}; }

/// `[offset.field]`: that of a place, or total field and dip together; what else is not given is the reference's.
survey::ReferenceField read_offset_field(config::ConfigReader& c, const survey::ReferenceField& reference) {
  if (!c.has("field")) return reference;
  if (c.has("field.model")) return read_field(c);
  survey::ReferenceField f = reference;
  if (c.has("field.total_nT") || c.has("field.dip_deg")) {
    f.total = c.number("field.total_nT", config::Range::closed(1e3, 1e6), config::meaning::kTotalField);
    f.dip = c.number("field.dip_deg", config::Range::closed(-90, 90), config::meaning::kDip) * kDegree;
    c.require(std::abs(f.dip) < 89.99 * kDegree, "field.dip_deg",
              "the horizontal field vanishes: there is no magnetic azimuth");
  }
  const auto angle = [&](const char* key, std::string_view meaning, double& x) {
    if (c.has(key)) x = c.number(key, config::Range::closed(-180, 180), meaning) * kDegree;
  };
  angle("field.declination_deg", config::meaning::kDeclination, f.declination);
  if (c.has("field.grid"))
    f.convergence = read_convergence(c);
  else
    angle("field.convergence_deg", config::meaning::kConvergence, f.convergence);
  if (c.has("field.gravity_mps2"))
    f.gravity = c.number("field.gravity_mps2", config::Range::closed(9.7, 9.9), config::meaning::kGravity);
  return f;
}

survey::Survey read_offset_survey(config::ConfigReader& c, const survey::ReferenceField& field,
                                  config::AzimuthReference north_of_reference) {
  config::SurveyConventions conventions;
  const config::InputTable table = read_offset_table(c);
  if (north_of_reference != config::AzimuthReference::true_north &&
      config::named_north(table) == config::NamedNorth::none && !c.is_text("azimuth_reference"))
    c.fail("azimuth_reference", fmt::format("missing: azimuths of the reference are from {} north; say from which "
                                            "north those of this survey are",
                                            north_name(north_of_reference)));
  conventions.azimuth_reference = read_azimuth_reference(c, table, "azimuth_reference");
  conventions.declination = field.declination;
  conventions.convergence = field.convergence;
  survey::Survey survey = config::survey_from_table(table, conventions, false);
  warn_of_north(c, table, conventions);
  remark_on_survey(c, table, survey, conventions, "unusual");
  return read_interpolation(c, "interpolate_m", survey, false);
}

/// The reference's tools at the same depths, as far as the survey goes.
ToolRuns inherited_tools(const ToolRuns& reference, const survey::Survey& survey) {
  ToolRuns out;
  for (std::size_t r = 0; r < reference.runs.size(); ++r) {
    const auto first = std::find_if(survey.stations.begin() + 1, survey.stations.end(), [&](const survey::Station& s) {
      return r == 0 || survey::is_deeper(s.md, reference.from_md[r]);
    });
    if (first == survey.stations.end()) break;
    const int index = static_cast<int>(first - survey.stations.begin());
    if (!out.runs.empty() && out.runs.back().first == index) {  // the run before has no station here
      out.runs.pop_back();
      out.model_names.pop_back();
      out.from_md.pop_back();
    }
    out.runs.push_back({out.runs.empty() ? 1 : index, reference.runs[r].model});
    out.model_names.push_back(reference.model_names[r]);
    out.from_md.push_back(r == 0 ? survey.stations.front().md : reference.from_md[r]);
  }
  return out;
}

bool has_own_tools(const config::ConfigReader& c) { return c.has("error_model") || c.has("leg"); }

/// Tools of a sidetrack: those of the well down to the kick-off, then a run of its own and its legs; without an
/// `error_model` or legs, with the tools that the reference has at those depths.
ToolRuns sidetrack_tools(config::ConfigReader& c, const ToolRuns& reference, const survey::Survey& survey,
                         std::size_t kickoff) {
  const ToolRuns there = inherited_tools(reference, survey);
  const int first = static_cast<int>(kickoff) + 1;
  ToolRuns out;
  const auto add = [&](const ToolRuns& from, std::size_t r) {
    out.runs.push_back(from.runs[r]);
    out.model_names.push_back(from.model_names[r]);
    out.from_md.push_back(from.from_md[r]);
  };
  std::size_t below = 0;  // the run of the first station below the kick-off
  for (std::size_t r = 0; r < there.runs.size() && there.runs[r].first <= first; ++r) {
    below = r;
    if (there.runs[r].first < first) add(there, r);
  }
  const bool has_own = has_own_tools(c);
  const ToolRuns own =
      has_own ? read_tool_runs(c, survey, NamedErrorModel{there.model_names[below], there.runs[below].model}) : there;
  for (std::size_t r = has_own ? 0 : below, begin = r; r < own.runs.size(); ++r) {
    if (r > begin && own.runs[r].first <= first)
      c.fail("kickoff_md_m", "a [[offset.leg]] begins at or above it: down to it, the tools are the reference's");
    add(own, r);
    if (r > begin) continue;
    out.runs.back().first = first;
    out.from_md.back() = survey.stations[kickoff].md;
  }
  return out;
}

bool is_same_station(const survey::Station& a, const survey::Station& b) {
  const bool is_vertical = std::max(a.inclination, b.inclination) < error_model::kVerticalLimit;
  return survey::is_same_depth(a.md, b.md) && std::abs(a.inclination - b.inclination) < kSameAngle &&
         (is_vertical || std::abs(std::remainder(a.azimuth - b.azimuth, 2 * kPi)) < kSameAngle);
}

std::size_t read_kickoff(config::ConfigReader& c, const Well& offset, const Well& reference) {
  const double md = c.number("kickoff_md_m", config::Range::non_negative(),
                             "of a sidetrack: measured depth of the station where it leaves the reference");
  const auto find = [&](const survey::Survey& s, const char* which) {
    if (const auto k = survey::station_at(s, md)) return *k;
    c.fail("kickoff_md_m", fmt::format("{} has no station at this depth", which));
  };
  const std::size_t own = find(offset.survey, "the survey of the sidetrack");
  const std::size_t of_reference = find(reference.survey, "the survey of the reference");
  for (std::size_t k = 0; k <= std::min(own, of_reference); ++k)
    if (!is_same_station(offset.survey.stations[k], reference.survey.stations[k]))
      c.fail("kickoff_md_m",
             fmt::format("down to it, both surveys must be equal: station {} is at md {:.10g} m, inclination {:.10g}, "
                         "azimuth {:.10g} deg here, and at {:.10g} m, {:.10g}, {:.10g} deg in the reference",
                         k + 1, offset.survey.stations[k].md, offset.survey.stations[k].inclination / kDegree,
                         offset.survey.stations[k].azimuth / kDegree, reference.survey.stations[k].md,
                         reference.survey.stations[k].inclination / kDegree,
                         reference.survey.stations[k].azimuth / kDegree));
  c.require(own == of_reference, "kickoff_md_m", "down to it, both surveys must have the same stations");
  c.require(own > 0, "kickoff_md_m", "must be below the tie-on");
  c.require(own + 1 < offset.survey.stations.size() && own + 1 < reference.survey.stations.size(), "kickoff_md_m",
            "both wells must have stations below it");
  c.require(offset.slot == reference.slot, "kickoff_md_m", "a sidetrack has the slot of the reference");
  return own;
}

/// The stations down to the kick-off were measured once, in the field of the reference, and a well has one field.
void require_field_of_reference(const config::ConfigReader& c, const Well& w, const Well& reference) {
  const survey::ReferenceField &a = w.field, &b = reference.field;
  const bool is_same = a.total == b.total && a.dip == b.dip && a.declination == b.declination &&
                       a.gravity == b.gravity && (std::isnan(reference.latitude) || w.latitude == reference.latitude);
  c.require(
      is_same, "field",
      "differs from that of the reference, in which the stations down to the kick-off were measured: leave it out "
      "of a sidetrack");
}

/// Slots in the frame of true north. `turn`: the convergence, where they are differences of map coordinates.
Eigen::Vector3d read_slot(config::ConfigReader& c, const std::string& key, double turn,
                          const std::optional<std::vector<double>>& missing = std::nullopt) {
  const Eigen::Vector3d slot =
      vector_of(c.numbers(key, kPlace, "position of the first station: true north, east, down", 3, missing));
  if (turn == 0) return slot;
  return {slot.x() * std::cos(turn) - slot.y() * std::sin(turn), slot.x() * std::sin(turn) + slot.y() * std::cos(turn),
          slot.z()};
}

/// A slot may be meant in true north, as it is taken, or in the map that azimuths are counted in. Who wrote all
/// azimuths from grid north will have slots of the map: asked for, where it matters.
void ask_for_north_of_slots(config::ConfigReader& c, const WellPairs& s, config::AzimuthReference north) {
  constexpr double kMatters = 5;  // m; hardly more than the accuracy of slots in older records
  if (c.has("survey.slot_reference")) return;
  double moved = 0;
  for (const Well& w : s.offsets)
    moved = std::max(moved, (w.slot - s.reference.slot).head<2>().norm() * 2 *
                                std::abs(std::sin(s.reference.field.convergence / 2)));
  constexpr double kTold = 0.01;  // m
  if (moved < kTold) return;
  const std::string text = fmt::format(
      "slots may be north and east of true north or of the map, which the convergence of {:.4g} deg turns by up to "
      "{:.3g} m",
      s.reference.field.convergence / kDegree, moved);
  constexpr const char* kWayOut = "survey.slot_reference = \"true\" or \"grid\" says which";
  if (north == config::AzimuthReference::grid && moved > kMatters)
    c.fail("survey.slot_reference", fmt::format("missing: {}: {}", text, kWayOut));
  c.warn("survey.slot_reference", text + ": taken as true", kWayOut);
}

Well read_offset(config::ConfigReader& c, const Well& reference, config::AzimuthReference north, double turn) {
  Well w;
  w.name = c.text("name", "name of the offset, once");
  w.model_place = c.has("error_model") ? c.place("error_model") : reference.model_place;
  w.field = read_offset_field(c, reference.field);
  w.survey = read_offset_survey(c, w.field, north);
  const bool is_sidetrack = c.has("kickoff_md_m");
  w.slot = is_sidetrack && !c.has("slot_m") ? reference.slot : read_slot(c, "slot_m", turn);
  w.hole_diameter = read_hole_diameter(c, "hole_diameter", reference.hole_diameter);
  if (is_sidetrack) {
    w.kickoff = read_kickoff(c, w, reference);
    // One measurement has one place and one high side, also where the hole is vertical and another azimuth is listed.
    std::copy_n(reference.survey.stations.begin(), *w.kickoff + 1, w.survey.stations.begin());
    w.tools_from_kickoff = sidetrack_tools(c, reference.tools, w.survey, *w.kickoff);
    w.tools = has_own_tools(c) ? w.tools_from_kickoff : inherited_tools(reference.tools, w.survey);
  } else if (has_own_tools(c)) {
    w.tools = read_tool_runs(c, w.survey,
                             NamedErrorModel{reference.tools.model_names.front(), reference.tools.runs.front().model});
  } else {
    w.tools = inherited_tools(reference.tools, w.survey);
  }
  const bool has_latitude = c.has("field.latitude_deg") || std::isnan(reference.latitude);
  w.latitude = has_latitude ? read_latitude(c, models_of(w.tools)) : reference.latitude;
  if (is_sidetrack) require_field_of_reference(c, w, reference);
  w.tvd = true_vertical_depths_of(c.csv("file", config::kMeaningElsewhere), w.survey);
  if (is_sidetrack) std::copy_n(reference.tvd.begin(), *w.kickoff + 1, w.tvd.begin());
  const bool is_identical = w.slot == reference.slot && std::equal(w.survey.stations.begin(), w.survey.stations.end(),
                                                                   reference.survey.stations.begin(),
                                                                   reference.survey.stations.end(), is_same_station);
  c.require(!is_identical, "file",
            "is the reference itself, station by station and with its slot: the distance would be 0 everywhere");
  return w;
}

Formulation read_list(config::ConfigReader& c) {
  Formulation f;
  f.name = c.text("name", "name of this formulation, for tables");
  f.sharing = Sharing::listed;
  f.codes = c.texts("codes", "codes of the sources that the wells share, of mode W or G");
  return f;
}

Formulation formulation_of(const config::ConfigReader& c, const std::string& word) {
  if (word == "independent") return {word};
  if (word == "geomagnetic") return {word, Formulation::Kind::sharing, Sharing::geomagnetic};
  if (word == "global") return {word, Formulation::Kind::sharing, Sharing::global};
  if (word == "pad") return {word, Formulation::Kind::sharing, Sharing::pad};
  if (word == "shared") return {word, Formulation::Kind::shared_hole};
  if (word == "zeroed") return {word, Formulation::Kind::zeroed};
  c.fail(
      "separation.formulations",
      fmt::format("\"{}\" is none of \"independent\", \"geomagnetic\", \"global\", \"pad\", \"shared\", \"zeroed\" "
                  "and {{ name, codes }}{}",
                  word, config::suggestion(word, {"independent", "geomagnetic", "global", "pad", "shared", "zeroed"})));
}

using CodeAndMode = std::pair<std::string, PropagationMode>;

/// Code and mode of all terms of a well.
std::set<CodeAndMode> sources_of(const Well& w, const Formulation* sharing = nullptr) {
  std::set<CodeAndMode> out;
  for (const propagate::ToolRun& run : w.tools.runs)
    for (const error_model::Term& t : run.model->terms) {
      if (sharing == nullptr ||
          (error_model::joins_legs(t.mode) &&
           proximity::is_shared(sharing->sharing, sharing->codes, {t.code, t.mode, t.function->name})))
        out.insert({t.code, t.mode});
    }
  return out;
}

void check_list(config::ConfigReader& c, const Formulation& f, const Scenario& s) {
  std::set<CodeAndMode> all = sources_of(s.reference);
  for (const Well& w : s.offsets) all.merge(sources_of(w));
  for (const std::string& code : f.codes) {
    bool is_known = false, joins = false;
    for (const auto& [known, mode] : all)
      if (known == code) {
        is_known = true;
        joins = joins || error_model::joins_legs(mode);
      }
    c.require(is_known, "codes", fmt::format("no model here has the code \"{}\"", code));
    c.require(joins, "codes",
              fmt::format("\"{}\" is a source of mode R or S: two wells never share it (a sidetrack does, by "
                          "\"shared\")",
                          code));
  }
}

/// Warns of sources that a formulation would share if both wells had them.
void warn_of_lacking(config::ConfigReader& c, const Formulation& f, const Scenario& s) {
  if (f.kind != Formulation::Kind::sharing || f.sharing == Sharing::none) return;
  const std::set<CodeAndMode> reference = sources_of(s.reference, &f);
  std::set<std::string> told;
  for (const Well& w : s.offsets) {
    const std::set<CodeAndMode> offset = sources_of(w, &f);
    const auto lacking = [](const std::set<CodeAndMode>& a, const std::set<CodeAndMode>& b) {
      std::vector<std::string> codes;
      for (const CodeAndMode& x : a)
        if (b.count(x) == 0) codes.push_back(x.first);
      return codes;
    };
    const std::vector<std::string> of_reference = lacking(reference, offset), of_offset = lacking(offset, reference);
    const bool shares_none = of_reference.size() == reference.size();
    if (of_reference.empty() && of_offset.empty() && !shares_none) continue;
    std::string text = fmt::format("\"{}\" of {}: ", f.name, w.name);
    text += shares_none ? "the wells share nothing, and their results are those of \"independent\": "
                        : "errors that only one of the wells has are not shared: ";
    if (!of_reference.empty()) text += fmt::format("only the reference has {}; ", fmt::join(of_reference, ", "));
    if (!of_offset.empty()) text += fmt::format("only the offset has {}; ", fmt::join(of_offset, ", "));
    text.resize(text.size() - 2);  // "; " or ": "
    const char* way_out = of_reference.empty() && of_offset.empty()
                              ? "neither error model has such an error"
                              : "tools of one kind, with one error model, have their errors in common";
    if (told.insert(text).second) c.warn("separation.formulations", text, way_out);
  }
}

void read_formulations(config::ConfigReader& c, Scenario& s) {
  std::set<std::string> names;
  const bool has_sidetrack =
      std::any_of(s.offsets.begin(), s.offsets.end(), [](const Well& w) { return w.kickoff.has_value(); });
  for (auto& entry :
       c.texts_or_tables("separation.formulations",
                         "what the wells share: 'independent' nothing, 'geomagnetic' the reference field, 'global' all "
                         "of mode G, 'pad' those of G and W, or { name, codes } sources of these codes",
                         {"independent", "geomagnetic"})) {
    if (const std::string* word = std::get_if<std::string>(&entry)) {
      s.formulations.push_back(formulation_of(c, *word));
    } else {
      config::ConfigReader& list = std::get<config::ConfigReader>(entry);
      s.formulations.push_back(read_list(list));
      check_list(list, s.formulations.back(), s);
    }
    const Formulation& f = s.formulations.back();
    c.require(names.insert(f.name).second, "separation.formulations",
              fmt::format("two formulations have the name \"{}\"", f.name));
    c.require(f.kind == Formulation::Kind::sharing || has_sidetrack, "separation.formulations",
              fmt::format("\"{}\" is for sidetracks: no [[offset]] has a kickoff_md_m", f.name));
    warn_of_lacking(c, f, s);
  }
}

propagate::StationEffects all_effects(const Well& w, const scenario::ToolRuns& tools) {
  propagate::StationEffects effects;
  propagate::tool_covariances(w.survey, w.tvd, tools.runs, w.field, w.latitude, propagate::SourceDetail::none,
                              &effects);
  return effects;
}

std::shared_ptr<const proximity::PositionErrors> errors_of(const Well& w, Interpolation interpolation,
                                                           std::vector<propagate::NonFiniteTerm>& non_finite) {
  propagate::ToolCovariances covariances;
  auto errors = std::make_shared<proximity::PositionErrors>(
      proximity::position_errors(w.survey, w.tvd, w.tools.runs, w.field, w.latitude, interpolation, &covariances,
                                 w.disturbance ? &*w.disturbance : nullptr));
  non_finite = covariances.non_finite;
  return errors;
}

/// In the models of all wells. After everything that reads these: a disturbed model is not disturbed again.
void read_disturbances(config::ConfigReader& c, std::vector<config::ConfigReader>& offsets, Scenario& s) {
  const auto disturb = [&](Well& w, config::ConfigReader* offset) {
    w.disturbance = read_disturbance(c, w.survey, {.offset = offset, .name = w.name, .is_drawn = false});
    if (!w.disturbance) return;
    c.require(
        !w.kickoff, "disturbance.kind",
        fmt::format("\"{}\" is a sidetrack, and drilled at another time than the hole that it leaves: not together "
                    "with kickoff_md_m",
                    w.name));
    w.tools.runs = c.place("disturbance.kind").with_place([&] {
      return propagate::disturbed_runs(w.tools.runs, *w.disturbance, w.field);
    });
  };
  disturb(s.reference, nullptr);
  for (std::size_t i = 0; i < offsets.size(); ++i) disturb(s.offsets[i], &offsets[i]);
}

/// `error_model.outside_range` of the config holds for all wells.
void refuse_outside_range(config::ConfigReader& c, const Well& w) {
  if (c.choice("error_model.outside_range", {"mark", "refuse"}, config::meaning::kOutsideRange, "mark") == "refuse")
    read_outside_range(c, w.survey, w.tools.runs, propagate::tool_validity(w.survey, w.tools.runs, w.field, w.latitude),
                       w.name);
}

}  // namespace

WellPairs read_well_pairs(config::ConfigReader& c) {
  WellPairs s;
  Well& r = s.reference;
  r.name = "reference";
  r.field = read_field(c);
  r.survey = read_survey(c, r.field, false);
  const config::AzimuthReference north =
      c.has("survey.plan")
          ? config::AzimuthReference::true_north
          : read_azimuth_reference(c, c.csv("survey.file", config::kMeaningElsewhere), "survey.azimuth_reference");
  // By has(), so that no default of it is written into every config.
  const bool on_map = c.has("survey.slot_reference") &&
                      c.choice("survey.slot_reference", {"true", "grid"},
                               "north of all slots: 'grid': they are differences of map coordinates, and are turned by "
                               "the convergence. Must be given where azimuths of the reference are from grid north and "
                               "the turn moves a slot by more than 5 m") == "grid";
  const double turn = on_map ? r.field.convergence : 0;
  r.slot = read_slot(c, "survey.slot_m", turn, std::vector<double>{0, 0, 0});
  r.hole_diameter = read_hole_diameter(c, "survey.hole_diameter", 0);
  r.tools = read_tool_runs(c, r.survey);
  r.model_place = c.place("error_model");
  r.latitude = read_latitude(c, models_of(r.tools));
  r.tvd = read_true_vertical_depths(c, r.survey);
  refuse_outside_range(c, r);
  warn_of_idle_terms(c, r.tools, r.field, r.latitude);
  std::vector<config::ConfigReader> offsets = c.tables("offset", "wells to compare with the reference");
  if (offsets.empty()) c.fail("offset", "missing: there must be at least one [[offset]]");
  std::set<std::string> names{r.name};
  bool any_grid = north == config::AzimuthReference::grid;
  const auto uses_grid = [](config::ConfigReader& entry) {
    return read_azimuth_reference(entry, entry.csv("file", config::kMeaningElsewhere), "azimuth_reference") ==
           config::AzimuthReference::grid;
  };
  for (config::ConfigReader& entry : offsets) {
    s.offsets.push_back(read_offset(entry, r, north, turn));
    refuse_outside_range(c, s.offsets.back());
    warn_of_idle_terms(c, s.offsets.back().tools, s.offsets.back().field, s.offsets.back().latitude);
    entry.require(names.insert(s.offsets.back().name).second, "name", "another well has this name");
    any_grid = any_grid || uses_grid(entry);
  }
  if (any_grid) ask_for_north_of_slots(c, s, north);
  read_disturbances(c, offsets, s);
  s.rule.scale_factor =
      c.number("separation.scale_factor", config::Range::positive(), "k of the separation rule", s.rule.scale_factor);
  s.rule.surface_margin = c.number("separation.surface_margin_m", config::Range::non_negative(),
                                   "S_m of the separation rule", s.rule.surface_margin);
  s.rule.project_ahead = c.number("separation.project_ahead_m", config::Range::non_negative(),
                                  "sigma_pa of the separation rule", s.rule.project_ahead);
  s.interpolation = c.choice("separation.interpolation", {"covariance", "effects"},
                             "between stations: 'covariance': covariances and shared parts are linear in measured "
                             "depth; 'effects': errors are linear, as of a drawn well",
                             "covariance") == "effects"
                        ? Interpolation::effects
                        : Interpolation::covariance;
  if (s.interpolation == Interpolation::effects) require_few_disturbed(c, s);
  read_formulations(c, s);
  return s;
}

void require_few_disturbed(config::ConfigReader& c, const WellPairs& s) {
  const auto require_few = [&](const Well& w) {
    if (!w.disturbance || !w.disturbance->has_memory()) return;
    try {
      propagate::require_few_draws(w.tools.runs, w.survey.stations.size());
    } catch (const InputError& e) {
      c.fail("disturbance.kind", fmt::format("the well \"{}\" has {}", w.name, e.what()));
    }
  };
  require_few(s.reference);
  for (const Well& w : s.offsets) require_few(w);
}

void scale_models(config::ConfigReader& c, WellPairs& s) {
  const double multiplier =
      c.number("errors.multiplier", {0, 1000, true, false}, config::meaning::kErrorsMultiplier, 1);
  if (multiplier == 1) return;
  std::map<const error_model::Model*, config::SharedModel> scaled;
  const auto scale = [&](ToolRuns& tools) {
    for (propagate::ToolRun& run : tools.runs) {
      config::SharedModel& own = scaled[run.model.get()];
      if (!own) {
        auto model = std::make_shared<error_model::Model>(*run.model);
        for (error_model::Term& t : model->terms) {
          t.magnitude *= multiplier;
          t.sigma *= multiplier;
        }
        own = std::move(model);
      }
      run.model = own;
    }
  };
  const auto scale_well = [&](Well& w) {
    scale(w.tools);
    scale(w.tools_from_kickoff);
  };
  scale_well(s.reference);
  for (Well& w : s.offsets) scale_well(w);
}

propagate::WellErrors drawn_errors(const SurveyedWell& w, const ToolRuns& tools, propagate::VerticalRule vertical) {
  propagate::WellErrors errors = propagate::well_errors(w.survey, w.tvd, tools.runs, w.field, w.latitude, 1, vertical);
  if (!w.disturbance || !w.disturbance->has_memory()) return errors;
  return propagate::with_independent_draws(errors,
                                           propagate::disturbed_draws(errors, tools.runs, *w.disturbance, w.field));
}

std::vector<compare::Warning> warnings_of(const SurveyedWell& w,
                                          const std::vector<propagate::NonFiniteTerm>& non_finite) {
  std::vector<propagate::Validity> all = propagate::tool_validity(w.survey, w.tools.runs, w.field, w.latitude);
  for (const propagate::NonFiniteTerm& term : non_finite) all.push_back(propagate::validity_of(term, w.tools.runs));
  std::vector<compare::Warning> out = validity_warnings(w.survey, w.tools, all, w.name);
  add_spacing_warning(out, w.survey, w.tvd, w.tools, w.field, w.latitude, w.name,
                      w.name == "reference" ? kInterpolate : "interpolate_m of its [[offset]]");
  return out;
}

store::Table paths_table(const WellPairs& wells) {
  compare::TableRows t("paths", "stations of all wells in one frame");
  const auto rows = [&](const SurveyedWell& w) {
    const proximity::WellPath path = proximity::well_path(w.survey, w.slot);
    for (std::size_t k = 0; k < path.stations(); ++k) {
      const Eigen::Vector3d p = path.at_station(k).position;
      t.word("well", "name of the well", w.name);
      t.number("md_m", "m", "measured depth", path.md(k));
      t.number("inclination_deg", "deg", "of the hole", w.survey.stations[k].inclination / kDegree);
      t.number("azimuth_deg", "deg", "of the hole, true north", compare::turn_in_degrees(w.survey.stations[k].azimuth));
      t.number("north_m", "m", "position, true north", p.x());
      t.number("east_m", "m", "position", p.y());
      t.number("tvd_m", "m", "position, down", p.z());
    }
  };
  rows(wells.reference);
  for (const SurveyedWell& w : wells.offsets) rows(w);
  return t.take();
}

PairReference pair_reference(const SurveyedWell& well, Interpolation interpolation) {
  PairReference r(well, proximity::well_path(well.survey, well.slot));
  r.errors_ = errors_of(well, interpolation, r.non_finite_);
  return r;
}

const propagate::StationEffects& PairReference::effects() const {
  if (!effects_) effects_ = std::make_unique<propagate::StationEffects>(all_effects(well_, well_.tools));
  return *effects_;
}

WellPair well_pair(const WellPairs& s, const PairReference& reference, const SurveyedWell& well) {
  WellPair pair;
  pair.offset = &well;
  pair.offset_path = std::make_unique<const proximity::WellPath>(proximity::well_path(well.survey, well.slot));
  pair.geometry.reference = &reference.path();
  pair.geometry.offset = pair.offset_path.get();
  pair.geometry.reference_survey = &reference.well().survey;
  pair.geometry.rule = s.rule;
  pair.geometry.radii = (reference.well().hole_diameter + well.hole_diameter) / 2;
  pair.geometry.first = well.kickoff.value_or(0);
  pair.geometry.first_scanned = well.kickoff ? *well.kickoff + 1 : 0;
  const auto of_reference = reference.errors(), of_offset = errors_of(well, s.interpolation, pair.non_finite);
  propagate::StationEffects effects;
  if (well.kickoff) effects = all_effects(well, well.tools_from_kickoff);
  for (const Formulation& f : s.formulations) {
    if (!f.is_for(well)) continue;
    if (f.kind == Formulation::Kind::shared_hole) {
      pair.formulations.push_back(proximity::shared_hole(reference.effects(), effects, *well.kickoff));
    } else if (f.kind == Formulation::Kind::zeroed) {
      pair.formulations.push_back(proximity::zeroed_at_kickoff(reference.effects(), effects, *well.kickoff,
                                                               reference.path().at_station(*well.kickoff).tangent,
                                                               s.interpolation));
    } else {
      proximity::PairErrors e{f.name, of_reference, of_offset, {}, true};
      e.common.sources = proximity::shared_sources(f.sharing, f.codes, *of_reference, *of_offset);
      e.is_independent = e.common.sources.empty();
      pair.formulations.push_back(std::move(e));
    }
  }
  return pair;
}

const proximity::PairErrors& WellPair::formulation(const std::string& name) const {
  const auto at = std::find_if(formulations.begin(), formulations.end(),
                               [&](const proximity::PairErrors& e) { return e.formulation == name; });
  assert(at != formulations.end());
  return *at;
}

}  // namespace surveymc::scenario
