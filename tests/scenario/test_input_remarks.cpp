#include "scenario/input_remarks.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config_text.h"
#include "scenario/drilling.h"
#include "scenario/scenario.h"
#include "sensor/sensor_runs.h"

using namespace surveymc;
using namespace surveymc::scenario;
using Catch::Matchers::Contains;

namespace {

const std::string kHeader = "md_m,inclination_deg,azimuth_deg\n";
const std::string kRows = "0,0,0\n30,1,10\n60,2,11\n90,3,12\n";
const random::StudySeed kSeed{7, random::StudyId::msa_position};

struct Told {
  survey::Survey survey;
  std::vector<config::Remark> remarks;
};

Told drilled(const std::string& body, const std::string& csv = kHeader + kRows,
             const std::string& seed = "seed = 7\n") {
  Told told;
  told.survey = test::read_config(seed + "[survey]\nfile = 'w.csv'\n" + body,
                                  [](config::ConfigReader& c) { return read_drilled_survey(c, {}, kSeed); },
                                  &told.remarks, {config::parse_csv(csv, "w.csv")});
  return told;
}
std::vector<double> toolfaces(const survey::Survey& s) {
  std::vector<double> t;
  for (const survey::Station& at : s.stations) t.push_back(at.toolface);
  return t;
}

}  // namespace

TEST_CASE("What was read of a survey is told in one line") {
  const Told told = drilled("[drilling]\nmode = 'rotating'");
  REQUIRE(told.remarks.size() == 1);
  CHECK_FALSE(told.remarks.front().is_warning);
  CHECK(told.remarks.front().text() ==
        "survey w.csv: 4 stations, measured depth 0 to 90 m, inclination up to 3 deg (at 90 m), dogleg "
        "up to 1 deg/30 m (at 90 m), azimuths from true north");
}

TEST_CASE("What is unusual in a survey is refused, or a warning where the config says that it is meant") {
  const std::string csv = kHeader + "0,0,0\n30,1,400\n60,2,40\n", mode = "[drilling]\nmode = 'rotating'";
  CHECK_THROWS_WITH(drilled(mode, csv),
                    "w.csv:3: azimuth_deg = 400: must be in [0, 360]: 40 if no digit is wrong; if the "
                    "survey is meant so, set survey.unusual = \"allow\"");
  CHECK_THROWS_WITH(drilled("unusual = 'refuse'\n" + mode, csv), Contains("must be in [0, 360]"));
  const Told told = drilled("unusual = 'allow'\n" + mode, csv);
  REQUIRE(told.remarks.size() == 2);
  CHECK(told.remarks.front().is_warning);
  CHECK_THAT(told.remarks.front().text(), Contains("w.csv:3: azimuth_deg = 400"));
  CHECK_THROWS_WITH(drilled("unusual = true\n" + mode), Contains("survey.unusual = true: must be one of"));
}

TEST_CASE("A survey without toolface is drilled as the config says") {
  const std::vector<double> even = toolfaces(drilled("[drilling]\nmode = 'rotating'").survey);
  for (std::size_t k = 0; k < even.size(); ++k)
    CHECK(even[k] == Approx(std::fmod(static_cast<double>(k) * kPi * (3 - std::sqrt(5.0)), 2 * kPi)).epsilon(1e-15));
  CHECK(toolfaces(drilled("[drilling]\nmode = 'sliding'").survey) == std::vector<double>(4, 0.0));
  CHECK(toolfaces(drilled("toolface_zero = 'x'\n[drilling]\nmode = 'sliding'\ntoolface_deg = 30").survey) ==
        std::vector<double>(4, 30 * kDegree + kPi / 2));
  CHECK(toolfaces(drilled("[drilling]\nmode = 'random'\nsequence = 5").survey) ==
        sensor::toolfaces_of_trial(survey::rotated(4), random::stream_of(kSeed), 5));
}

TEST_CASE("Without a mode the file's toolfaces are used, and a file without them is told the way out") {
  CHECK_THROWS_WITH(drilled(""), Contains("w.csv:1: column toolface_deg: missing") &&
                                     Contains("[drilling] mode = \"rotating\", \"sliding\" or \"random\""));
  const std::string with = "md_m,inclination_deg,azimuth_deg,toolface_deg\n0,0,0,10\n30,1,10,20\n";
  CHECK(toolfaces(drilled("toolface_zero = 'y'", with).survey) == std::vector<double>{10 * kDegree, 20 * kDegree});
  CHECK(toolfaces(drilled("toolface_zero = 'y'\n[drilling]\nmode = 'survey'\ntoolface_deg = 3", with).survey)[1] ==
        20 * kDegree);
  CHECK_THROWS_WITH(drilled("", with), Contains("survey.toolface_zero: missing"));
  CHECK_THROWS_WITH(drilled("[drilling]\nmode = 'gliding'"), Contains("drilling.mode = \"gliding\": must be one of"));
  CHECK_THROWS_WITH(drilled("[drilling]\nmode = 'random'", kHeader + kRows, ""), Contains("by the config's seed"));
}

TEST_CASE("Readings whose dip has the other sign than the reference are told so by name") {
  const auto told = [](double dip_deg, const std::string& body) {
    const double d = dip_deg * kDegree;
    survey::SixAxisReadings r;
    for (int k = 0; k < 3; ++k) {
      r.md.push_back(30.0 * k);
      r.gravity_T.push_back({0, 0, 9.8});
      r.magnetic_T.push_back({50000 * std::cos(d), 0, 50000 * std::sin(d)});
    }
    config::Config config =
        config::Config::from_text("experiment = 'e'\nreadings = 'r.csv'\n[field]\ntotal_nT = 50000\n" + body, "t.toml",
                                  {config::parse_csv("a\n1\n", "r.csv")});
    config::ConfigReader reader = config.reader(0);
    const survey::ReferenceField field = read_field(reader);
    remark_on_readings(reader, r, field);
    return config.remarks();
  };
  const std::vector<config::Remark> good = told(72, "dip_deg = 70");
  REQUIRE(good.size() == 1);
  CHECK(good.front().text() ==
        "readings r.csv: 3 stations, measured depth 0 to 60 m, mean gravity 9.8000 m/s2, total field "
        "50000 nT, dip 72.00 deg");
  const std::vector<config::Remark> bad = told(72, "dip_deg = -70");
  REQUIRE(bad.size() == 2);
  CHECK(bad.back().is_warning);
  CHECK_THAT(bad.back().text(),
             Contains("t.toml:5: field.dip_deg = -70: the readings have a dip of +72.00 deg, the reference "
                      "-70.00; a wrong sign of dip"));
  CHECK(told(2, "dip_deg = -3").size() == 1);  // at the magnetic equator the sign tells nothing
  CHECK(told(62, "dip_deg = 70").size() == 1);
  for (const double far : {59.0, 81.0, -1.0}) {  // columns that change places, or an axis its sign
    const std::vector<config::Remark> warned = told(far, "dip_deg = 70");
    REQUIRE(warned.size() == 2);
    CHECK(warned.back().is_warning);
    CHECK_THAT(warned.back().text(), Contains("the reference +70.00; columns in another order"));
  }
}
