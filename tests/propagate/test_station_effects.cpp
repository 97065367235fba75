#include "propagate/station_effects.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "angles.h"
#include "base/units.h"
#include "estimate/sensitivity.h"
#include "propagate/ellipse.h"
#include "sensor/magnetometer.h"
#include "simd/dual.h"
#include "survey/minimum_curvature.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::propagate;

namespace {

/// Single-axis azimuth weighting functions in the thesis frame, toolface T from x (thesis spec section 3).
Eigen::Vector3d azimuth_by_magnetometer(double inclination, double azimuth, double toolface_x, double bh) {
  const double si = std::sin(inclination), ci = std::cos(inclination), sa = std::sin(azimuth), ca = std::cos(azimuth),
               st = std::sin(toolface_x), ct = std::cos(toolface_x);
  return Eigen::Vector3d(-(ca * st + sa * ci * ct), -(ca * ct - sa * ci * st), -sa * si) / bh;
}

}  // namespace

TEST_CASE("The tangent's derivatives hold the azimuth weighting functions of the literature") {
  const double total = 51000, dip = 72 * kDegree;
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    const survey::StationFields s{survey::magnetic_T(at, total, dip), survey::down_T(at)};
    const Eigen::Vector3d weights =
        azimuth_by_magnetometer(at.inclination, at.azimuth, at.toolface - kPi / 2, total * std::cos(dip));
    const Eigen::Matrix3d expected = test::tangent_by_azimuth(at.inclination, at.azimuth) * weights.transpose();
    CHECK((tangent_derivatives(s).by_field - expected).cwiseAbs().maxCoeff() < 1e-18);  // 1/Bh is 6e-5
  }
}

TEST_CASE("The tangent's derivatives agree with dual numbers, in the vertical too") {
  using D = simd::Dual<double, 6>;
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    const survey::Vec3<double> b = survey::magnetic_T(at, 51000, 72 * kDegree), u = survey::down_T(at);
    const survey::StationFields s{b, u};
    // u moves on the unit sphere: two directions across it
    const survey::Vec3<double> axis =
        std::abs(u.x) < 0.9 ? survey::Vec3<double>{1, 0, 0} : survey::Vec3<double>{0, 1, 0};
    survey::Vec3<double> v = cross(u, axis);
    v = scale(1 / norm(v), v);
    const survey::Vec3<double> w = cross(u, v);
    const D p = D::variable(0, 3), q = D::variable(0, 4);
    const survey::Vec3<D> du{D(u.x) + p * D(v.x) + q * D(w.x), D(u.y) + p * D(v.y) + q * D(w.y),
                             D(u.z) + p * D(v.z) + q * D(w.z)};
    const survey::Vec3<D> db{D::variable(b.x, 0), D::variable(b.y, 1), D::variable(b.z, 2)};
    const survey::Vec3<D> t = survey::tangent_from_fields(du, db);
    const TangentDerivatives d = tangent_derivatives(s);
    const D rows[3] = {t.x, t.y, t.z};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) CHECK(std::abs(d.by_field(i, j) - rows[i].d[static_cast<std::size_t>(j)]) < 1e-17);
      CHECK(std::abs(d.by_down.row(i).dot(survey::to_eigen(v)) - rows[i].d[3]) < 1e-13);
      CHECK(std::abs(d.by_down.row(i).dot(survey::to_eigen(w)) - rows[i].d[4]) < 1e-13);
    }
  }
}

TEST_CASE("Position 3-sigma of the thesis spec: systematic, random") {
  struct Expected {
    int number;
    double systematic[3], random[3];
  };
  const Expected cases[] = {{3, {52.624080, 43.143098, .023706}, {16.855646, 12.214097, .038447}},
                            {4, {28.530837, 54.083387, .007115}, {4.596066, 8.722359, .017297}}};
  for (const Expected& x : cases) {
    const test::ThesisCase c = test::thesis_case(x.number);
    const auto fields = test::station_fields(c);
    const estimate::Matrix6d cov =
        estimate::error_covariance(estimate::sensitivity({}, {fields, c.errors.gain, c.errors.bias, c.field}), fields,
                                   {70, 0, 107, .16 * kDegree, false, 0, 0})
            .topLeftCorner<6, 6>();
    const auto effects = final_position_effects(c.survey.md(), fields, c.field.declination);
    std::vector<Matrix36d> by_error;
    for (std::size_t k = 0; k < effects.size(); ++k)
      by_error.push_back(magnetometer_error_effect(effects[k], fields[k], c.errors.gain));
    const estimate::Vector6d sd = cov.diagonal().cwiseSqrt();
    const Eigen::Matrix3d systematic = propagate_systematic(by_error, sd), random = propagate_random(by_error, sd);
    for (int i = 0; i < 3; ++i) {  // 1e-6 relative, or the last printed digit
      CHECK(std::abs(3 * std::sqrt(systematic(i, i)) - x.systematic[i]) < std::max(1e-6 * x.systematic[i], 6e-7));
      CHECK(std::abs(3 * std::sqrt(random(i, i)) - x.random[i]) < std::max(1e-6 * x.random[i], 6e-7));
    }
  }
}

TEST_CASE("Effects turn with declination: the covariance is that of the turned well") {
  // The tool sees magnetic north only. With declination the same readings belong to a well turned by it.
  test::ThesisCase c = test::thesis_case(4);
  const auto fields = test::station_fields(c);
  const auto straight = final_position_effects(c.survey.md(), fields, 0);
  const double declination = 25 * kDegree;
  const auto turned = final_position_effects(c.survey.md(), fields, declination);
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  r.topLeftCorner<2, 2>() << std::cos(declination), -std::sin(declination), std::sin(declination),
      std::cos(declination);
  for (const std::size_t k : {std::size_t{0}, std::size_t{30}}) {
    CHECK((turned[k].by_field - r * straight[k].by_field).cwiseAbs().maxCoeff() < 1e-15);
    CHECK((turned[k].by_down - r * straight[k].by_down).cwiseAbs().maxCoeff() < 1e-10);
  }
}

TEST_CASE("An ellipse has the covariance's eigenvectors as axes and its azimuth is clockwise from north") {
  for (const double azimuth : {0.0, 1e-9, 30.0, 90.0, 135.0, 179.0}) {
    const double a = azimuth * kDegree;
    Eigen::Matrix2d q;
    q << std::cos(a), -std::sin(a), std::sin(a), std::cos(a);  // columns: major, minor (north, east)
    const Eigen::Matrix2d c = q * Eigen::Vector2d(9.0, 0.25).asDiagonal() * q.transpose();
    const Ellipse e = ellipse(c);
    CAPTURE(azimuth);
    CHECK(e.semi_major == Approx(3).epsilon(1e-14));
    CHECK(e.semi_minor == Approx(0.5).epsilon(1e-13));
    const double difference = std::remainder(e.azimuth - a, kPi);
    CHECK(std::abs(difference) < 1e-14);
    CHECK((c * e.axes.col(0) - 9 * e.axes.col(0)).norm() < 1e-14);
    CHECK((c * e.axes.col(1) - 0.25 * e.axes.col(1)).norm() < 1e-14);
  }
  CHECK(ellipse(Eigen::Matrix2d::Zero()).semi_major == 0);
  const Eigen::Matrix2d circle = (Eigen::Matrix2d() << 2, 1e-16, 1e-16, 2 - 4e-16).finished();
  CHECK(ellipse(circle).azimuth == 0);  // rounding does not choose a direction
  CHECK(ellipse(circle).axes == Eigen::Matrix2d::Identity());
  CHECK(ellipse_coverage(1) == Approx(0.3934693402873666).epsilon(1e-15));
  CHECK(ellipse_coverage(3) == Approx(0.9888910034617577).epsilon(1e-15));
}

TEST_CASE("Where there is no covariance an ellipse and an ellipsoid have no axes, not ones of no length") {
  for (const double none : {kNaN, static_cast<double>(INFINITY)}) {
    for (const double off_diagonal : {0.0, none}) {
      Eigen::Matrix3d c = Eigen::Vector3d(none, none, 4).asDiagonal();
      c(0, 2) = c(2, 0) = off_diagonal;
      const Ellipse flat = ellipse(c.topLeftCorner<2, 2>());
      CHECK(std::isnan(flat.semi_major));
      CHECK(std::isnan(flat.semi_minor));
      CHECK(std::isnan(flat.azimuth));
      CHECK(flat.axes.array().isNaN().all());
      CHECK(ellipsoid(c).semi_axes.array().isNaN().all());
      CHECK(ellipsoid(c).axes.array().isNaN().all());
    }
  }
}

TEST_CASE("An ellipsoid has the covariance's eigenvectors as axes, largest first, pointing down") {
  const Eigen::Matrix3d q = survey::rotation_hla_from_nev(0.7, 2.0);  // any rotation
  for (const Eigen::Vector3d& sd :
       {Eigen::Vector3d(1, 5, 2), Eigen::Vector3d(3, 3, 0.1), Eigen::Vector3d(4, 1e-9, 2)}) {
    const Eigen::Matrix3d c = q.transpose() * sd.cwiseAbs2().asDiagonal() * q;
    const Ellipsoid e = ellipsoid(c);
    for (int i = 0; i < 3; ++i) {
      const double variance = e.semi_axes[i] * e.semi_axes[i];
      CHECK((c * e.axes.col(i) - variance * e.axes.col(i)).norm() < 1e-14 * c.trace());
      CHECK(e.axes(2, i) >= 0);
      if (i > 0) CHECK(e.semi_axes[i] <= e.semi_axes[i - 1]);
    }
    CHECK(e.semi_axes.squaredNorm() == Approx(c.trace()).epsilon(1e-13));
  }
  CHECK(ellipsoid(q.transpose() * Eigen::Vector3d(4, 0, 2).asDiagonal() * q).semi_axes[2] == 0);
  // A vertical hole: N and E are equal but for rounding, and stay N and E.
  Eigen::Matrix3d vertical = Eigen::Vector3d(2, 2 + 4e-16, 9).asDiagonal();
  vertical(0, 1) = vertical(1, 0) = 1e-17;
  const Ellipsoid e = ellipsoid(vertical);
  CHECK(e.axes.col(0) == Eigen::Vector3d::UnitZ());
  CHECK(e.axes.col(1) == Eigen::Vector3d::UnitX());
  CHECK(e.axes.col(2) == Eigen::Vector3d::UnitY());
  CHECK(ellipsoid(Eigen::Matrix3d::Zero()).semi_axes == Eigen::Vector3d::Zero());
  // Of a level axis the end between 0 and 180 deg: rounding of vertical correlations must not choose it.
  for (const double azimuth : {0.3, 1.5, 2.9})
    for (const double rounding : {-1e-15, 1e-15}) {
      const Eigen::Vector3d level(std::cos(azimuth), std::sin(azimuth), 0), across(-level.y(), level.x(), 0);
      Eigen::Matrix3d c = 9 * level * level.transpose() + 4 * across * across.transpose();
      c(2, 2) = 1;
      c(0, 2) = c(2, 0) = c(1, 2) = c(2, 1) = rounding;
      const Ellipsoid body = ellipsoid(c);
      CHECK((body.axes.col(0) - level).norm() < 1e-12);
      CHECK(body.axes(1, 1) > 0);
    }
}
