#include "propagate/corrected_well_covariance.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "survey/minimum_curvature.h"
#include "survey/survey.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Matrix3d;
using Eigen::MatrixXd;

TEST_CASE("Azimuth derivatives are those of the attitude, by central differences") {
  const double total = 51000, dip = 72 * kDegree;
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    if (std::sin(at.inclination) < 1e-3) continue;  // the vertical has a test of its own
    const survey::Vec3<double> b = survey::magnetic_T(at, total, dip), u = survey::down_T(at);
    const AzimuthDerivatives d = azimuth_derivatives({b, u});
    const auto azimuth = [](const survey::Vec3<double>& down, const survey::Vec3<double>& field) {
      return survey::attitude_from_fields(scale(1 / norm(down), down), field).azimuth;
    };
    const Eigen::Vector3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
      const survey::Vec3<double> e = survey::from_eigen(axes[i]);
      const double h = 5;  // nT: third-order term (5 / 16000)^2 of the derivative, 1 / 16000 per nT
      const double by_field =
          std::remainder(azimuth(u, b + scale(h, e)) - azimuth(u, b - scale(h, e)), 2 * kPi) / (2 * h);
      CHECK(std::abs(by_field - d.by_field[i]) < 1e-7 / (total * std::cos(dip)) + 1e-13);
      // along e, less its part along u
      const survey::Vec3<double> across = e - scale(dot(e, u), u);
      const double t = 1e-5 * std::sin(at.inclination);
      const double by_down =
          std::remainder(azimuth(u + scale(t, across), b) - azimuth(u - scale(t, across), b), 2 * kPi) / (2 * t);
      CHECK(by_down ==
            Approx(d.by_down.dot(survey::to_eigen(across))).epsilon(1e-6).margin(1e-6 / std::sin(at.inclination)));
    }
  }
}

TEST_CASE("In a vertical hole the azimuth follows the field as everywhere, and no down direction") {
  for (const double toolface : {0.0, 50.0, 180.0}) {
    const survey::Attitude at{0, 70 * kDegree, toolface * kDegree};
    const AzimuthDerivatives d = azimuth_derivatives({survey::magnetic_T(at, 51000, 72 * kDegree), survey::down_T(at)});
    CHECK(d.by_field.norm() == Approx(1 / (51000 * std::cos(72 * kDegree))).epsilon(1e-12));
    CHECK_FALSE(d.by_down.allFinite());
  }
}

TEST_CASE("Position covariances by running sums are those by the whole Jacobian") {
  const test::ThesisCase c = test::thesis_case(4);
  const std::size_t n = 20;
  std::vector<double> md = c.survey.md();
  md.resize(n);
  std::vector<survey::Vec3<double>> tangents;
  for (std::size_t k = 0; k < n; ++k) {
    const survey::Station& s = c.survey.stations[k];
    tangents.push_back(survey::tangent_N({s.inclination, s.azimuth, 0}));
  }
  std::srand(5);
  std::vector<StationErrors> errors(n);
  // One draw after another: 6 of each station, then 2 of the reference.
  MatrixXd estimate(6, 6 * static_cast<Eigen::Index>(n) + 2);
  for (std::size_t k = 0; k < n; ++k) {
    errors[k] = {Eigen::Matrix<double, 3, 6>::Random(), 0.2 * Matrix6d::Random(),
                 Eigen::Matrix<double, 3, 6>::Random()};
    estimate.middleCols<6>(6 * static_cast<Eigen::Index>(k)) = errors[k].parameters_by_draws;
  }
  estimate.rightCols<2>().setRandom();
  const Matrix6d covariance = estimate * estimate.transpose();

  const std::vector<Matrix3d> found = position_covariances(md, tangents, errors, covariance);
  CHECK(found[0].isZero());
  for (std::size_t last = 1; last < n; ++last) {
    const std::vector<Matrix3d> by_tangent =
        survey::final_position_by_tangent({md.begin(), md.begin() + static_cast<std::ptrdiff_t>(last) + 1},
                                          {tangents.begin(), tangents.begin() + static_cast<std::ptrdiff_t>(last) + 1});
    MatrixXd by_draws = MatrixXd::Zero(3, estimate.cols());
    for (std::size_t k = 0; k <= last; ++k) {
      by_draws += by_tangent[k] * errors[k].tangent_by_parameters * estimate;
      by_draws.middleCols<6>(6 * static_cast<Eigen::Index>(k)) += by_tangent[k] * errors[k].tangent_by_draws;
    }
    const Matrix3d expected = by_draws * by_draws.transpose();
    CHECK((found[last] - expected).cwiseAbs().maxCoeff() < 1e-12 * expected.trace());  // some hundred roundings
  }
  const MatrixXd own = errors[7].tangent_by_draws, common = errors[7].tangent_by_parameters;
  MatrixXd by_draws = common * estimate;
  by_draws.middleCols<6>(6 * 7) += own;
  const MatrixXd tangent = covariance_with_estimate(own, common, errors[7].parameters_by_draws, covariance);
  CHECK((tangent - by_draws * by_draws.transpose()).cwiseAbs().maxCoeff() < 1e-12 * tangent.trace());
}
