#include "config/survey_csv.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {
survey::Survey read(const std::string& text, const SurveyConventions& c = {}, bool needs_toolface = false) {
  return survey_from_table(parse_csv(text, "well.csv"), c, needs_toolface);
}
}  // namespace

TEST_CASE("A survey file is read in metres and feet, from any axis and any north") {
  const survey::Survey m = read("md_m,inclination_deg,azimuth_deg,toolface_deg\n0,0,10,20\n30,1,11,21\n");
  CHECK(m.stations[1].md == 30);
  CHECK(m.stations[1].inclination == Approx(1 * kDegree).epsilon(1e-13));
  CHECK(m.stations[1].azimuth == Approx(11 * kDegree).epsilon(1e-13));
  CHECK(m.stations[1].toolface == Approx(21 * kDegree).epsilon(1e-13));
  const std::string feet = "toolface_deg,azimuth_deg,md_ft,inclination_deg\n20,10,0,0\n21,11,100,1\n";
  SurveyConventions c{ToolfaceZero::x, AzimuthReference::magnetic, 5 * kDegree, 2 * kDegree};
  const survey::Survey f = read(feet, c);
  CHECK(f.stations[1].md == Approx(30.48).epsilon(1e-13));
  CHECK(f.stations[1].toolface == Approx((21 + 90) * kDegree).epsilon(1e-13));
  CHECK(f.stations[1].azimuth == Approx((11 + 5) * kDegree).epsilon(1e-13));
  c.azimuth_reference = AzimuthReference::grid;
  CHECK(read(feet, c).stations[1].azimuth == Approx((11 + 2) * kDegree).epsilon(1e-13));
}

TEST_CASE("A bad survey file is refused with its place, value and rule") {
  CHECK_THROWS_WITH(read("md_m,inclination_deg,azimuth_deg\n0,0,0\n30,1,0\n30,2,0\n"),
                    Equals("well.csv:4: md_m = 30: must be greater than the one before (30)"));
  CHECK_THROWS_WITH(read("md_m,inclination_deg,azimuth_deg\n0,0,0\n30,181,0\n"),
                    Equals("well.csv:3: inclination_deg = 181: must be in [0, 180] degrees"));
  CHECK_THROWS_WITH(read("md,inclination_deg,azimuth_deg\n0,0,0\n30,1,0\n"),
                    Equals("well.csv:1: column md: the unit is missing: write md_m or md_ft"));
  CHECK_THROWS_WITH(read("md_m,inclination_rad,azimuth_deg\n0,0,0\n30,1,0\n"),
                    Equals("well.csv:1: column inclination_rad: unknown unit: write inclination_deg"));
  CHECK_THROWS_WITH(read("md_m,inclination_deg,azimuth_deg,depth\n0,0,0,1\n30,1,0,1\n"),
                    StartsWith("well.csv:1: column depth: unknown column"));
  CHECK_THROWS_WITH(read("md_m,azimuth_deg\n0,0\n30,1\n"), Equals("well.csv:1: column inclination_deg: missing"));
  CHECK_THROWS_WITH(read("md_m,inclination_deg,azimuth_deg\n0,0,0\n30,1,0\n", {}, true),
                    StartsWith("well.csv:1: column toolface_deg: missing"));
  CHECK_THROWS_WITH(read("md_m,md_ft,inclination_deg,azimuth_deg\n0,0,0,0\n30,100,1,0\n"),
                    Equals("well.csv:1: column md_ft: the file has md twice"));
  CHECK_THROWS_WITH(read("md_m,inclination_deg,azimuth_deg\n0,0,0\n"),
                    Equals("well.csv: 1 station: a survey has at least two stations"));
  CHECK_THROWS_AS(read("md_m,inclination_deg,azimuth_deg\n0,90,0\n10,90,180\n"), InputError);
}
