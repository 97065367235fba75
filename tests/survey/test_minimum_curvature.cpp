#include "survey/minimum_curvature.h"

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "angles.h"
#include "base/units.h"
#include "simd/dual.h"
#include "survey/corrected_position.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::survey;

namespace {
/// The textbook ratio factor, in long double.
double exact_ratio(double half_dogleg) {
  const long double h = half_dogleg;
  return static_cast<double>(h == 0 ? 1.0L : tanl(h) / h);
}
}  // namespace

TEST_CASE("The ratio factor is tan(beta/2)/(beta/2) from straight to 170 degrees, 1 when straight") {
  for (const double dogleg : {0.0, 1e-9, 1e-5, 1e-3, 0.1, 1.0, 10.0, 59.999, 60.001, 90.0, 150.0, 170.0}) {
    const double h = dogleg * kDegree / 2, s = std::sin(h) * std::sin(h);
    CAPTURE(dogleg);
    // s carries a rounding of 1e-16, which 1/(1-s) amplifies
    CHECK(std::abs(ratio_factor(s) / exact_ratio(h) - 1) < 2e-15 / (1 - s));
    CHECK(simd::lane(ratio_factor(simd::Lanes(s)), 2) == ratio_factor(s));
  }
  CHECK(ratio_factor(0.0) == 1);
}

TEST_CASE("The slope of the ratio factor agrees with dual numbers on both sides of the series") {
  using D = simd::Dual<double, 1>;
  for (const double s : {0.0, 1e-12, 9.9e-5, 1.01e-4, 1e-3, 0.1, 0.2499, 0.2501, 0.6, 0.95}) {
    CAPTURE(s);
    CHECK(ratio_factor_slope(s) == Approx(ratio_factor(D::variable(s, 0)).d[0]).epsilon(1e-9));
  }
}

TEST_CASE("A quarter circle has the displacement of a quarter circle") {
  // From vertical down to horizontal north over an arc of radius R: R north, R down.
  const double r = 300;
  const Vec3<double> d = minimum_curvature_interval(r * kPi / 2, {0, 0, 1}, {1, 0, 0});
  CHECK(std::abs(d.x - r) < 1e-12 * r);
  CHECK(d.y == 0);
  CHECK(std::abs(d.z - r) < 1e-12 * r);
}

TEST_CASE("A straight leg is as long as its measured depth; legs add up when an arc is split") {
  const Vec3<double> t = tangent_N({33 * kDegree, 217 * kDegree, 0});
  const Vec3<double> d = minimum_curvature_interval(123.4, t, t);
  CHECK(std::abs(norm(d) - 123.4) < 1e-13);
  // A circular arc in one plane, in one leg or in ten
  std::vector<double> md;
  std::vector<Vec3<double>> tangents;
  for (int k = 0; k <= 10; ++k) {
    md.push_back(10.0 * k);
    tangents.push_back(tangent_N({(20 + 4.0 * k) * kDegree, 75 * kDegree, 0}));
  }
  const Eigen::Vector3d split = minimum_curvature_positions(md, tangents).back();
  const Eigen::Vector3d whole = to_eigen(minimum_curvature_interval(100.0, tangents.front(), tangents.back()));
  CHECK((split - whole).norm() < 1e-11);
}

TEST_CASE("Final positions of thesis tests 3 and 4") {
  for (const auto& [number, expected] : {std::pair(3, Eigen::Vector3d(661.87623463, 647.22959347, 2654.08096905)),
                                         {4, Eigen::Vector3d(1216.08259216, 639.61278791, 1494.59138170)}}) {
    const Eigen::Vector3d p = minimum_curvature_positions(test::thesis_case(number).survey).back();
    for (int i = 0; i < 3; ++i) CHECK(std::abs(p[i] - expected[i]) < 1e-8);
  }
}

TEST_CASE("Balanced tangential is shorter than minimum curvature by the ratio factor") {
  const Survey s{{{0, 0, 0, 0}, {100, 20 * kDegree, 0, 0}}};
  const Eigen::Vector3d mc = minimum_curvature_positions(s).back(), bt = test::balanced_tangential_positions(s).back();
  CHECK(mc.norm() / bt.norm() == Approx(exact_ratio(10 * kDegree)).epsilon(1e-14));
}

TEST_CASE("Derivatives of a leg agree with dual numbers, also for a straight one") {
  using D = simd::Dual<double, 6>;
  for (const double turn : {0.0, 1e-7, 3.0, 40.0, 100.0}) {
    const Vec3<double> from = tangent_N({30 * kDegree, 40 * kDegree, 0});
    const Vec3<double> to = tangent_N({(30 + turn) * kDegree, (40 + turn / 2) * kDegree, 0});
    const Vec3<D> df{D::variable(from.x, 0), D::variable(from.y, 1), D::variable(from.z, 2)};
    const Vec3<D> dt{D::variable(to.x, 3), D::variable(to.y, 4), D::variable(to.z, 5)};
    const Vec3<D> leg = minimum_curvature_interval(D(80.0), df, dt);
    const IntervalDerivatives d = minimum_curvature_derivatives(80, from, to);
    const D rows[3] = {leg.x, leg.y, leg.z};
    CAPTURE(turn);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        CHECK(std::abs(d.by_from(i, j) - rows[i].d[static_cast<std::size_t>(j)]) < 80 * 1e-9);
        CHECK(std::abs(d.by_to(i, j) - rows[i].d[static_cast<std::size_t>(3 + j)]) < 80 * 1e-9);
      }
  }
}

TEST_CASE("Derivative of the final position by each tangent agrees with differences") {
  const Survey s = test::thesis_case(4).survey;
  std::vector<Vec3<double>> t;
  for (const Station& st : s.stations) t.push_back(tangent_N({st.inclination, st.azimuth, 0}));
  const auto d = final_position_by_tangent(s.md(), t);
  const double h = 1e-6;
  for (const std::size_t k : {std::size_t{0}, std::size_t{20}, t.size() - 1}) {
    const Station st = s.stations[k];
    const auto at = [&](double di, double da) {
      auto moved = t;
      moved[k] = tangent_N({st.inclination + di, st.azimuth + da, 0});
      return minimum_curvature_positions(s.md(), moved).back();
    };
    const Eigen::Vector3d by_i = (at(h, 0) - at(-h, 0)) / (2 * h), by_a = (at(0, h) - at(0, -h)) / (2 * h);
    // central differences: h^2 truncation and 1e-16 * 2000 m / h rounding
    CHECK((d[k] * test::tangent_by_inclination(st.inclination, st.azimuth) - by_i).norm() < 1e-5);
    CHECK((d[k] * test::tangent_by_azimuth(st.inclination, st.azimuth) - by_a).norm() < 1e-5);
  }
}

TEST_CASE("Corrected positions of error-free readings are the survey's own") {
  for (int number = 1; number <= 4; ++number) {
    const test::ThesisCase c = test::thesis_case(number);
    const ReadingBlock block = test::simulated(c, {}, 5, random::Stream(1, 1));
    LaneArray parameters(1, 6), position(1, 3);
    for (int i = 0; i < 6; ++i) parameters.fill(0, i, test::true_parameters(c)[i]);
    corrected_final_positions(block, parameters, c.survey.md(), c.field.declination, position);
    const Eigen::Vector3d exact = minimum_curvature_positions(c.survey).back();
    for (int i = 0; i < 3; ++i)
      for (int t = 0; t < 5; ++t) CHECK(std::abs(position.value(t, i) - exact[i]) < 1e-9);
  }
}

TEST_CASE("A survey's defects are found, the first one first") {
  const auto defect = [](std::vector<Station> s) { return find_defect(Survey{std::move(s)}); };
  CHECK(defect({{0, 0, 0, 0}}).quantity == "stations");
  CHECK(defect({{0, 0, 0, 0}, {0, 0, 0, 0}}).station == 1);
  CHECK(defect({{0, 0, 0, 0}, {-1, 0, 0, 0}}).quantity == "md");
  CHECK(defect({{0, 0, 0, 0}, {1, -0.1, 0, 0}}).quantity == "inclination");
  CHECK(defect({{0, 0, 0, 0}, {1, 4, 0, 0}}).quantity == "inclination");
  CHECK(defect({{0, kPi / 2, 0, 0}, {1, kPi / 2, kPi, 0}}).rule.find("180") != std::string::npos);
  CHECK(defect({{0, 0, 0, 0}, {1, 0, 0, 0}, {5, kPi, 0, 0}}).station == 2);
  CHECK(defect({{0, 0, 0, 0}, {1e-3, kPi / 2, 7, 9}}).rule.empty());
  CHECK(defect({{0, 0, 0, 0}, {0.9e-3, 0, 0, 0}}).rule.find("within 1 mm") != std::string::npos);
}
