#pragma once
#include <vector>

#include "survey/survey.h"

namespace surveymc::survey {

/// Figures by which a reader sees whether a survey is the one that was meant. Radians, metres.
struct SurveySummary {
  int stations = 0;
  double first_md = 0, last_md = 0;
  double largest_inclination = 0, largest_inclination_md = 0;
  double largest_severity = 0, largest_severity_md = 0;  ///< dogleg severity, rad/m, of the interval that ends there
};
SurveySummary summary_of(const Survey& survey);

/// Angle that the hole turns by between two stations, rad, in [0, pi]; accurate to the last digits when small.
double dogleg(const Station& a, const Station& b);
/// dogleg() of every station and the one before; 0 for the first.
std::vector<double> doglegs(const Survey& survey);

}  // namespace surveymc::survey
