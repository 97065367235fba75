#pragma once
/// Solutions of one station alone, in closed form or nearly so: where the chained solvers begin, and what they are
/// compared with (slides 1, 4 and 5).
#include <functional>

#include "chained/model.h"

namespace surveymc::chained {

struct SingleStation {
  Eigen::Matrix3d frame;                         ///< M
  double gravity = 0, horizontal = 0, down = 0;  ///< m/s2, nT, nT
};

/// Basic solution: down from the accelerometers, the rest from the magnetometers. Exact without errors at every
/// attitude, vertical ones included. Field and gravity must not be parallel.
SingleStation basic_station(const StationReading& y);

/// Sizes that the fully optimising solution weighs with.
struct SingleWeights {
  StationReading reading_sd{};
  std::array<double, kReferenceStates> reference_sd{};
};
/// The expected offsets XO of slide 7, as the slides do.
SingleWeights single_weights(const Model& model);

/// Fully optimising gravity, then azimuth (slides 4 and 5): minimises
///   sum ((y - f)/s)^2 + ((|f| - g)/s_g)^2   over f, and then, with d = -f/|f| held,
///   sum ((y - h)/s)^2 + ((h_horizontal - Bh)/s_B)^2 + ((h.d - Bd)/s_B)^2   over h.
SingleStation fully_optimised_station(const Model& model, const SingleWeights& weights, const StationReading& y);

/// How a station is solved alone before the chain; may be replaced.
using StationSolver = std::function<Eigen::Matrix3d(const StationReading&)>;
inline Eigen::Matrix3d basic_frame(const StationReading& y) { return basic_station(y).frame; }

}  // namespace surveymc::chained
