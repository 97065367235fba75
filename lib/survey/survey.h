#pragma once
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "survey/frames.h"

namespace surveymc::survey {

/// One survey station. Azimuth is from true north, toolface from the tool's y axis; radians and metres.
struct Station {
  double md = 0;
  double inclination = 0, azimuth = 0, toolface = 0;
};

/// Two measured depths that differ by less (m) are one depth: 1100 ft are 335.28000000000003 m, and a user writes
/// 335.28. The rule for stations, kick-offs, ends of intervals, tie-ons and depths that a config lists.
inline constexpr double kSameDepth = 0.001;
inline bool is_same_depth(double a, double b) { return std::abs(a - b) < kSameDepth; }
inline bool is_deeper(double md, double than) { return md - than >= kSameDepth; }

/// A well path as measured: stations of strictly increasing measured depth, the first is the tie-on.
struct Survey {
  std::vector<Station> stations;

  int size() const { return static_cast<int>(stations.size()); }
  std::vector<double> md() const;
};

/// Directions of the hole at all stations, in N, true north.
std::vector<Vec3<double>> true_tangents(const Survey& survey);

/// A fault of a survey, for a message; empty if there is none. Rules: at least two stations, measured depth
/// strictly increasing, inclination in [0, 180] deg, dogleg between neighbours below 180 deg.
struct SurveyDefect {
  int station = -1;  ///< index of the offending station; -1 if the survey as a whole
  std::string quantity, rule;
};
SurveyDefect find_defect(const Survey& survey);

/// The station at a measured depth (m), the nearest if there are several; nothing if there is none.
std::optional<std::size_t> station_at(const Survey& survey, double md);
/// A measured depth (m) of a config as the survey has it: that of the station there, or the depth itself between
/// stations; nothing beyond the ends of the survey.
std::optional<double> depth_on(const Survey& survey, double md);

/// Attitude of a station relative to magnetic north.
inline Attitude magnetic_attitude(const Station& s, double declination) {
  return {s.inclination, s.azimuth - declination, s.toolface};
}

}  // namespace surveymc::survey
