#include "clearance/pairs.h"

#include <algorithm>
#include <cassert>

namespace surveymc::studies::clearance {
namespace {

using proximity::Interpolation;

propagate::StationEffects all_effects(const Well& w, const study::ToolRuns& tools) {
  propagate::StationEffects effects;
  propagate::tool_covariances(w.survey, w.tvd, tools.runs, w.field, w.latitude, propagate::SourceDetail::none,
                              &effects);
  return effects;
}

std::shared_ptr<const proximity::PositionErrors> errors_of(const Well& w, Interpolation interpolation,
                                                           std::vector<propagate::NonFiniteTerm>& non_finite) {
  propagate::ToolCovariances covariances;
  auto errors = std::make_shared<proximity::PositionErrors>(
      proximity::position_errors(w.survey, w.tvd, w.tools.runs, w.field, w.latitude, interpolation, &covariances));
  non_finite = covariances.non_finite;
  return errors;
}

}  // namespace

Reference::Reference(const Well& well, Interpolation interpolation) : well_(well), path_(well.survey, well.slot) {
  errors_ = errors_of(well, interpolation, non_finite_);
}

const propagate::StationEffects& Reference::effects() const {
  if (!effects_) effects_ = std::make_unique<propagate::StationEffects>(all_effects(well_, well_.tools));
  return *effects_;
}

Pair::Pair(const Scenario& s, const Reference& reference, const Well& well)
    : offset(&well), offset_path(well.survey, well.slot) {
  geometry.reference = &reference.path();
  geometry.offset = &offset_path;
  geometry.reference_survey = &reference.well().survey;
  geometry.rule = s.rule;
  geometry.radii = (reference.well().hole_diameter + well.hole_diameter) / 2;
  geometry.first = well.kickoff.value_or(0);
  const auto of_reference = reference.errors(), of_offset = errors_of(well, s.interpolation, non_finite);
  propagate::StationEffects effects;
  if (well.kickoff) effects = all_effects(well, well.tools_from_kickoff);
  for (const Formulation& f : s.formulations) {
    if (!f.is_for(well)) continue;
    if (f.kind == Formulation::Kind::shared_hole) {
      formulations.push_back(proximity::shared_hole(reference.effects(), effects, *well.kickoff));
    } else if (f.kind == Formulation::Kind::zeroed) {
      formulations.push_back(proximity::zeroed_at_kickoff(reference.effects(), effects, *well.kickoff,
                                                          reference.path().at_station(*well.kickoff).tangent,
                                                          s.interpolation));
    } else {
      proximity::PairErrors e{f.name, of_reference, of_offset, {}, true};
      e.common.sources = proximity::shared_sources(f.sharing, f.codes, *of_reference, *of_offset);
      e.is_independent = e.common.sources.empty();
      formulations.push_back(std::move(e));
    }
  }
}

const proximity::PairErrors& Pair::formulation(const std::string& name) const {
  const auto at = std::find_if(formulations.begin(), formulations.end(),
                               [&](const proximity::PairErrors& e) { return e.formulation == name; });
  assert(at != formulations.end());
  return *at;
}

}  // namespace surveymc::studies::clearance
