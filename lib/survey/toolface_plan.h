#pragma once
/// How the tool is turned at each station: slid or rotated.
#include <vector>

#include "survey/survey.h"

namespace surveymc::survey {

/// Source of a station's toolface.
enum class ToolfaceSource {
  given,  ///< known beforehand
  slide,  ///< one draw a run, shared by all stations of the slide
  own,    ///< a draw of its own in every run: the pipe was rotated in between
};

/// One source a station. Drawn toolfaces are uniform on the circle.
struct ToolfacePlan {
  std::vector<ToolfaceSource> source;
  std::vector<double> given;  ///< rad, from y; used where source is `given`

  int size() const { return static_cast<int>(source.size()); }
  bool has(ToolfaceSource s) const;
  /// Index of the first station with source `slide`, -1 if there is none.
  int first_slid() const;
};

/// The toolfaces of the survey's stations.
ToolfacePlan surveyed_toolfaces(const Survey& survey);
/// The same given toolface everywhere.
ToolfacePlan constant_toolface(int stations, double toolface);
/// One draw a run for all stations.
ToolfacePlan slid(int stations);
/// One draw for every station and run.
ToolfacePlan rotated(int stations);
/// Slid at the stations with slide_from <= md <= slide_to (metres, to kSameDepth), rotated elsewhere.
ToolfacePlan partly_slid(const std::vector<double>& md, double slide_from, double slide_to);

}  // namespace surveymc::survey
