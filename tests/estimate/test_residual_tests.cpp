#include "estimate/residual_tests.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/msa_residual.h"
#include "simd/dual.h"
#include "stats/linear_algebra.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::estimate;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Test 4 of the thesis with residuals of some size.
struct Case {
  std::vector<survey::StationFields> fields;
  std::vector<FieldMisfit> misfits;
  explicit Case(std::size_t stations = 53) {
    const test::ThesisCase c = test::thesis_case(4);
    fields = test::station_fields(c);
    fields.resize(stations);
    misfits = field_misfits(fields, c.errors.gain, c.field.total, c.field.dip);
    for (std::size_t k = 0; k < stations; ++k)
      misfits[k].residual << 70 * std::sin(1.0 + 1.7 * static_cast<double>(k)),
          50 * std::cos(2.3 * static_cast<double>(k));
  }
};

/// The definition, with dense matrices.
struct Dense {
  MatrixXd q, m;
  VectorXd v;
  Dense(const Case& c, const InputErrors& noise) {
    const auto n = static_cast<Eigen::Index>(2 * c.misfits.size());
    q = MatrixXd::Zero(n, n);
    v = VectorXd(n);
    MatrixXd j(n, 6), common(n, 2);
    for (std::size_t k = 0; k < c.misfits.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(2 * k);
      const FieldMisfit& f = c.misfits[k];
      const Eigen::Vector3d u = survey::to_eigen(c.fields[k].down_T);
      const MatrixXd tilt = noise.down * f.by_down * (Eigen::Matrix3d::Identity() - u * u.transpose());
      q.block(row, row, 2, 2) =
          noise.magnetometer * noise.magnetometer * f.by_magnetometer * f.by_magnetometer.transpose() +
          tilt * tilt.transpose();
      common.middleRows(row, 2) = f.by_reference * Eigen::Vector2d(noise.total, noise.dip).asDiagonal();
      if (noise.reference_per_station)
        q.block(row, row, 2, 2) += common.middleRows(row, 2) * common.middleRows(row, 2).transpose();
      j.middleRows(row, 2) = f.by_parameters;
      v.segment(row, 2) = f.residual;
    }
    if (!noise.reference_per_station) q += common * common.transpose();
    j.rightCols(3) *= 51000;  // condition
    const MatrixXd p = stats::symmetric_inverse(q);
    m = p - p * j * stats::symmetric_inverse(j.transpose() * p * j) * j.transpose() * p;
  }
};

}  // namespace

TEST_CASE("The misfit and its derivatives are those of the residual of MSA") {
  using D = simd::Dual<double, 9>;  // reading x, y, z, then gain x, y, z, bias x, y, z
  const std::array<double, 3> gain{1.05, 0.97, 1.01}, bias{150, -80, 300};
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    const survey::Vec3<double> b = survey::magnetic_T(at, 51000, 72 * kDegree), u = survey::down_T(at);
    const auto variable = [](double x, std::size_t i) { return D::variable(x, i); };
    const survey::Vec3<D> m{variable(gain[0] * b.x + bias[0], 0), variable(gain[1] * b.y + bias[1], 1),
                            variable(gain[2] * b.z + bias[2], 2)};
    MsaUnknowns<D> x;
    x.p = {D(1.0) / variable(gain[0], 3), D(1.0) / variable(gain[1], 4), D(1.0) / variable(gain[2], 5)};
    x.q = {variable(bias[0], 6) * x.p.x, variable(bias[1], 7) * x.p.y, variable(bias[2], 8) * x.p.z};
    const double total = 50900, dip = 71.8 * kDegree;
    const auto r = msa_residual<D>(m, {D(u.x), D(u.y), D(u.z)}, D(total * std::cos(dip)), D(total * std::sin(dip)), x);
    const FieldMisfit f = field_misfit({b, u}, gain, total, dip);
    for (int i = 0; i < 2; ++i) {
      const D& e = r[static_cast<std::size_t>(i)];
      CHECK(std::abs(f.residual[i] - e.a) < 1e-9);  // of 5e4 nT
      for (int j = 0; j < 3; ++j) CHECK(std::abs(f.by_magnetometer(i, j) - e.d[static_cast<std::size_t>(j)]) < 1e-13);
      for (int j = 0; j < 3; ++j)
        CHECK(std::abs(f.by_parameters(i, j) - e.d[static_cast<std::size_t>(3 + j)]) < 1e-13 * 51000);
      for (int j = 3; j < 6; ++j) CHECK(std::abs(f.by_parameters(i, j) - e.d[static_cast<std::size_t>(3 + j)]) < 1e-13);
    }
  }
}

TEST_CASE("All tests agree with the definition by dense matrices") {
  for (const bool per_station : {false, true})
    for (const double down_sd : {0.0, 3e-4}) {
      const Case c;
      const InputErrors noise{70, down_sd, 107, 0.16 * kDegree, per_station, 0, 0};
      const ResidualTests t = residual_tests(c.fields, c.misfits, noise);
      const Dense d(c, noise);
      const VectorXd mv = d.m * d.v;
      CHECK(t.redundancy == 100);
      // The dense way squares a condition of 1e3 and inverts Q: nine digits are left.
      CHECK(t.statistic == Approx(d.v.dot(mv)).epsilon(1e-8));
      for (std::size_t k = 0; k < c.fields.size(); ++k)
        for (int i = 0; i < 2; ++i) {
          const auto row = static_cast<Eigen::Index>(2 * k) + i;
          CHECK(t.w[k][i] == Approx(mv[row] / std::sqrt(d.m(row, row))).epsilon(1e-7).margin(1e-8));
          CHECK(t.error[k][i] == Approx(mv[row] / d.m(row, row)).epsilon(1e-7).margin(1e-6));
          CHECK(t.error_sd[k][i] == Approx(1 / std::sqrt(d.m(row, row))).epsilon(1e-8));
        }
    }
}

TEST_CASE(
    "The tests do not depend on what the estimator made of the parameters, nor on a common shift of the reference") {
  Case c;
  const InputErrors noise{70, 3e-4, 107, 0.16 * kDegree, false, 0, 0};
  const ResidualTests before = residual_tests(c.fields, c.misfits, noise);
  Eigen::Matrix<double, 6, 1> dx;
  dx << 0.01, -0.004, 0.02, 30, -60, 500;
  for (FieldMisfit& m : c.misfits) m.residual += m.by_parameters * dx;
  const ResidualTests after = residual_tests(c.fields, c.misfits, noise);
  // Residuals have grown to 1e3 nT, of which the projection removes all: 1e-12 of them is left.
  CHECK(after.statistic == Approx(before.statistic).epsilon(1e-9));
  for (std::size_t k = 0; k < c.fields.size(); ++k) CHECK((after.w[k] - before.w[k]).norm() < 1e-9);
}

TEST_CASE("An error in one residual is found with its size") {
  Case c;
  for (FieldMisfit& m : c.misfits) m.residual.setZero();
  for (const InputErrors& noise : {InputErrors{70, 0, 0, 0, false, 0, 0}, InputErrors{70, 0, 107, 0.003, false, 0, 0}})
    for (const std::size_t k : {std::size_t{0}, std::size_t{26}, std::size_t{52}})
      for (int i = 0; i < 2; ++i) {
        c.misfits[k].residual[i] = 400;
        const ResidualTests t = residual_tests(c.fields, c.misfits, noise);
        c.misfits[k].residual[i] = 0;
        // Alone it is recovered exactly, no w is larger (Cauchy-Schwarz), and T is its square.
        CHECK(t.error[k][i] == Approx(400).epsilon(1e-10));
        CHECK(t.w[k][i] == Approx(400 / t.error_sd[k][i]).epsilon(1e-10));
        CHECK(t.statistic == Approx(t.w[k][i] * t.w[k][i]).epsilon(1e-10));
        for (const Eigen::Vector2d& w : t.w) CHECK(w.cwiseAbs().maxCoeff() <= t.w[k][i] * (1 + 1e-12));
      }
}

TEST_CASE("Without redundancy nothing is tested, and nothing is infinite") {
  const Case c(3);
  const ResidualTests t = residual_tests(c.fields, c.misfits, {70, 0, 107, 0.003, false});
  CHECK(t.redundancy == 0);
  CHECK(t.statistic == 0);
  CHECK(std::isnan(t.variance_factor()));
  for (const Eigen::Vector2d& w : t.w) CHECK((std::isnan(w[0]) && std::isnan(w[1])));
}

TEST_CASE("A test along a residual is that residual's, and what the residuals do not see is not tested") {
  const Case c;
  const ResidualTests t = residual_tests(c.fields, c.misfits, {70, 3e-4, 107, 0.16 * kDegree, false, 0, 0});
  for (const std::size_t k : {std::size_t{0}, std::size_t{26}}) {
    for (int i = 0; i < 2; ++i) {
      const DirectionTest d = direction_test(t, k, 2 * Eigen::Vector2d::Unit(i));
      CHECK(d.w == Approx(t.w[k][i]).epsilon(1e-12));
      CHECK(d.error == Approx(t.error[k][i] / 2).epsilon(1e-12));
      CHECK(d.error_sd == Approx(t.error_sd[k][i] / 2).epsilon(1e-12));
    }
    CHECK(std::isnan(direction_test(t, k, Eigen::Vector2d::Zero()).w));
    // Tilts of the three accelerometers move (Bh, Bv) along one line: no residual tells them apart.
    const Eigen::Vector3d u = survey::to_eigen(c.fields[k].down_T);
    const Eigen::Matrix<double, 2, 3> tilt = c.misfits[k].by_down * (Eigen::Matrix3d::Identity() - u * u.transpose());
    CHECK(std::abs(direction_correlation(t, k, tilt.col(0), tilt.col(1))) == Approx(1).epsilon(1e-9));
  }
}
