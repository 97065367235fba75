#include "survey/survey.h"

#include <catch2/catch.hpp>

using namespace surveymc::survey;

TEST_CASE("Depths within a millimetre are one depth, that of the station") {
  const double foot = 0.3048;
  const Survey s{{{0, 0, 0, 0}, {600 * foot, 0, 0, 0}, {1100 * foot, 0.1, 0, 0}}};
  CHECK(1100 * foot != 335.28);
  CHECK(station_at(s, 335.28) == 2);
  CHECK(station_at(s, 182.8805) == 1);
  CHECK(station_at(s, -0.0009) == 0);
  CHECK_FALSE(station_at(s, 182.8811));
  CHECK_FALSE(station_at(s, 400));
  CHECK(depth_on(s, 335.28) == 1100 * foot);
  CHECK(depth_on(s, 335.2809) == 1100 * foot);
  CHECK(depth_on(s, 200) == 200.0);
  CHECK_FALSE(depth_on(s, 335.2811));
  CHECK_FALSE(depth_on(s, -0.0011));
  for (const double md : {182.879, 182.8791, 182.8809, 182.881, 183.0}) {
    CHECK(is_deeper(md, 182.88) == (md > 182.88 && !is_same_depth(md, 182.88)));
    CHECK(is_deeper(182.88, md) == (md < 182.88 && !is_same_depth(md, 182.88)));
  }
}
