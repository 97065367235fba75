#include "config/survey_checks.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/survey_csv.h"
#include "survey/survey_summary.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Matchers::Contains;

namespace {

std::vector<SurveyFinding> findings(const std::string& rows, const std::string& md = "md_m") {
  const InputTable table = parse_csv(md + ",inclination_deg,azimuth_deg\n" + rows, "w.csv");
  return unusual_in_survey(table, survey_from_table(table, {}, false));
}
SurveyFinding only(const std::string& rows, const std::string& md = "md_m") {
  const std::vector<SurveyFinding> all = findings(rows, md);
  REQUIRE(all.size() == 1);
  return all.front();
}

}  // namespace

TEST_CASE("An ordinary survey has nothing unusual, a tie-on far above and a vertical hole included") {
  CHECK(findings("0,0,0\n30,1,10\n60,2,360\n90,3,11\n").empty());
  CHECK(findings("0,0,0\n3000,1,10\n3030,2,10\n3060,3,11\n").empty());
  CHECK(findings("0,0,0\n30,0.1,1\n60,0.15,2\n90,0.1,3\n").empty());  // vertical: azimuths may be small
  CHECK(findings("0,0,0\n30,2,3\n60,2.5,3\n90,3,3\n").empty());       // one azimuth tells nothing
  CHECK(findings("0,0,0\n30,1,10\n30.1,1.5,10\n60,2,10\n").empty());  // noise between close stations
}

TEST_CASE("Azimuths outside [0, 360] are refused with what they may stand for") {
  const SurveyFinding f = only("0,0,0\n30,1,400\n60,2,40\n");
  CHECK(f.is_refused);
  CHECK(f.in_words() == "w.csv:3: azimuth_deg = 400: must be in [0, 360]: 40 if no digit is wrong");
  CHECK_THAT(only("0,0,0\n30,1,-10\n60,2,350\n").in_words(), Contains("azimuth_deg = -10") && Contains("350 if"));
}

TEST_CASE("Radians are refused") {
  const SurveyFinding f = only("0,0,0\n30,0.3,1.1\n60,0.32,1.2\n90,0.35,1.3\n");
  CHECK(f.is_refused);
  CHECK_THAT(f.in_words(),
             Contains("no inclination is larger than 0.35, and no azimuth than 1.3: these look like radians"));
  const SurveyFinding azimuths = only("0,0,5.1\n30,3,5.1\n60,6,5.2\n90,9,5.3\n");
  CHECK_FALSE(azimuths.is_refused);
  CHECK(azimuths.in_words() ==
        "w.csv: column azimuth_deg: no azimuth is larger than 5.3: does the well go due north, or are these radians, "
        "which must be degrees?");
  CHECK(findings("0,0,5.1\n30,3,5.1\n60,6,5.2\n90,9,6.5\n").empty());
}

TEST_CASE("A dogleg that no tool drills is a warning, a hole that turns back is refused") {
  const SurveyFinding f = only("0,0,0\n30,1,10\n60,41,10\n120,42,10\n");
  CHECK_FALSE(f.is_refused);
  CHECK_THAT(f.in_words(),
             Contains("w.csv:4: inclination_deg = 41, azimuth_deg = 10: the hole turns by 40 degrees in 30 m "
                      "(40 deg/30 m): no tool drills more than 30 deg/30 m"));
  CHECK_THAT(only("0,0,0\n100,1,10\n200,41,10\n400,42,10\n", "md_ft").in_words(),
             Contains("turns by 40 degrees in 100 ft (40 deg/100 ft): no tool drills more than 30.5 deg/100 ft"));
  const std::vector<SurveyFinding> back = findings("0,80,10\n3000,99.5,190\n");
  REQUIRE(back.size() == 1);
  CHECK(back.front().is_refused);
  CHECK_THAT(back.front().in_words(), Contains("179.5 degrees") && Contains("turn back on itself"));
}

TEST_CASE("Depths that no well has are refused, a step that looks like a typing error is a warning") {
  CHECK_THAT(only("-5,0,0\n30,1,10\n60,2,10\n").in_words(),
             Contains("w.csv:2: md_m = -5: measured depth counts from the drill floor"));
  const SurveyFinding deep = only("0,0,0\n10000,1,10\n20000,2,10\n");
  CHECK(deep.is_refused);
  CHECK_THAT(deep.in_words(),
             Contains("w.csv:4: md_m = 20000: no well is deeper than 16 km, unless these are feet (md_ft)"));
  CHECK(findings("0,0,0\n10000,1,10\n20000,2,10\n", "md_ft").empty());
  const SurveyFinding step = only("0,0,0\n30,1,10\n60,2,10\n90,3,10\n120,3,10\n15000,3,10\n");
  CHECK_FALSE(step.is_refused);
  CHECK_THAT(step.in_words(),
             Contains("w.csv:7: md_m = 15000: 14880 m beyond the station before, where 30 m are usual"));
}

TEST_CASE("Listed vertical depths that do not go with the stations are refused") {
  const auto with_tvd = [](const std::string& head, const std::string& rows) {
    const InputTable table = parse_csv(head + "\n" + rows, "w.csv");
    return unusual_in_survey(table, survey_from_table(table, {}, false));
  };
  const std::string feet = "md_ft,inclination_deg,azimuth_deg,tvd_", metres = "md_m,inclination_deg,azimuth_deg,tvd_";
  const std::string rows = "100,0,0,100\n400,0,0,400\n700,30,0,686.5\n";
  CHECK(with_tvd(feet + "ft", rows).empty());
  CHECK(with_tvd(metres + "m", rows).empty());
  CHECK(with_tvd(metres + "m", "100,0,0,-20\n400,0,0,280\n700,30,0,566.5\n").empty());  // below the sea: another datum
  CHECK(with_tvd(metres + "m", "100,0,0,100\n400,0,0,400\n700,30,0,659.8\n").empty());  // by tangents
  for (const auto& findings : {with_tvd(feet + "m", rows), with_tvd(metres + "ft", rows)}) {
    REQUIRE(findings.size() == 1);
    CHECK(findings.front().is_refused);
    CHECK_THAT(findings.front().in_words(),
               Contains("w.csv:3: tvd_") && Contains("(and 1 station more): are the units of depth right"));
  }
  CHECK(with_tvd(metres + "m", "0,30,0,0\n10,30,0,9\n20,30,0,18\n30,30,0,26\n").empty());  // in whole metres
  CHECK(with_tvd(metres + "m", "0,0,0,0\n30,0,0,-30\n60,30,0,-58.6\n").size() == 1);       // heights
  CHECK_THAT(
      with_tvd(metres + "m", "100,0,0,100\n400,0,0,40\n700,30,0,686.5\n").front().in_words(),
      Contains("w.csv:3: tvd_m = 40: -60 m below the station before, where the inclinations give 300 m over 300 m"));
}

TEST_CASE("A depth that does not increase names the one before where that is the likely error") {
  const auto read = [](const std::string& rows) { findings(rows); };
  CHECK_THROWS_WITH(
      read("0,0,0\n30,1,10\n600,2,10\n90,3,10\n"),
      "w.csv:5: md_m = 90: must be greater than the one before (600); or is that one, in line 4, the typing error?");
  CHECK_THROWS_WITH(read("0,0,0\n30,1,10\n60,2,10\n50,3,10\n"),
                    "w.csv:5: md_m = 50: must be greater than the one before (60)");
}

TEST_CASE("The doglegs of a survey are those of its neighbours, to the last bit") {
  survey::Survey survey;
  for (int k = 0; k < 40; ++k) survey.stations.push_back({30.0 * k, 0.07 * k, 6.2 - 0.3 * k, 0});
  const std::vector<double> angles = survey::doglegs(survey);
  REQUIRE(angles.size() == survey.stations.size());
  CHECK(angles[0] == 0);
  for (std::size_t k = 1; k < angles.size(); ++k)
    CHECK(angles[k] == survey::dogleg(survey.stations[k - 1], survey.stations[k]));
  CHECK(survey::doglegs({}).empty());
}

TEST_CASE("The summary of a survey has its depths, largest inclination and dogleg") {
  const survey::Survey s{
      {{100, 0, 0, 0}, {130, 3 * kDegree, 0, 0}, {190, 6 * kDegree, 0, 0}, {220, 5 * kDegree, 0, 0}}};
  const survey::SurveySummary x = survey::summary_of(s);
  CHECK(x.stations == 4);
  CHECK(x.first_md == 100);
  CHECK(x.last_md == 220);
  CHECK(x.largest_inclination == 6 * kDegree);
  CHECK(x.largest_inclination_md == 190);
  CHECK(x.largest_severity == Approx(3 * kDegree / 30).epsilon(1e-13));
  CHECK(x.largest_severity_md == 130);
  CHECK(survey::dogleg({0, 1e-9, 0, 0}, {1, 0, 0, 0}) == Approx(1e-9).epsilon(1e-7));
  CHECK(survey::dogleg({0, 80 * kDegree, 0.2, 0}, {1, 100 * kDegree, 0.2 + kPi, 0}) == Approx(kPi).epsilon(1e-13));
}
