#include "propagate/tool_validity.h"

#include <array>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "error_model/model_graph.h"

namespace surveymc::propagate {
namespace {

namespace em = error_model;

/// A range is in degrees of a file, and a station's inclination of another: equal ones are inside.
constexpr double kSameAngle = 1e-9 * kDegree;

bool is_in_range(const em::Model& m, double inclination) {
  return inclination >= m.inclination_min - kSameAngle && inclination <= m.inclination_max + kSameAngle;
}
bool is_excluded(const em::Model& m, double inclination, double magnetic_azimuth) {
  return m.east_west_exclusion > 0 &&
         em::angle_to_east_west(inclination, magnetic_azimuth) < m.east_west_exclusion - kSameAngle;
}

/// Counts the stations of a run that `is_outside` holds for.
template <class Outside>
void add_stations(std::vector<Validity>& out, Validity v, std::size_t begin, std::size_t end,
                  const Outside& is_outside) {
  for (std::size_t k = begin; k < end; ++k) {
    if (!is_outside(k)) continue;
    if (v.stations++ == 0) v.first = k;
    v.last = k;
  }
  if (v.stations > 0) out.push_back(std::move(v));
}

/// An error of the runs of one well together: R is new at every station, S at every run, a random walk in every
/// section.
bool is_shared_by_runs(const em::Term& t) { return em::joins_legs(t.mode) && !t.function->per_section; }

std::string function_text(const em::Function& f, bool with_formulas) {
  std::string text;
  for (const auto& [key, formula] : f.formulas())
    text += fmt::format("{}{} = \"{}\"", text.empty() ? "" : ", ", key, formula->text);
  return with_formulas ? fmt::format("{} ({})", f.name, text) : f.name;
}

}  // namespace

std::string rule_name(ValidityRule rule) {
  constexpr std::array kNames{"inclination range", "east-west exclusion", "not finite",
                              "zero term",         "function differs",    "note"};
  return kNames[static_cast<std::size_t>(rule)];
}

bool holds_at(const em::Model& m, double inclination, double magnetic_azimuth) {
  return is_in_range(m, inclination) && !is_excluded(m, inclination, magnetic_azimuth);
}

std::vector<Validity> tool_validity(const survey::Survey& survey, const std::vector<ToolRun>& runs,
                                    const survey::ReferenceField& field, double latitude) {
  std::vector<Validity> out;
  std::map<std::pair<std::string, em::PropagationMode>, std::pair<std::shared_ptr<const em::Function>, std::string>>
      functions;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const em::Model& m = *runs[r].model;
    const auto begin = static_cast<std::size_t>(runs[r].first);
    const std::size_t end = r + 1 < runs.size() ? static_cast<std::size_t>(runs[r + 1].first) : survey.stations.size();
    const auto& s = survey.stations;
    add_stations(out,
                 {r, ValidityRule::inclination_range, 0, 0, 0,
                  fmt::format("the model holds from {:.6g} to {:.6g} deg of inclination", m.inclination_min / kDegree,
                              m.inclination_max / kDegree)},
                 begin, end, [&](std::size_t k) { return !is_in_range(m, s[k].inclination); });
    add_stations(out,
                 {r, ValidityRule::east_west_exclusion, 0, 0, 0,
                  fmt::format("the model does not hold within {:.6g} deg of horizontal magnetic east or west",
                              m.east_west_exclusion / kDegree)},
                 begin, end,
                 [&](std::size_t k) { return is_excluded(m, s[k].inclination, s[k].azimuth - field.declination); });
    const em::Surroundings surroundings =
        em::surroundings_of(m.parameters, field.dip, field.total, field.gravity, latitude);
    const auto of_run = [&](ValidityRule rule, const std::string& detail) {
      out.push_back({r, rule, end - begin, begin, end - 1, detail});
    };
    for (const em::Term& t : m.terms)
      if (em::is_without_effect(t, surroundings))
        of_run(ValidityRule::zero_term,
               fmt::format("{}: {} has no effect at any inclination and azimuth", t.code, t.function->name));
    for (const em::Term& t : m.terms) {
      if (!is_shared_by_runs(t)) continue;
      const auto [at, is_new] = functions.try_emplace({t.code, t.mode}, t.function, m.name);
      if (is_new || em::have_same_formulas(at->second.first, t.function)) continue;
      const em::Function &there = *at->second.first, &here = *t.function;
      const bool with_formulas = there.name == here.name;
      of_run(ValidityRule::function_differs,
             fmt::format("{} is one error with that of {}, but acts by {} there and by {} here", t.code,
                         at->second.second, function_text(there, with_formulas), function_text(here, with_formulas)));
    }
    if (!m.note.empty()) of_run(ValidityRule::note, m.note);
  }
  return out;
}

Validity validity_of(const NonFiniteTerm& t, const std::vector<ToolRun>& runs) {
  const em::Term& term = runs[t.run].model->terms[t.term];
  return {t.run,
          ValidityRule::not_finite,
          t.stations,
          t.first,
          t.last,
          fmt::format("{}: {}: {} is not finite, or beyond {:g} rad: no covariance from the first station on",
                      term.code, term.function->name, t.formula, kLargestAngle)};
}

}  // namespace surveymc::propagate
