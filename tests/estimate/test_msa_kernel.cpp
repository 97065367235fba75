#include "estimate/msa_kernel.h"

#include <array>
#include <limits>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "msa_trials.h"
#include "simd/dual.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {

/// Noisy readings of a thesis test.
struct Data : test::MsaTrials {
  explicit Data(int number, int trials = simd::kGroup) : MsaTrials(number, trials, test::msa_noise()) {}
};

MsaNormalEquations<double> normal_equations(const MsaData& d, const std::array<double, 6>& x, double second_order) {
  return msa_normal_equations<double>(d, msa_reading_sums<double>(d), x, second_order);
}

}  // namespace

TEST_CASE("MSA residual is zero at the truth, whatever the attitude") {
  const double total = 51000, dip = 72 * kDegree;
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    const survey::Vec3<double> b = survey::magnetic_T(at, total, dip), gain{1.1, 0.95, 1.25}, bias{250, 295, -335};
    const survey::Vec3<double> m{gain.x * b.x + bias.x, gain.y * b.y + bias.y, gain.z * b.z + bias.z};
    const MsaUnknowns<double> x{{1 / gain.x, 1 / gain.y, 1 / gain.z},
                                {bias.x / gain.x, bias.y / gain.y, bias.z / gain.z}};
    const auto r = msa_residual(m, survey::down_T(at), total * std::cos(dip), total * std::sin(dip), x);
    CHECK(std::abs(r[0]) < 1e-9);  // nT: 2e-14 of the field
    CHECK(std::abs(r[1]) < 1e-9);
  }
}

TEST_CASE("A small axial bias moves Bv by cos I") {
  // dBv = u . db: 1 nT along z gives cos I, exactly, because Bv is linear in the bias.
  const survey::Attitude at{50 * kDegree, 20 * kDegree, 10 * kDegree};
  survey::Vec3<double> m = survey::magnetic_T(at, 51000, 1.2);
  m.z += 1;
  const auto r =
      msa_residual(m, survey::down_T(at), 51000 * std::cos(1.2), 51000 * std::sin(1.2), {{1, 1, 1}, {0, 0, 0}});
  CHECK(std::abs(r[1] - std::cos(50 * kDegree)) < 1e-10);
}

TEST_CASE("The kernel's gradient and matrices are those of dual numbers") {
  using D = simd::Dual<double, 6>;
  using DD = simd::Dual<D, 6>;
  for (const int number : {1, 3, 4}) {
    const Data d(number);
    const std::array<double, 6> x{0.93, 1.04, 0.85, 0.004, -0.003, 0.02};
    std::array<DD, 6> xx;
    for (std::size_t i = 0; i < 6; ++i) xx[i] = DD::variable(D::variable(x[i], i), i);
    const DD exact = d.cost(2, xx);
    const auto newton = normal_equations(d.lane(2), x, 1.0);
    const auto gauss = normal_equations(d.lane(2), x, 0.0);
    CHECK(newton.cost == Approx(exact.a.a).epsilon(1e-12));
    // J'J by first derivatives of every residual
    std::array<D, 6> x1;
    for (std::size_t i = 0; i < 6; ++i) x1[i] = D::variable(x[i], i);
    double scale = 0;
    for (std::size_t i = 0; i < 6; ++i) scale = std::max(scale, std::abs(newton.matrix[simd::packed(i, i)]));
    for (std::size_t i = 0; i < 6; ++i) {
      CHECK(std::abs(newton.gradient[i] - exact.a.d[i] / 2) < 1e-12 * scale);
      for (std::size_t j = 0; j <= i; ++j) {
        CAPTURE(number, i, j);
        CHECK(std::abs(newton.matrix[simd::packed(i, j)] - exact.d[i].d[j] / 2) < 1e-12 * scale);
      }
    }
    Eigen::Matrix<double, 6, 6> jtj = Eigen::Matrix<double, 6, 6>::Zero();
    for (int k = 0; k < d.block.stations; ++k)
      for (const D& e : d.residual(2, k, x1)) {
        const Eigen::Map<const Eigen::Matrix<double, 6, 1>> j(e.d.data());
        jtj += j * j.transpose();
      }
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        CHECK(std::abs(gauss.matrix[simd::packed(i, j)] - jtj(static_cast<int>(i), static_cast<int>(j))) <
              1e-12 * scale);
  }
}

TEST_CASE("Gradient and cost have the same bits with and without the matrix") {
  const Data d(4);
  const std::array<double, 6> x{0.93, 1.04, 0.85, 0.004, -0.003, 0.02};
  const MsaReadingSums<double> sums = msa_reading_sums<double>(d.lane(1));
  const auto with = msa_normal_equations<double>(d.lane(1), sums, x, 1.0);
  const auto without = msa_normal_equations<double, false>(d.lane(1), sums, x, 1.0);
  CHECK(with.gradient == without.gradient);
  CHECK(with.cost == without.cost);
}

TEST_CASE("A trial solved in a lane has the same bits as the trial solved alone") {
  for (const int number : {1, 4}) {
    const Data d(number, 80);
    test::require_bits_of_trials_alone(80, [&]<class T>(int t) { return msa_solve<T>(d.lane(t), {}); });
  }
}

TEST_CASE("At the minimum the gradient vanishes and no neighbour is lower") {
  for (int number = 1; number <= 4; ++number) {
    const Data d(number);
    for (int t = 0; t < simd::kGroup; ++t) {
      const auto s = msa_solve<double>(d.lane(t), {});
      REQUIRE(s.converged == 1);
      const auto e = normal_equations(d.lane(t), s.x, 0.0);
      // Per unknown in units of its own curvature: the distance still to go.
      for (std::size_t i = 0; i < 6; ++i) CHECK(std::abs(e.gradient[i]) / e.matrix[simd::packed(i, i)] < 1e-12);
      for (std::size_t i = 0; i < 6; ++i)
        for (const double h : {-1e-5, 1e-5}) {
          auto x = s.x;
          x[i] += h;
          CHECK(d.cost(t, x) > e.cost);
        }
    }
  }
}

TEST_CASE("The second mode of thesis test 1 is MSA's minimum, not the solver's: a search from the truth ends there too",
          "[long]") {
  int far = 0;
  const Data d(1, 4000);
  for (int t = 0; t < d.block.trials; ++t) {
    const auto s = msa_solve<double>(d.lane(t), {});
    REQUIRE(s.converged == 1);
    if (1 / s.x[2] > 1) continue;  // the first mode lies about gain_z 1.25
    ++far;
    // Levenberg-Marquardt on the readable cost's normal equations, from the true parameters
    std::array<double, 6> x = d.truth();
    auto e = normal_equations(d.lane(t), x, 0);
    double damping = 1e-6;
    for (int step = 0; step < 3000; ++step) {
      auto matrix = e.matrix;
      auto downhill = e.gradient;
      for (std::size_t i = 0; i < 6; ++i) {
        matrix[simd::packed(i, i)] *= 1 + damping;
        downhill[i] = -downhill[i];
      }
      const auto dx = simd::ldlt_solve<double, 6>(simd::ldlt<double, 6>(matrix), downhill);
      auto next = x;
      for (std::size_t i = 0; i < 6; ++i) next[i] += dx[i];
      const auto there = normal_equations(d.lane(t), next, 0);
      const bool better = there.cost <= e.cost;
      if (better) {
        x = next;
        e = there;
      }
      damping *= better ? 0.3 : 5;
    }
    CHECK(e.cost == Approx(s.cost).epsilon(1e-9));
    CHECK(std::abs(x[2] - s.x[2]) < 1e-3);  // two modes are 0.25 apart; this search creeps along the valley
  }
  // 0.9 % of the runs: 36 expected of 4000, 4 standard errors
  CHECK(far > 12);
  CHECK(far < 60);
}

TEST_CASE("A solution is sound where all gains are positive and all is finite") {
  const std::array<double, 6> good{1, 0.9, 1.1, 0, -0.01, 0.02};
  CHECK(are_sound(good));
  const double infinite = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < 6; ++i) {
    for (const double bad : {infinite, -infinite, none}) {
      std::array<double, 6> x = good;
      x[i] = bad;
      CHECK_FALSE(are_sound(x));
    }
    for (const double not_positive : {0.0, -1.0}) {
      std::array<double, 6> x = good;
      x[i] = not_positive;
      CHECK(are_sound(x) == (i >= 3));
    }
  }
}
