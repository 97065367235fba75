#include "survey/interpolated_survey.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using namespace surveymc::survey;

namespace {

Survey key_points() {
  Survey s;
  for (const auto& [md, inclination, azimuth] : std::vector<std::array<double, 3>>{
           {0, 0, 0}, {480, 0, 70}, {990, 40, 350}, {1500, 40, 350}, {2010, 95, 40}, {2025, 96, 41}, {2600, 90, 200}})
    s.stations.push_back({md, inclination * kDegree, azimuth * kDegree, 0});
  return s;
}

}  // namespace

TEST_CASE("Interpolated stations lie on the path of minimum curvature") {
  const Survey given = key_points();
  const InterpolatedSurvey dense = interpolated(given, 30);
  REQUIRE(find_defect(dense.survey).rule.empty());
  CHECK(longest_interval(dense.survey) <= 30);
  CHECK(interpolated_stations(given, 30) == dense.survey.size());
  const std::vector<Eigen::Vector3d> before = minimum_curvature_positions(given),
                                     after = minimum_curvature_positions(dense.survey);
  for (std::size_t k = 0; k < given.stations.size(); ++k) {
    const Station &a = given.stations[k], &b = dense.survey.stations[dense.given[k]];
    CHECK((a.md == b.md && a.inclination == b.inclination && a.azimuth == b.azimuth));  // the same bits
    CHECK((before[k] - after[dense.given[k]]).norm() < 1e-9);                           // rounding over 2600 m
  }
  // An arc turns evenly: neighbours within an interval enclose equal doglegs.
  const std::vector<Vec3<double>> t = true_tangents(dense.survey);
  for (std::size_t k = 1; k < given.stations.size(); ++k) {
    const double first = (to_eigen(t[dense.given[k - 1] + 1]) - to_eigen(t[dense.given[k - 1]])).norm();
    for (std::size_t i = dense.given[k - 1] + 1; i <= dense.given[k]; ++i)
      CHECK(std::abs((to_eigen(t[i]) - to_eigen(t[i - 1])).norm() - first) < 1e-12);
  }
}

TEST_CASE("A survey without long intervals stays as it is") {
  const Survey given = key_points();
  for (const double spacing : {1000.0, 575.0, 574.9995})
    CHECK(interpolated(given, spacing).survey.size() == given.size());
  CHECK(interpolated(given, 574).survey.size() == given.size() + 1);
}

TEST_CASE("Values between given stations follow the path, and meet the given ones") {
  const Survey given = key_points();
  const InterpolatedSurvey dense = interpolated(given, 100);
  const std::vector<double> along = true_vertical_depths(dense.survey);
  std::vector<double> listed = true_vertical_depths(given);
  const std::vector<double> same = interpolated_values(dense, listed, along);
  for (std::size_t i = 0; i < along.size(); ++i) CHECK(std::abs(same[i] - along[i]) < 1e-9);
  listed[2] += 6;  // as another method has it
  const std::vector<double> other = interpolated_values(dense, listed, along);
  CHECK(other[dense.given[2]] == listed[2]);
  const std::size_t middle = (dense.given[2] + dense.given[3]) / 2;
  const double share = (dense.survey.stations[middle].md - 990) / 510;
  CHECK(std::abs(other[middle] - along[middle] - 6 * (1 - share)) < 1e-9);
}
