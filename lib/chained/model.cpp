#include "chained/model.h"

#include <cmath>

#include "base/error.h"

namespace surveymc::chained {

double expected_offset(const ChainSize& size, int stations) {
  if (size.offset > 0) return size.offset;
  const double n = stations;
  return std::sqrt(size.random * size.random + size.walk * size.walk * (n + 1) * (2 * n + 1) / (6 * n));
}

Model make_model(const ChainSizes& s, int stations, ChainReferences references) {
  Model m;
  m.gravity = s.gravity_reference;
  m.horizontal = s.horizontal;
  m.down = s.down;
  m.references = references;
  const std::array<ChainSize, kChainStates> sizes{
      s.gravity,         s.field,           s.field,           s.accelerometer_xy, s.accelerometer_xy,
      s.accelerometer_z, s.magnetometer_xy, s.magnetometer_xy, s.magnetometer_z};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double offset = expected_offset(sizes[i], stations);
    m.link_sd[i] = sizes[i].walk;
    m.prior_sd[i] = std::hypot(i < kReferenceStates ? sizes[i].random : offset, sizes[i].walk);
    if (i < kReferenceStates)
      m.reference_sd[i] = offset;
    else
      m.noise[i - kReferenceStates] = sizes[i].random;
  }
  return m;
}

void check(const Model& m) {
  const auto positive = [](const auto& sizes) {
    for (const double x : sizes)
      if (!(x > 0) || !std::isfinite(x)) return false;
    return true;
  };
  require(positive(m.noise) && positive(m.prior_sd) && positive(m.link_sd) &&
              (!m.independent() || positive(m.reference_sd)),
          "chained model: noise, prior and walk of every state: must be > 0");
  require(m.gravity > 0 && m.horizontal > 0 && std::isfinite(m.down),
          "chained model: gravity and horizontal reference field: must be > 0");
}

}  // namespace surveymc::chained
