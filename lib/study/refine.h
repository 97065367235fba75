#pragma once
/// Rounds of a sweep: the next points along a boundary, and several rounds as one result.
#include <map>
#include <string>
#include <vector>

#include "config/next_round.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::study {

/// Points of one slice, a value of all other keys, by their place: index on the finest grid of every axis.
///
/// A grid of cells is divided where a boundary passes: a cell whose corners, or those midpoints of it that are known,
/// lie on both sides of it, is halved along every axis on which it is larger than the rule's `cell`, until it is not.
/// Of its midpoints, those of edges and faces with all corners on one side are not run: they are taken to be there,
/// too.
struct NextPoints {
  std::vector<std::map<std::string, double>> points;  ///< value of every axis; rising, the last axis fastest
  std::size_t crossed = 0;                            ///< smallest cells that the boundary crosses
};

/// `side`: of every known point, by its values in the order of `axes`: +1, -1, or 0 where it is not known. `grid`:
/// values of the axes in the first round, rising.
NextPoints next_points(const std::vector<std::string>& axes, const std::map<std::string, std::vector<double>>& grid,
                       double cell, const std::map<std::vector<double>, int>& side);

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
  std::vector<config::InputTable> tables = {};
  std::vector<config::InputText> texts = {};
  std::vector<config::InputReference> references = {};
};

/// One result with the points of several rounds, in their order: that of a run whose table of points `file` lists them.
/// `folder`: of the config, with files that are too large to be stored. Throws InputError if they are not rounds of one
/// config, or have maps.
store::Result merged_rounds(const Experiment& experiment, std::vector<Round> rounds, const std::string& file,
                            const std::string& folder);

}  // namespace surveymc::study
