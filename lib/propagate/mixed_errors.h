#pragma once
/// Errors of a well whose reference is not normal: which draws have which V (random/mixing_law.h), and what follows for
/// the tails of its position.
///
/// Errors that last share the V of their element of the reference field, G and W alike, in all wells of a trial; those
/// of a station (R) share that of their element at the station.
#include <vector>

#include <Eigen/Core>

#include "propagate/well_errors.h"
#include "random/mixing_draws.h"
#include "random/reference_laws.h"
#include "stats/heavy_tail.h"

namespace surveymc::propagate {

/// Address of a draw in the random stream. Draws of two wells with the same address are one error.
struct DrawPlace {
  random::Channel channel{};
  std::uint32_t index = 0;
};

struct WellMixing {
  std::vector<random::MixingSlot> slots;
  std::vector<std::int32_t> slot_of_draw;  ///< one a draw of the well; -1: normal
};

/// `places`: one a draw of `errors`.
WellMixing well_mixing(const WellErrors& errors, const random::ReferenceLaws& laws,
                       const std::vector<DrawPlace>& places);

/// The errors with the standard deviations that follow from the tabulated sizes by the laws.
WellErrors resized(WellErrors errors, const random::ReferenceLaws& laws);

/// The heavy parts of the error along a direction, from the first-order effects of every draw: draw_effects(). Empty
/// where the direction has no error.
std::vector<stats::HeavyPart> heavy_parts(const WellMixing& mixing, const Eigen::Matrix3Xd& effects,
                                          const Eigen::Vector3d& direction);

}  // namespace surveymc::propagate
