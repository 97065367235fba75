#include "propagate/mixed_errors.h"

#include <cmath>
#include <map>
#include <tuple>

namespace surveymc::propagate {
namespace {

/// The law of a source; null: normal.
std::shared_ptr<const random::MixingLaw> law_of(const ErrorSource& source, const random::ReferenceLaws& laws) {
  using enum error_model::PropagationMode;
  if (!source.element) return nullptr;
  const bool has = (source.mode == global && laws.global) || (source.mode == well && laws.well) ||
                   (source.mode == random && laws.random);
  return has ? laws.of(*source.element).law : nullptr;
}

}  // namespace

WellMixing well_mixing(const WellErrors& errors, const random::ReferenceLaws& laws,
                       const std::vector<DrawPlace>& places) {
  WellMixing out;
  out.slot_of_draw.assign(errors.draws.size(), -1);
  // By whether the draw lasts, by station, by element: who shares a V.
  std::map<std::tuple<bool, std::size_t, std::uint32_t>, int> slot_of;
  for (std::size_t d = 0; d < errors.draws.size(); ++d) {
    const ErrorSource& source = errors.sources[errors.draws[d].source];
    const auto law = law_of(source, laws);
    if (!law) continue;
    const bool lasts = d < errors.station_draws;
    int slot = static_cast<int>(out.slots.size());
    if (laws.each_term) {
      out.slots.push_back({law, lasts ? random::kMixingTerm : random::kMixingStation, places[d].index});
    } else {
      const std::uint32_t element = laws.slot(*source.element);
      const auto [at, is_new] = slot_of.emplace(std::tuple(lasts, lasts ? 0 : errors.draws[d].first, element), slot);
      slot = at->second;
      if (is_new)
        out.slots.push_back(lasts ? random::MixingSlot{law, random::kMixingRun, element}
                                  : random::MixingSlot{law, random::kMixingStation, places[d].index});
    }
    out.slot_of_draw[d] = slot;
  }
  return out;
}

WellErrors resized(WellErrors errors, const random::ReferenceLaws& laws) {
  for (auto& effects : errors.at)
    for (DrawEffect& e : effects) {
      const ErrorSource& source = errors.sources[errors.draws[e.draw].source];
      if (!law_of(source, laws)) continue;
      const double sd = laws.of(*source.element).sd;
      for (double* x : {&e.depth, &e.inclination, &e.azimuth, &e.tilt}) *x *= sd;
      e.course *= sd;
    }
  return errors;
}

std::vector<stats::HeavyPart> heavy_parts(const WellMixing& mixing, const Eigen::Matrix3Xd& effects,
                                          const Eigen::Vector3d& direction) {
  const Eigen::RowVectorXd along = direction.transpose() * effects;
  const double variance = along.squaredNorm();
  if (!(variance > 0)) return {};
  return stats::heavy_parts(mixing.slots, mixing.slot_of_draw, along.transpose(), variance);
}

}  // namespace surveymc::propagate
