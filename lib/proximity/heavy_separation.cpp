#include "proximity/heavy_separation.h"

#include <array>
#include <cmath>

#include "propagate/well_errors.h"

namespace surveymc::proximity {

std::vector<stats::HeavyPart> heavy_parts(const PairErrors& errors, const random::ReferenceLaws& laws,
                                          const PairPoints& p, double sd) {
  std::vector<stats::HeavyPart> out;
  if (!(p.distance > 0) || !(sd > 0)) return out;
  const Eigen::Vector3d u = (p.offset.position - p.reference.position) / p.distance;
  std::array<double, 4> square{};  // by slot of a V
  std::array<std::shared_ptr<const random::MixingLaw>, 4> law_of;
  const auto add = [&](const JoiningSource& source, double along) {
    const auto element = propagate::reference_element(source.code, source.function);
    const bool has = source.mode == error_model::PropagationMode::global ? laws.global : laws.well;
    if (!element || !has || !laws.of(*element).law || along == 0) return;
    const auto& law = laws.of(*element).law;
    if (laws.each_term) {
      out.push_back({law, along / sd});
      return;
    }
    const std::size_t slot = laws.slot(*element);
    square[slot] += along * along;
    law_of[slot] = law;
  };
  const auto along = [&](const PositionErrors& well, std::size_t i, const PathPoint& at) {
    return u.dot(well.summed_at(i, at.leg, at.share));
  };
  std::vector<bool> shared_r(errors.reference->sources.size()), shared_o(errors.offset->sources.size());
  for (const auto& [i, j] : errors.common.sources) {
    shared_r[i] = shared_o[j] = true;
    add(errors.reference->sources[i], along(*errors.offset, j, p.offset) - along(*errors.reference, i, p.reference));
  }
  for (std::size_t i = 0; i < shared_r.size(); ++i)
    if (!shared_r[i]) add(errors.reference->sources[i], -along(*errors.reference, i, p.reference));
  for (std::size_t j = 0; j < shared_o.size(); ++j)
    if (!shared_o[j]) add(errors.offset->sources[j], along(*errors.offset, j, p.offset));
  for (std::size_t s = 0; s < square.size(); ++s)
    if (square[s] > 0) out.push_back({law_of[s], std::sqrt(square[s]) / sd});
  return out;
}

}  // namespace surveymc::proximity
