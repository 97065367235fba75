#pragma once
/// Chained multistation the sequential way: Kalman filter, Rauch-Tung-Striebel smoother. Independent of
/// block_solver.h but for the first-order model of a station (linearised_station.h).
///
/// Attitudes have no prior. They are eliminated exactly, not by a large variance: with N an orthonormal basis of the
/// left null space of the whitened by_delta (6 x 3), z = N' e does not depend on delta, and is all that a station says
/// of the chain: three numbers with unit noise, H = N' by_chain. Given the chain, delta follows by least squares.
#include "chained/block_solver.h"

namespace surveymc::chained {

/// Filter and smoother over all stations, repeated at the smoothed point until it stands: one pass is one step of
/// Gauss-Newton, so it ends where solve_blocks ends. Undamped.
Solution run_smoother(const Model& model, const Readings& readings, const Point& start, const Options& options = {});
Solution run_smoother(const Model& model, const Readings& readings, const Options& options = {});

/// Forwards only, as while drilling: every station is solved (iterated to its own minimum) from what the stations
/// before it left of the chain. `cost` is the sum of the stations' minima. No interference.
Solution run_filter(const Model& model, const Readings& readings, const Point& start, const Options& options = {});
Solution run_filter(const Model& model, const Readings& readings, const Options& options = {});

}  // namespace surveymc::chained
