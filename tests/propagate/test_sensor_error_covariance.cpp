#include "propagate/sensor_error_covariance.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "propagate/station_effects.h"
#include "propagate/toolface_independent.h"
#include "simd/dual.h"
#include "thesis_cases.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Matrix3d;
using surveymc::test::field_of;
using surveymc::test::largest_difference;
using surveymc::test::survey_of;

namespace {

const survey::SensorTermArray kIscwsaSizes = survey::equal_axes(0.004, 0.0005, 70, 0.0016);

/// Four stations through everything difficult: vertical, nearly so, horizontal, beyond, and a short leg.
std::vector<survey::Survey> difficult_surveys() {
  return {survey_of({{0, 0, 0}, {30, 0, 0}, {60, 0, 123}, {90, 1e-9 / kDegree, 77}}),
          survey_of({{0, 0, 0}, {30, 1e-9, 310}, {60, 1e-6, 10}, {61, 2, 75}}),
          survey_of({{100, 30, 350}, {130, 60, 5}, {139, 89, 20}, {170, 90, 90}}),
          survey_of({{0, 85, 180}, {300, 95, 190}, {600, 120, 270}, {604, 121, 271}}),
          survey_of({{0, 178, 20}, {25, 180, 0}, {50, 180, 90}, {75, 179, 200}})};
}

std::vector<Matrix3d> closed_form(const survey::Survey& survey, const survey::ReferenceField& field,
                                  ToolfacePropagation propagation) {
  return propagate_tangent_errors(survey.md(), true_tangents(survey),
                                  toolface_independent_errors(survey, field, kIscwsaSizes, propagation),
                                  survey::PositionMethod::minimum_curvature);
}

std::vector<Matrix3d> sensor_level(const survey::Survey& survey, const survey::ReferenceField& field,
                                   const survey::ToolfacePlan& plan) {
  return sensor_error_covariances(survey, field, kIscwsaSizes, plan, survey::PositionMethod::minimum_curvature);
}

/// Mean covariance over every combination of `points` toolfaces, one for each class of stations: stations with the same
/// number in `classes` share theirs.
std::vector<Matrix3d> brute_force_mean(const survey::Survey& survey, const survey::ReferenceField& field,
                                       const std::vector<std::size_t>& classes, int points) {
  const std::size_t dimensions = *std::max_element(classes.begin(), classes.end()) + 1;
  std::vector<int> index(dimensions, 0);
  std::vector<Matrix3d> mean(classes.size(), Matrix3d::Zero());
  int combinations = 0;
  for (bool more = true; more; ++combinations) {
    survey::ToolfacePlan plan = survey::constant_toolface(survey.size(), 0);
    for (std::size_t k = 0; k < classes.size(); ++k) plan.given[k] = 0.3 + 2 * kPi * index[classes[k]] / points;
    const auto c = sensor_level(survey, field, plan);
    for (std::size_t k = 0; k < c.size(); ++k) mean[k] += c[k];
    more = false;
    for (std::size_t d = 0; d < dimensions && !more; ++d) {
      more = ++index[d] < points;
      if (!more) index[d] = 0;
    }
  }
  for (Matrix3d& m : mean) m /= combinations;
  return mean;
}

}  // namespace

TEST_CASE("The tangent's derivatives by the twelve sensor errors agree with dual numbers, in the vertical too") {
  using D = simd::Dual<double, 12>;
  for (const double dip : {-60.0, 72.0})
    for (const survey::Attitude& at : test::difficult_attitudes()) {
      const survey::Vec3<double> g = scale(9.80665, survey::down_T(at)),
                                 b = survey::magnetic_T(at, 50000, dip * kDegree);
      const auto read = [](double v, std::size_t bias, std::size_t scale_error) {
        return (D(1.0) + D::variable(0, scale_error)) * D(v) + D::variable(0, bias);
      };
      const survey::Vec3<D> gm{read(g.x, 0, 3), read(g.y, 1, 4), read(g.z, 2, 5)},
          bm{read(b.x, 6, 9), read(b.y, 7, 10), read(b.z, 8, 11)};
      const survey::Vec3<D> t = survey::tangent_from_fields(scale(D(1.0) / norm(gm), gm), bm);
      const Matrix3x12d w = tangent_by_sensor_terms(g, b);
      const D rows[3] = {t.x, t.y, t.z};
      CAPTURE(dip, at.inclination, at.azimuth, at.toolface);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 12; ++j)  // weights are up to tan(dip) = 3: 30 roundings
          CHECK(std::abs(w(i, j) - rows[i].d[static_cast<std::size_t>(j)]) < 1e-14);
    }
}

TEST_CASE("Averaged over toolface, sensor errors are the TI terms, all S when slid") {
  for (const double dip : {-60.0, 0.0, 72.0})
    for (const survey::Survey& survey : difficult_surveys()) {
      const survey::ReferenceField field = field_of(50000, dip, 12);
      const auto terms = closed_form(survey, field, ToolfacePropagation::systematic);
      CAPTURE(dip, survey.stations[1].inclination);
      CHECK(largest_difference(brute_force_mean(survey, field, {0, 0, 0, 0}, 7), terms) < 1e-12);
      CHECK(largest_difference(sensor_level(survey, field, survey::slid(4)), terms) < 1e-12);
    }
}

TEST_CASE("Averaged over toolface, those TI terms that turn with it are R when rotated") {
  for (const double dip : {-60.0, 72.0})
    for (const survey::Survey& survey : difficult_surveys()) {
      const survey::ReferenceField field = field_of(50000, dip, -4);
      const auto terms = closed_form(survey, field, ToolfacePropagation::random);
      CAPTURE(dip, survey.stations[1].inclination);
      CHECK(largest_difference(brute_force_mean(survey, field, {0, 1, 2, 3}, 5), terms) < 1e-12);
      CHECK(largest_difference(sensor_level(survey, field, survey::rotated(4)), terms) < 1e-12);
    }
}

TEST_CASE("A slide within a rotated hole: its stations go together, the others alone") {
  const survey::ReferenceField field = field_of(50000, 72, -4);
  for (const survey::Survey& survey : difficult_surveys()) {
    const std::vector<double> md = survey.md();
    const survey::ToolfacePlan plan = survey::partly_slid(md, md[1], md[2]);
    CHECK(plan.first_slid() == 1);
    CHECK(largest_difference(sensor_level(survey, field, plan), brute_force_mean(survey, field, {0, 1, 1, 2}, 5)) <
          1e-12);
  }
}

TEST_CASE("The closed forms keep the whole chain: not one term alone, every one at every attitude") {
  // One size at a time, one station's leg: each kind's averaged outer product against its own terms.
  const double dips[] = {-75, 72};
  for (const double dip : dips)
    for (const survey::Attitude& at : test::difficult_attitudes()) {
      const survey::ReferenceField field = field_of(50000, dip, 0);
      const auto terms = toolface_independent_terms(at.inclination, at.azimuth, field);
      const double si = std::sin(at.inclination), ci = std::cos(at.inclination), sa = std::sin(at.azimuth),
                   ca = std::cos(at.azimuth);
      const Eigen::Vector3d high(ci * ca, ci * sa, -si), right(-sa, ca, 0);
      for (int kind = 0; kind < 12; kind += 3)
        for (const int axis : {0, 2}) {
          Matrix3d mean = Matrix3d::Zero(), closed = Matrix3d::Zero();
          for (int m = 0; m < 7; ++m) {
            const survey::Attitude turned{at.inclination, at.azimuth, at.toolface + 2 * kPi * m / 7};
            const Matrix3x12d w = tangent_by_sensor_terms(scale(field.gravity, survey::down_T(turned)),
                                                          survey::magnetic_T(turned, field.total, field.dip));
            for (int i = axis; i < (axis == 0 ? 2 : 3); ++i) mean += w.col(kind + i) * w.col(kind + i).transpose() / 7;
          }
          for (const ToolfaceIndependentTerm& t : terms)
            if (t.kind == kind && t.axis == axis) {
              const Eigen::Vector3d x = t.inclination * high + t.lateral * right;
              closed += x * x.transpose();
            }
          CAPTURE(dip, kind, axis, at.inclination, at.azimuth);
          CHECK((mean - closed).cwiseAbs().maxCoeff() < 1e-13 * std::max(mean.trace(), kind == 6 ? 4e-10 : 1e-2));
        }
    }
}

TEST_CASE("Positions of all stations in one pass are those of each station's own survey") {
  // final_position_effects is another derivation: by the last position's derivatives instead of along the hole.
  const test::ThesisCase c = test::thesis_case(4);
  const survey::ToolfacePlan plan = survey::surveyed_toolfaces(c.survey);
  const auto all =
      sensor_error_covariances(c.survey, c.field, kIscwsaSizes, plan, survey::PositionMethod::minimum_curvature);
  const auto fields = test::station_fields(c);
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> sd(kIscwsaSizes.data());
  for (const std::size_t last : {std::size_t{1}, std::size_t{20}, fields.size() - 1}) {
    std::vector<double> md = c.survey.md();
    md.resize(last + 1);
    const auto effects = final_position_effects(
        md, {fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(last) + 1}, c.field.declination);
    Matrix3x12d sum = Matrix3x12d::Zero();
    for (std::size_t k = 0; k <= last; ++k) {
      const Eigen::Vector3d u = survey::to_eigen(fields[k].down_T), b = survey::to_eigen(fields[k].field_T);
      const Matrix3d by_down = effects[k].by_down * (Matrix3d::Identity() - u * u.transpose()) / c.field.gravity;
      sum.middleCols<3>(0) += by_down;
      sum.middleCols<3>(3) += by_down * (c.field.gravity * u).asDiagonal();
      sum.middleCols<3>(6) += effects[k].by_field;
      sum.middleCols<3>(9) += effects[k].by_field * b.asDiagonal();
    }
    const Matrix3d expected = sum * sd.cwiseAbs2().asDiagonal() * sum.transpose();
    CHECK((all[last] - expected).cwiseAbs().maxCoeff() < 1e-12 * expected.trace());
  }
  CHECK(all[0] == Matrix3d::Zero());
}

TEST_CASE("The covariance goes continuously through the vertical, whatever the azimuth written there") {
  const survey::ReferenceField field = field_of(50000, 72, 0);
  const auto covariance = [&](double inclination, double azimuth) {
    const survey::Survey s = survey_of(5, [&](int k) { return survey::Station{30.0 * k, inclination, azimuth, 0}; });
    return sensor_level(s, field, survey::rotated(5)).back();
  };
  const Matrix3d vertical = covariance(0, 0);
  for (const double azimuth : {0.0, 1.0, 2.5, 6.0}) {
    CHECK((covariance(0, azimuth) - vertical).cwiseAbs().maxCoeff() < 1e-13 * vertical.trace());
    for (const double inclination : {1e-9, 1e-6})  // weights change by tan(dip) = 3 times the inclination
      CHECK((covariance(inclination, azimuth) - vertical).cwiseAbs().maxCoeff() < 20 * inclination * vertical.trace());
  }
}
