#pragma once
/// Where to begin when nothing is known of the attitudes, or when an axial bias is so large that the basic solution
/// begins on the wrong side ("unstart", slide 12): derivative-free sub-searches (NLopt, Nelder-Mead), each polished by
/// Levenberg, and all the minima that they lead to.
///
/// Near horizontal east-west an axial bias and the sign of cosA can hardly be told apart: with A' = 180 deg - A and
///   b_z' = b_z + 2 Bh cosA / sinI,   Bd' = Bd - 2 Bh cosA cosI / sinI
/// a station reads the same. The lowest J need not be the truth then.
#include "chained/block_solver.h"

namespace surveymc::chained {

/// Attitudes by Nelder-Mead in three rotations, station by station, with no offset, from four azimuths and two
/// toolfaces. Needs no start.
Point search_attitudes(const Model& model, const Readings& readings);

/// Constant offsets by Nelder-Mead in six dimensions, attitudes by the basic solution of the readings without them:
/// minimises the misfit of gravity, horizontal and downward field over all stations, from no offset.
Point search_offsets(const Model& model, const Readings& readings);

/// The mirror image of a point, as above, b_z shifted by the mean over the stations; searched again from there if
/// `search`.
Point mirrored(const Model& model, const Readings& readings, const Point& point, bool search);

struct SearchOptions {
  Options polish = {};
  bool attitudes = true;    ///< include search_attitudes
  double ambiguity = 13.8;  ///< J of a second mode within this of the first: odds below e^6.9 = 1000
};

/// Distinct minima, lowest J first.
struct Modes {
  std::vector<Solution> modes;  ///< empty if nothing converged
  bool ambiguous = false;       ///< a second mode explains the readings almost as well
};
Modes find_modes(const Model& model, const Readings& readings, const SearchOptions& options = {});

}  // namespace surveymc::chained
