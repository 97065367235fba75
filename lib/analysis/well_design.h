#pragma once
/// The section of a well whose stations go into one multi-station analysis (study `msa_benefit`).
#include "random/study_id.h"
#include "survey/survey.h"

namespace surveymc::analysis {

enum class WellKind {
  straight,  ///< every station has the same direction
  building,  ///< vertical first, then at a constant rate to the direction of the last station
};

/// How the tool is turned from station to station.
enum class ToolfaceSequence {
  even,      ///< by the golden angle, 137.5 deg: any number of stations is spread evenly round the tool
  random,    ///< uniform, independent, the same for every direction and every point of a sweep
  constant,  ///< 0: a slide
};

struct WellDesign {
  WellKind kind = WellKind::straight;
  int stations = 30;      ///< at least 2
  double spacing = 30;    ///< m
  double build_rate = 0;  ///< rad/m, of a building well
  ToolfaceSequence toolface = ToolfaceSequence::even;
  random::StudySeed seed = {};  ///< of random toolfaces
};

/// The last station has this inclination and azimuth (rad, true north). A building well has inclination
/// max(0, inclination - build_rate * distance to the last station), and one azimuth.
survey::Survey make_well(const WellDesign& design, double inclination, double azimuth);

}  // namespace surveymc::analysis
