#include "propagate/code_claim.h"

#include <cmath>
#include <limits>

#include "base/units.h"
#include "propagate/code_draws.h"
#include "propagate/tool_covariance.h"
#include "survey/minimum_curvature.h"

namespace surveymc::propagate {
namespace {

bool turns_hole(const error_model::Term& term) {
  return term.function->kind == error_model::Kind::station && term.function->depth.empty();
}

ClaimedErrors errors_of(const std::shared_ptr<const error_model::Model>& model, const survey::Survey& survey,
                        const survey::ReferenceField& field, bool with_azimuth) {
  StationEffects effects;
  ClaimedErrors out;
  // No term of a magnetic code needs the latitude.
  out.position = tool_covariances(survey, survey::true_vertical_depths(survey), {{1, model}}, field, kNaN,
                                  SourceDetail::none, with_azimuth ? &effects : nullptr)
                     .total.back();
  if (!with_azimuth) return out;
  const std::size_t n = survey.stations.size();
  out.azimuth.assign(n, 0);
  for (std::size_t k = 1; k < n; ++k) {
    const survey::Station& s = survey.stations[k];
    // Where the first leg is doubled, so is e*_1.
    const double half_leg = (s.md - survey.stations[k - 1].md) / (k == 1 && model->first_leg_doubled ? 1 : 2);
    const Eigen::RowVector3d right(-std::sin(s.azimuth), std::cos(s.azimuth), 0);
    for (std::size_t source = 0; source < effects.sources.size(); ++source) {
      const double lateral = right.dot(effects.star[source * n + k]) / half_leg;
      out.azimuth[k] += lateral * lateral;
    }
  }
  return out;
}

}  // namespace

ClaimedCode::ClaimedCode(const error_model::Model& model) {
  magnetic_ = std::make_shared<const error_model::Model>(carried_part(model, false));
  error_model::Model turning = carried_part(model, true), rest = turning;
  std::erase_if(turning.terms, [](const error_model::Term& t) { return !turns_hole(t); });
  std::erase_if(rest.terms, turns_hole);
  carried_turning_ = std::make_shared<const error_model::Model>(std::move(turning));
  carried_rest_ = std::make_shared<const error_model::Model>(std::move(rest));
}

ClaimedErrors ClaimedCode::magnetic(const survey::Survey& survey, const survey::ReferenceField& field) const {
  return errors_of(magnetic_, survey, field, true);
}

ClaimedErrors ClaimedCode::carried(const survey::Survey& survey, const survey::ReferenceField& field) const {
  ClaimedErrors out = errors_of(carried_turning_, survey, field, true);
  out.position += errors_of(carried_rest_, survey, field, false).position;
  return out;
}

}  // namespace surveymc::propagate
