#pragma once
/// Search for all minima. It is needed when nothing is known of the attitudes, or when an axial bias is so large that
/// the basic solution begins on the wrong side ("unstart", slide 12). Sub-searches of the attitudes alone and of
/// constant offsets alone find starts, and the descent of the whole chain goes from each start to a minimum, all by
/// Levenberg (descent.h), side by side (side_by_side.h).
///
/// Near horizontal east-west an axial bias and the sign of cosA can hardly be told apart: with A' = 180 deg - A and
///   b_z' = b_z + 2 Bh cosA / sinI,   Bd' = Bd - 2 Bh cosA cosI / sinI
/// a station reads the same. Then the lowest J need not be the truth.
#include "chained/side_by_side.h"

namespace surveymc::chained {

/// Constant offsets that minimise offset_misfit, from no offset; attitudes by the basic solution of the readings
/// without them.
Point search_offsets(const Model& model, const Readings& readings);

/// The mirror image of a point, as above, b_z shifted by the mean over the stations. With `search`, the result of a new
/// search from this image.
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

/// Where find_modes begins: the basic solution, the offsets' search, and the mirror images of both with and without a
/// search from there; with `attitudes` also the attitudes' search.
std::vector<Point> search_starts(const Model& model, const Readings& readings, bool attitudes = true);

Modes find_modes(const Model& model, const Readings& readings, const SearchOptions& options = {});
/// The same from other starts.
Modes find_modes(const Model& model, const Readings& readings, const std::vector<Point>& starts,
                 const SearchOptions& options = {});
/// The same from the ends of descents (by options.polish) that were made elsewhere.
Modes find_modes(const Model& model, const Readings& readings, const std::vector<Ended>& ends,
                 const SearchOptions& options = {});

}  // namespace surveymc::chained
