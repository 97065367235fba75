#include "scenario/scenario.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "config_text.h"

using namespace surveymc;
using namespace surveymc::scenario;
using Catch::Matchers::Contains;

TEST_CASE("[survey.plan] is vertical, then built, then held to the bottom") {
  const auto planned = [](const std::string& more, bool needs_toolface = false) {
    return test::read_config("[survey.plan]\nkickoff_m = 100\ninclination_deg = 20\nazimuth_deg = 90\n" + more,
                             [&](config::ConfigReader& c) {
                               survey::Survey s = read_survey(c, {}, needs_toolface);
                               CHECK(read_true_vertical_depths(c, s).size() == s.stations.size());
                               return s;
                             });
  };
  const survey::Survey s = planned("md_m = 250\nspacing_m = 60\nbuild_deg_per_30m = 6");
  REQUIRE(s.size() == 6);
  CHECK(s.stations[5].md == 250);
  CHECK(s.stations[4].md == 240);
  CHECK(s.stations[1].inclination == 0);
  CHECK_THAT(s.stations[2].inclination, Catch::WithinRel(4 * kDegree, 1e-14));  // 20 m of 0.2 deg/m
  CHECK_THAT(s.stations[3].inclination, Catch::WithinRel(16 * kDegree, 1e-14));
  CHECK_THAT(s.stations[5].inclination, Catch::WithinRel(20 * kDegree, 1e-14));
  CHECK_THAT(s.stations[0].azimuth, Catch::WithinRel(90 * kDegree, 1e-14));
  CHECK(planned("md_m = 240\nspacing_m = 60").size() == 5);
  CHECK_THROWS_WITH(planned("md_m = 240", true), Contains("has no toolfaces, which this study needs"));
  CHECK_THROWS_WITH(planned("md_m = 240\nspacing_m = 900\nbuild_deg_per_30m = 6"), Contains("more than 90 deg"));
  CHECK_THROWS_WITH(planned("md_m = 1e9"), Contains("more than 100000 stations"));
}

namespace {
sensor::NoiseModel noise_of(const std::string& reference) {
  return test::read_config("seed = 1\n[noise]\nmagnetometer_nT = 50.0\nreference = " + reference,
                           [](config::ConfigReader& c) { return read_noise(c); });
}
}  // namespace

TEST_CASE("Sizes of the reference's noise need a word on when it is drawn") {
  const std::string rule =
      ": noise.reference.per is missing, which says when it is drawn: \"run\", \"station\", or \"none\" for never";
  CHECK_THROWS_WITH(noise_of("{ total_nT = 130.0, dip_deg = 0.2 }"), "t.toml:5: noise.reference.total_nT = 130" + rule);
  CHECK_THROWS_WITH(noise_of("{ dip_deg = 0.2 }"), "t.toml:5: noise.reference.dip_deg = 0.2" + rule);
  CHECK(noise_of("{ total_nT = 0.0 }").reference == sensor::ReferenceNoise::none);
  CHECK(noise_of("{ per = 'none', total_nT = 130.0, dip_deg = 0.2 }").reference_total == 0);
  CHECK(noise_of("{ per = 'run', total_nT = 130.0 }").reference_total == 130);
  CHECK(noise_of("'wmm2025'").reference_total > 0);
}
