#pragma once
/// Wells and field that the tests of pairs share.
#include <algorithm>

#include "survey/survey.h"
#include "tools.h"

namespace surveymc::test {

inline survey::ReferenceField field() { return field_of(50000, 70); }

/// Vertical, a build to 60 deg from station 10 on, then turning by `turn` deg a station.
inline survey::Survey well(int stations, double azimuth, double turn = 0) {
  return survey_of(stations, [&](int k) {
    return survey::Station{30.0 * k, std::clamp(3.0 * (k - 10), 0.0, 60.0) * kDegree,
                           (azimuth + (k > 20 ? turn * (k - 20) : 0)) * kDegree, 0};
  });
}

}  // namespace surveymc::test
