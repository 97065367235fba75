#pragma once
/// Rounds of a sweep: the next points along a boundary, and several rounds as one result.
#include <map>
#include <string>
#include <vector>

#include "config/next_round.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::sweep {

/// Points of one slice, a value of all other keys.
///
/// A cell of the first grid is halved along every axis on which it is larger than the rule's `cell`, and its halves
/// likewise, where the boundary passes or may pass:
///   crosses:   its corners, or those of its midpoints that are known, lie on both sides
///   doubtful:  least |distance| of its nodes < 2 sum_d D_d / 8
/// D_d is the largest second difference |v(-h) - 2 v(0) + v(h)| along axis d in the cell, h its side; D_d / 8 is what a
/// chord misses of an arc. A larger cell beside one that is halved takes over the D of that one, times the ratio of
/// their sides, as of a fold: so the boundary is followed into valleys that are narrower than the cells. A midpoint is
/// not run where the mean of the ends of its edge or face leaves no doubt: |mean| > 6 sum D_d / 8.
/// Without distances there is no D: then only crossing cells are halved, and a midpoint is not run if all corners round
/// it are on one side.
struct NextPoints {
  std::vector<std::map<std::string, double>> points;  ///< value of every axis; rising, the last axis fastest
  std::size_t crossed = 0;                            ///< smallest cells that the boundary crosses
};

/// `distance`: of every known point from the boundary, by its values in the order of `axes`, in [-1, 1]; NaN where
/// there is none; all of them +1 or -1 where only sides are known. `grid`: values of the axes in the first round,
/// rising.
NextPoints next_points(const std::vector<std::string>& axes, const std::map<std::string, std::vector<double>>& grid,
                       double cell, const std::map<std::vector<double>, double>& distance);

/// The next round of a result: its config and its table of points as CSV, which has the name `file`. A function of
/// the result alone.
struct NextRound {
  std::string config, points;
  std::size_t count = 0;    ///< new points; 0: the boundary is as fine as [refine] wants it
  std::size_t crossed = 0;  ///< smallest cells on the boundary
};
/// Throws InputError where the result has no [refine], or where that does not fit.
NextRound next_round(const store::Result& result, const std::string& label, const std::string& file);

/// A result and the files that are stored in it.
struct Round {
  std::string label;
  store::Result result;
  config::StoredInputs inputs;
};

/// One result with the points of several rounds, in their order: that of a run whose table of points `file` lists them.
/// `folder`: of the config, with files that are too large to be stored. Throws InputError if they are not rounds of one
/// config, or have maps that are not held in memory.
store::Result merged_rounds(const study::Experiment& experiment, std::vector<Round> rounds, const std::string& file,
                            const std::string& folder);

}  // namespace surveymc::sweep
