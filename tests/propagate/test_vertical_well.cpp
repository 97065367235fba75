#include "propagate/vertical_well.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "propagate/sensor_error_covariance.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Matrix2d;

namespace {

constexpr double kTilt = 0.004 / 9.80665;  // the memo's bias over gravity

const std::vector<double> kSequence{0.4, 3.3, 5.9, 1.2, 2.2, 4.0, 0.9, 3.7, 6.1, 5.0, 2.9};

double north(const Matrix2d& c) { return std::sqrt(c(0, 0)); }
double east(const Matrix2d& c) { return std::sqrt(c(1, 1)); }
bool is_circle(const Matrix2d& c) {
  return std::abs(c(0, 0) - c(1, 1)) < 1e-14 * c(0, 0) && std::abs(c(0, 1)) < 1e-14 * c(0, 0);
}

}  // namespace

TEST_CASE("The memo's exact values: 300 m, ten legs") {
  const std::vector<double> w = vertical_station_weights(10, 30);
  const TwoSources ti = toolface_independent_sources(w, kTilt);
  const Matrix2d slide = systematic_covariance(ti), rotation = random_covariance(ti);
  // sigma/G times 300 m, and times 30 m sqrt(9 + 2/4)
  CHECK(north(slide) == Approx(300 * kTilt).epsilon(1e-15));
  CHECK(north(slide) == Approx(.122366).epsilon(5e-6));
  CHECK(north(rotation) == Approx(.0377157).epsilon(2e-6));
  CHECK(north(slide) / north(rotation) == Approx(10 / std::sqrt(9.5)).epsilon(1e-15));
  CHECK(north(slide) / north(rotation) == Approx(3.2444).epsilon(2e-5));
  CHECK(is_circle(slide));
  CHECK(is_circle(rotation));
}

TEST_CASE("Every formulation of the memo, slid and rotated") {
  for (const int legs : {1, 2, 10, 30}) {
    const double spacing = 300.0 / legs, n = legs;
    const std::vector<double> w = vertical_station_weights(legs, spacing);
    std::vector<double> one(w.size(), 1.1), many;
    for (std::size_t k = 0; k < w.size(); ++k) many.push_back(0.2 * static_cast<double>(k));
    const double s = 300 * kTilt, r = spacing * std::sqrt(n - 0.5) * kTilt;
    const TwoSources spe = spe_67616_sources(w, kTilt), with = copegrove_sources(w, kTilt, true),
                     without = copegrove_sources(w, kTilt, false);
    CAPTURE(legs);
    CHECK(north(toolface_dependent_covariance(w, one, kTilt)) == Approx(s).epsilon(1e-14));
    CHECK(is_circle(toolface_dependent_covariance(w, one, kTilt)));
    CHECK(north(fictive_terms_covariance(w, one, one, kTilt)) == Approx(s).epsilon(1e-14));
    CHECK(north(fictive_terms_covariance(w, many, many, kTilt)) == Approx(r).epsilon(1e-14));
    CHECK(is_circle(fictive_terms_covariance(w, many, many, kTilt)));
    CHECK(north(systematic_covariance(spe)) == Approx(s).epsilon(1e-14));
    CHECK(is_circle(systematic_covariance(spe)));
    CHECK(systematic_covariance(with).isApprox(s * s * Matrix2d::Identity(), 1e-14));
    CHECK(random_covariance(with).isApprox(r * r * Matrix2d::Identity(), 1e-14));
    CHECK(as_drilled_covariance(with, one).isApprox(s * s * Matrix2d::Identity(), 1e-14));
    CHECK(as_drilled_covariance(with, many).isApprox(r * r * Matrix2d::Identity(), 1e-14));
    // Without dD/2 the east is small by 2 m over the spacing.
    CHECK(north(as_drilled_covariance(without, one)) == Approx(s).epsilon(1e-14));
    CHECK(east(as_drilled_covariance(without, one)) == Approx(s * 2 / spacing).epsilon(1e-14));
    CHECK(east(as_drilled_covariance(without, many)) == Approx(r * 2 / spacing).epsilon(1e-14));
  }
}

TEST_CASE("Fictive terms take their correlation from magnetic, not accelerometer toolfaces") {
  const std::vector<double> w = vertical_station_weights(10, 30);
  // Any bias: the accelerometers of a vertical hole read it and nothing else, however the pipe is turned.
  std::vector<double> accelerometer, magnetic;
  const survey::Vec3<double> bias{0.003, -0.001, 0};
  for (const double t : kSequence) {
    const survey::Attitude at{0, 0, t};
    const survey::Vec3<double> g = scale(9.80665, survey::down_T(at)) + bias,
                               b = survey::magnetic_T(at, 50000, 72 * kDegree);
    accelerometer.push_back(survey::attitude_from_fields(g, b).toolface);
    magnetic.push_back(magnetic_toolface(b));
    CHECK(magnetic.back() == Approx(t).epsilon(1e-13));
  }
  CHECK(north(fictive_terms_covariance(w, magnetic, magnetic, kTilt)) == Approx(.0377157).epsilon(2e-6));
  CHECK(north(fictive_terms_covariance(w, magnetic, accelerometer, kTilt)) == Approx(300 * kTilt).epsilon(1e-14));
}

TEST_CASE("The memo's formulas are the general ones, where the well is vertical") {
  const survey::Survey survey = test::survey_of(11, [](int k) { return survey::Station{30.0 * k, 0, 0, 0}; });
  const survey::ReferenceField field = test::field_of(50000, 72);
  const survey::SensorTermArray sd{0.004, 0.004};
  const std::vector<double> w = vertical_station_weights(10, 30);
  const auto general = [&](const survey::ToolfacePlan& plan) {
    return Matrix2d(sensor_error_covariances(survey, field, sd, plan, survey::PositionMethod::balanced_tangential)
                        .back()
                        .topLeftCorner<2, 2>());
  };
  survey::ToolfacePlan given = survey::constant_toolface(11, 0);
  given.given = kSequence;
  CHECK(general(given).isApprox(toolface_dependent_covariance(w, kSequence, kTilt), 1e-12));
  CHECK(general(survey::rotated(11)).isApprox(random_covariance(toolface_independent_sources(w, kTilt)), 1e-12));
  CHECK(general(survey::slid(11)).isApprox(systematic_covariance(toolface_independent_sources(w, kTilt)), 1e-12));
  std::vector<double> mixed = kSequence;
  for (std::size_t k = 5; k < 11; ++k) mixed[k] = 2.0;
  CHECK(general(survey::partly_slid(survey.md(), 150, 300))
            .isApprox(fictive_terms_covariance(w, mixed, mixed, kTilt), 1e-12));
}

TEST_CASE("Toolfaces are the same on the circle, not on the line") {
  CHECK(fictive_correlation(0, 2 * kPi) == 1);
  CHECK(fictive_correlation(1e-10, 2 * kPi - 1e-10) == 1);
  CHECK(fictive_correlation(0, kPi) == 0);
  CHECK(fictive_correlation(1, 1 + 1e-6) == 0);
}
