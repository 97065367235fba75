#include "multistation/set_observability.h"

#include <cmath>
#include <functional>
#include <sstream>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "field.h"
#include "project_files.h"

using namespace surveymc;
using namespace surveymc::multistation;

namespace {

/// Attitude at share x of the run, in degrees; station k.
using Geometry = std::function<survey::Attitude(double x, int k)>;

constexpr int kStations = 61;
/// A toolface that goes round unevenly enough to have no period within the run.
double even(int k) { return 122.0 * k; }

std::vector<StationReadings> run_of(const Geometry& geometry) {
  std::vector<StationReadings> out;
  for (int k = 0; k < kStations; ++k) {
    survey::Attitude at = geometry(k / (kStations - 1.0), k);
    at = {at.inclination * kDegree, at.azimuth * kDegree, at.toolface * kDegree};
    out.push_back(readings_of({}, 9.80665 * survey::to_eigen(survey::down_T(at)),
                              survey::to_eigen(survey::magnetic_T(at, test::kTotal, test::kDip)),
                              reference_of(ResidualKind::survey, 9.80665, test::kTotal, test::kDip)));
  }
  return out;
}

SetObservability observe(const Geometry& geometry, const ParameterSet& set) {
  return set_observability(jacobian(run_of(geometry), {}, set, ResidualKind::survey, {0.006, 70, 70}), set,
                           default_priors());
}
SetObservability observe(const Geometry& geometry, const char* set) {
  return observe(geometry, ParameterSet::named(set));
}

const Geometry kStraight = [](double, int k) { return survey::Attitude{60, 45, even(k)}; };
const Geometry kStraightSlide = [](double, int) { return survey::Attitude{60, 45, 45}; };
const Geometry kBuild45 = [](double x, int k) { return survey::Attitude{90 * x, 45, even(k)}; };
const Geometry kBuildSlide = [](double x, int) { return survey::Attitude{90 * x, 45, 45}; };
const Geometry kBuild90 = [](double x, int k) { return survey::Attitude{90 * x, 90, even(k)}; };
const Geometry kTurn60 = [](double x, int k) { return survey::Attitude{60, 180 * x, even(k)}; };
const Geometry kTurn90 = [](double x, int k) { return survey::Attitude{90, 90 * x, even(k)}; };
const Geometry kVertical = [](double, int k) { return survey::Attitude{0.5, 45, even(k)}; };
const Geometry kRoll = [](double, int k) {  // directions on a spiral over the sphere
  return survey::Attitude{std::acos(1 - (2 * k + 1.0) / kStations) / kDegree, 137.508 * k, 100.0 * k};
};

/// Error of each parameter in a combination that has no effect, scaled to the largest.
void check_no_effect(const Geometry& geometry, const std::vector<std::pair<const char*, double>>& combination) {
  std::vector<std::string> names;
  for (const auto& [name, error] : combination) names.emplace_back(name);
  const ParameterSet set = ParameterSet::of(names);
  const Eigen::MatrixXd j = jacobian(run_of(geometry), {}, set, ResidualKind::survey, {0.006, 70, 70});
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(j.rows());
  double alone = 0;
  for (const auto& [name, error] : combination)
    for (int i = 0; i < set.size(); ++i)
      if (std::string(set[i].name) == name) {
        moved += error * j.col(i);
        alone = std::max(alone, (error * j.col(i)).norm());
      }
  CHECK(moved.norm() < 1e-12 * alone);
}

}  // namespace

TEST_CASE("Rank and what is learnt in nine geometries are those of the page") {
  const std::vector<std::pair<std::string, const Geometry*>> geometries{
      {"straight 60/45", &kStraight},      {"straight 60/45, slide", &kStraightSlide},
      {"building, azimuth 45", &kBuild45}, {"building, azimuth 45, slide", &kBuildSlide},
      {"building, azimuth 90", &kBuild90}, {"turn at 60", &kTurn60},
      {"horizontal turn", &kTurn90},       {"near vertical", &kVertical},
      {"all directions", &kRoll},
  };
  const std::string page = test::project_file("docs/studies/msa_parameters.md");
  for (const auto& [name, geometry] : geometries) {
    const std::size_t at = page.find("| " + name + " | ");
    CAPTURE(name);
    REQUIRE(at != std::string::npos);
    std::istringstream cells(page.substr(at + name.size() + 4));
    for (std::size_t i = 0; i < 5; ++i) {
      int rank = -1, learnt = -1;
      char bracket = 0;
      std::string end;
      cells >> rank >> bracket >> learnt >> end >> bracket;
      const SetObservability o = observe(*geometry, set_names()[i].c_str());
      CAPTURE(set_names()[i]);
      CHECK(o.rank == rank);
      CHECK(o.learnt == learnt);
    }
  }
}

TEST_CASE("Combinations without effect have their names") {
  const auto weakest = [](const Geometry& g, const char* set) {
    const ParameterSet s = ParameterSet::named(set);
    return combination_name(observe(g, s), s, 0);
  };
  CHECK(weakest(kStraight, "6") == "mbz against msz");
  CHECK(weakest(kTurn60, "12") == "abz against asz");
  CHECK(weakest(kTurn90, "15") == "asz");  // no gravity along the axis for it to scale
  CHECK(weakest(kTurn60, "18") == "abz against asz");
  CHECK(weakest(kVertical, "6") == "mbz against msz");
  CHECK(weakest(kBuild90, "12") == "abz against asz");
  CHECK(observe(kBuild90, "12").combinations.condition_indices[0] < 100);
  CHECK(weakest(kBuild45, "6") == "mbz against msz");
}

TEST_CASE("Law a: at constant inclination abz and asz are one, whatever the azimuth does") {
  const double g = 9.80665;
  check_no_effect(kTurn60, {{"abz", -g * std::cos(60 * kDegree)}, {"asz", 1}});
  check_no_effect(kStraight, {{"abz", -g * std::cos(60 * kDegree)}, {"asz", 1}});
  check_no_effect(kVertical, {{"abz", -g * std::cos(0.5 * kDegree)}, {"asz", 1}});
  // A building well tells them apart, a horizontal one that turns does not: asz has no effect there, abz has.
  CHECK(observe(kBuild45, "12").rank == 12);
  CHECK(observe(kTurn90, "12").rank == 11);
}

TEST_CASE("Law b: in a constant direction mbz and msz are one") {
  const survey::Attitude at{60 * kDegree, 45 * kDegree, 0};
  check_no_effect(kStraight, {{"mbz", -survey::magnetic_T(at, test::kTotal, test::kDip).z}, {"msz", 1}});
  CHECK(observe(kTurn60, "6").rank == 6);
}

TEST_CASE("Law c: in a slide a cross-axial bias of the magnetometers is a rotation") {
  // At toolface 45 the combination lies between the two axes: mbx - mby of it, and rx + ry.
  for (const Geometry& g : {kBuildSlide, kStraightSlide}) {
    const SetObservability nine = observe(g, "9"), six = observe(g, "6");
    CHECK(nine.rank - six.rank < 3);  // three more parameters, not three more combinations
    CHECK(nine.learnt == six.learnt);
  }
  // A well in the plane of the field whose tool does not turn against that plane: mbx, msx, ry and rz move the field
  // out of the plane alone, which to first order changes neither its horizontal nor its vertical component. None of the
  // four has any effect, whatever rounding says of north, south and a whole turn.
  for (const double azimuth : {0.0, 180.0, 360.0}) {
    const Geometry slide = [azimuth](double x, int) { return survey::Attitude{90 * x, azimuth, 0}; };
    const ParameterSet across = ParameterSet::of({"mbx", "msx", "ry", "rz"});
    CAPTURE(azimuth);
    CHECK(observe(slide, across).rank == 0);
    CHECK(observe(slide, "6").rank == 4);
  }
}

TEST_CASE("Law d: a magnetometer triad that is rolled about the hole is lost in straight and in vertical holes") {
  for (const Geometry& g : {kStraight, kVertical}) {
    const SetObservability nine = observe(g, "9"), six = observe(g, "6");
    CHECK(nine.rank == six.rank + 2);  // rx and ry alone
    CHECK(observe(g, ParameterSet::of({"mbx", "mby", "mbz", "rx", "ry", "rz"})).rank >= 5);
  }
  CHECK(observe(kBuild45, "9").rank == 9);
}
