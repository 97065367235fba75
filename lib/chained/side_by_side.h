#pragma once
/// Descents from several starts side by side on lanes, all from the same readings: what a search for all minima spends
/// its time on. Same ends as one after the other by descend_blocks, to rounding; a start's end does not depend on the
/// others.
#include "chained/block_solver.h"

namespace surveymc::chained {

/// Ends of the descents from `starts`, in their order. On lanes where the model has no interference and no state is
/// known, else by descend_blocks. Throws InputError for an invalid model.
std::vector<Ended> descend_all(const Model& model, const Readings& readings, const std::vector<Point>& starts,
                               const Options& options = {});

/// Attitudes of every station alone, with no offset, from four azimuths and two toolfaces: minimises the squares of the
/// six residuals over noise and prior of the offsets, the lowest of the eight ends. Needs no start.
Point search_attitudes(const Model& model, const Readings& readings);

/// Six constant offsets, in units of their prior sd.
using Offsets = std::array<double, 6>;

/// Misfit of constant offsets: their squares and, over all stations, those of gravity, horizontal and downward field of
/// the readings without them less the references, each over
///   s^2 = (noise of reading z)^2 + n/2 (its walk)^2 + (prior sd of the reference's error)^2:
/// errors of the references and half a run's walk of the offsets count as noise.
double offset_misfit(const Model& model, const Readings& readings, const Offsets& offsets);

/// Minima of offset_misfit from each of the starts.
std::vector<Offsets> search_offsets_from(const Model& model, const Readings& readings,
                                         const std::vector<Offsets>& starts);

}  // namespace surveymc::chained
