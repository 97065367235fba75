#include "scenario/drilling.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config_text.h"
#include "sensor/sensor_runs.h"

using namespace surveymc;
using namespace surveymc::scenario;
using Catch::Matchers::Contains;

namespace {

const std::vector<double> kDepths{0, 30, 60, 90, 120};

survey::ToolfacePlan plan_of(const std::string& body) {
  return test::read_config("seed = 1\n[drilling]\n" + body, [](config::ConfigReader& c) {
    return read_drilling(c, kDepths, 0.5, random::Stream(7, 3));
  });
}
survey::SensorTermArray sizes_of(const std::string& body) {
  return test::read_config("seed = 1\n[sensor_errors]\n" + body,
                           [](config::ConfigReader& c) { return read_sensor_errors(c); });
}

}  // namespace

TEST_CASE("Drilling modes become toolface plans") {
  using enum survey::ToolfaceSource;
  CHECK(plan_of("mode = 'sliding'").source == std::vector<survey::ToolfaceSource>(5, slide));
  CHECK(plan_of("mode = 'rotating'").source == std::vector<survey::ToolfaceSource>(5, own));
  const survey::ToolfacePlan constant = plan_of("mode = 'sliding'\ntoolface_deg = 90");
  CHECK(constant.source == std::vector<survey::ToolfaceSource>(5, given));
  for (const double t : constant.given) CHECK(t == Approx(kPi / 2 + 0.5).epsilon(1e-15));
  const survey::ToolfacePlan mixed = plan_of("mode = 'mixed'\nslide_from_m = 30\nslide_to_m = 75");
  CHECK(mixed.source == std::vector<survey::ToolfaceSource>{own, slide, slide, own, own});
}

TEST_CASE("A slide that begins or ends at a station has this station, whatever the rounding of its depth") {
  using enum survey::ToolfaceSource;
  const double foot = 0.3048;
  REQUIRE(1100 * foot > 335.28);  // as the depth of a survey in feet
  const std::vector<double> md{1000 * foot, 1100 * foot, 1200 * foot};
  CHECK(survey::partly_slid(md, 300, 335.28).source == std::vector<survey::ToolfaceSource>{slide, slide, own});
  CHECK(survey::partly_slid({304.8, 335.28, 365.76}, 1100 * foot, 400).source ==
        std::vector<survey::ToolfaceSource>{own, slide, slide});
  CHECK(survey::partly_slid(md, 300, 335.27).source == std::vector<survey::ToolfaceSource>{slide, own, own});
}

TEST_CASE("A fixed sequence has the toolfaces of that trial of the rotated well") {
  const survey::ToolfacePlan fixed = plan_of("mode = 'fixed_sequence'\nsequence = 12");
  CHECK(fixed.source == std::vector<survey::ToolfaceSource>(5, survey::ToolfaceSource::given));
  CHECK(fixed.given == sensor::toolfaces_of_trial(survey::rotated(5), random::Stream(7, 3), 12));
  CHECK(fixed.given != plan_of("mode = 'fixed_sequence'").given);
}

TEST_CASE("Keys of other modes may stand there, so that the mode can be swept; wrong ones are refused") {
  CHECK_NOTHROW(plan_of("mode = 'rotating'\ntoolface_deg = 3\nsequence = 2\nslide_from_m = 0\nslide_to_m = 9"));
  CHECK_THROWS_WITH(plan_of("mode = 'gliding'"), Contains("t.toml:4: drilling.mode") && Contains("must be one of"));
  CHECK_THROWS_WITH(plan_of("mode = 'mixed'\nslide_from_m = 30"), Contains("drilling.slide_to_m"));
  CHECK_THROWS_WITH(plan_of("mode = 'mixed'\nslide_from_m = 30\nslide_to_m = 30"),
                    Contains("t.toml:6: drilling.slide_to_m = 30: must be greater than slide_from_m"));
  CHECK_THROWS_WITH(plan_of("mode = 'mixed'\nslide_from_m = 31\nslide_to_m = 59"), Contains("no station lies between"));
  CHECK_THROWS_WITH(plan_of("mode = 'sliding'\ntoolface = 3"), Contains("toolface_deg"));
  CHECK_THROWS_WITH(plan_of("mode = 'fixed_sequence'\nsequence = -1"), Contains("drilling.sequence = -1"));
}

TEST_CASE("Sensor errors are sizes of kinds, times a multiplier, in the order of the terms") {
  const survey::SensorTermArray sd = sizes_of(
      "accelerometer_bias_mps2 = 0.004\naccelerometer_scale = 0.0005\nmagnetometer_bias_nT = 70\n"
      "magnetometer_scale = 0.0016\nmultiplier = 5");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(sd[survey::kAccelerometerBias + axis] == Approx(0.02).epsilon(1e-15));
    CHECK(sd[survey::kAccelerometerScale + axis] == Approx(0.0025).epsilon(1e-15));
    CHECK(sd[survey::kMagnetometerBias + axis] == Approx(350).epsilon(1e-15));
    CHECK(sd[survey::kMagnetometerScale + axis] == Approx(0.008).epsilon(1e-15));
  }
  CHECK(sizes_of("magnetometer_bias_nT = 70")[survey::kAccelerometerBias] == 0);
  CHECK_THROWS_WITH(sizes_of("magnetometer_bias_nT = -1"),
                    Contains("t.toml:4: sensor_errors.magnetometer_bias_nT = -1"));
  CHECK_THROWS_WITH(sizes_of("magnetometer_bias = 70"), Contains("magnetometer_bias_nT"));
  CHECK_THROWS_WITH(sizes_of("multiplier = 0"), Contains("sensor_errors.multiplier"));
}
