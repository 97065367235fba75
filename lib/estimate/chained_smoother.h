#pragma once
/// Chained multistation the sequential way: Kalman filter, Rauch-Tung-Striebel smoother. Independent of
/// chained_newton.h but for the first-order model of a station (chained_linear.h).
///
/// Attitudes have no prior. They are eliminated exactly, not by a large variance: with N an orthonormal basis of the
/// left null space of the whitened by_delta (6 x 3), z = N' e does not depend on delta, and is all that a station says
/// of the chain: three numbers with unit noise, H = N' by_chain. Given the chain, delta follows by least squares.
#include "estimate/chained_newton.h"

namespace surveymc {

/// Filter and smoother over all stations, repeated at the smoothed point until it stands: one pass is one step of
/// Gauss-Newton, so it ends where solve_chained ends. Undamped.
ChainedSolution smooth_chained(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& start,
                               const ChainedOptions& options = {});
ChainedSolution smooth_chained(const ChainedModel& model, const ChainedReadings& readings,
                               const ChainedOptions& options = {});

/// Forwards only, as while drilling: every station is solved (iterated to its own minimum) from what the stations
/// before it left of the chain. `cost` is the sum of the stations' minima. No interference.
ChainedSolution filter_chained(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& start,
                               const ChainedOptions& options = {});
ChainedSolution filter_chained(const ChainedModel& model, const ChainedReadings& readings,
                               const ChainedOptions& options = {});

}  // namespace surveymc
