/// Laws of the chained solvers: Jacobians, agreement of the two solvers, exactness, special attitudes, lanes.
#include <cstring>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "chained/basic_solution.h"
#include "chained/batch.h"
#include "chained/reading_residual.h"
#include "chained/smoother.h"
#include "chained_cases.h"
#include "simd/dual.h"

using namespace surveymc;
using namespace surveymc::chained;
using namespace surveymc::chained_case;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Vertical, nearly vertical, horizontal along and across the meridian, upwards: degrees.
std::vector<survey::Attitude> hard_attitudes() {
  std::vector<survey::Attitude> a;
  for (const double inclination : {0.0, 1e-8, 35.0, 90.0, 120.0, 180.0})
    for (const double azimuth : {0.0, 90.0, 180.0, 270.0, 359.0})
      for (const double toolface : {0.0, 90.0, 213.0})
        a.push_back({inclination * kDegree, azimuth * kDegree, toolface * kDegree});
  return a;
}

/// The building profile of so many stations.
Readings readings_of(const Model& m, int stations, std::uint64_t trial) {
  return drawn_readings(m, building_profile(stations), random::Stream(7, 8), trial);
}

/// Largest difference of two solutions: frames (rad), chain (prior sd), covariances (correlation).
struct Difference {
  double frame = 0, chain = 0, covariance = 0;
};
Difference difference(const Model& m, const Solution& a, const Solution& b) {
  Difference d;
  const ChainVector sd = vector_of(m.prior_sd);
  for (std::size_t k = 0; k < a.stations.size(); ++k) {
    const StationEstimate &x = a.stations[k], &y = b.stations[k];
    d.frame = std::max(d.frame, (x.frame - y.frame).cwiseAbs().maxCoeff());
    d.chain = std::max(d.chain, (x.chain - y.chain).cwiseQuotient(sd).cwiseAbs().maxCoeff());
    const Eigen::Matrix<double, 12, 1> per_sd = x.covariance.diagonal().cwiseSqrt().cwiseInverse();
    d.covariance =
        std::max(d.covariance,
                 (per_sd.asDiagonal() * (x.covariance - y.covariance) * per_sd.asDiagonal()).cwiseAbs().maxCoeff());
  }
  return d;
}

}  // namespace

TEST_CASE("The expected offsets of slide 7 are reproduced", "[chained]") {
  // Printed to two digits: 0.6 mg, 0.11 mg, 150, 220 and 95 nT; 18 stations.
  const ChainSizes s = slide7_sizes();
  CHECK_THAT(expected_offset(s.accelerometer_xy, 18) / kMg, WithinAbs(0.6, 0.01));
  CHECK_THAT(expected_offset(s.gravity, 18) / kMg, WithinAbs(0.11, 0.005));
  CHECK_THAT(expected_offset(s.magnetometer_xy, 18), WithinAbs(150, 1));
  CHECK_THAT(expected_offset(s.magnetometer_z, 18), WithinAbs(220, 1));
  CHECK_THAT(expected_offset(s.field, 18), WithinAbs(95, 0.5));
}

TEST_CASE("Derivatives of the chained residual are those of dual numbers", "[chained]") {
  using D = simd::Dual<double, 15>;
  Model m = slide7();
  m.interference.directions = Matrix3d::Identity();
  int station = 1;
  for (const survey::Attitude& at : hard_attitudes()) {
    Point p;
    p.frames.assign(2, frame_of(at));
    p.chain.assign(2, ChainVector::Zero());
    p.chain[1] << 0.001, 30, -40, 0.003, -0.002, 0.004, 100, -80, 300;
    p.interference = Eigen::VectorXd::Zero(3);
    p.interference << 500, -300, 200;
    const Readings r{{{1, 2, 3, 4, 5, 6}, {0.3, -9, 2, 20000, -3000, 40000}}, {}};
    const StationLinear l = linearise(m, r, p, station);

    const auto variable = [](double x, std::size_t i) { return D::variable(x, i); };
    const auto i = static_cast<std::size_t>(station);
    const Matrix3d& f = p.frames[i];
    const survey::Vec3<D> delta{variable(0, 0), variable(0, 1), variable(0, 2)};
    const ToolFrame<D> frame{turned(delta, survey::Vec3<D>{D(f(0, 0)), D(f(1, 0)), D(f(2, 0))}),
                             turned(delta, survey::Vec3<D>{D(f(0, 2)), D(f(1, 2)), D(f(2, 2))})};
    std::array<D, 9> c;
    for (std::size_t s = 0; s < 9; ++s) c[s] = variable(p.chain[i][static_cast<Eigen::Index>(s)], 3 + s);
    const double w = m.interference.weight(station);
    const survey::Vec3<D> a{D(w) * variable(500, 12), D(w) * variable(-300, 13), D(w) * variable(200, 14)};
    std::array<D, 6> y;
    for (std::size_t s = 0; s < 6; ++s) y[s] = D(r.y[i][s]);
    const auto e = reading_residual<D>(m.gravity, m.horizontal, m.down, y, frame, c, a);
    for (std::size_t s = 0; s < 6; ++s) {
      const auto row = static_cast<Eigen::Index>(s);
      const double per_sd = 1 / m.noise[s];
      // Rounding: products of up to 50000 nT over a noise of 80.
      CHECK_THAT(l.residual[row], WithinAbs(e[s].a * per_sd, 1e-10));
      for (Eigen::Index j = 0; j < 15; ++j) {
        const double mine = j < 3    ? l.by_delta(row, j)
                            : j < 12 ? l.by_chain(row, j - 3)
                                     : l.by_interference(row, j - 12);
        CHECK_THAT(mine, WithinAbs(-e[s].d[static_cast<std::size_t>(j)] * per_sd, 1e-10));
      }
    }
  }
}

TEST_CASE("Frames, attitudes and their derivatives belong together", "[chained]") {
  for (const survey::Attitude& at : hard_attitudes()) {
    const Matrix3d m = frame_of(at);
    CHECK((m.transpose() * m - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-15);
    CHECK_THAT(m.determinant(), WithinAbs(1, 1e-15));
    CHECK(rotation_between(m, frame_of(attitude_of(m))).norm() < 1e-7);  // acos-like near the vertical
    if (std::sin(at.inclination) < 0.1) continue;
    const Matrix3d g = attitude_derivatives(m);
    for (int i = 0; i < 3; ++i) {
      // Central difference: third derivatives times 1e-10, and rounding 1e-16 / 1e-5.
      const double step = 1e-5;
      survey::Attitude side[2];
      for (const int sign : {0, 1}) {
        const Matrix3d turn = Eigen::AngleAxisd(sign ? step : -step, Vector3d::Unit(i)).toRotationMatrix();
        side[sign] = attitude_of(turn * m);
      }
      const auto slope = [&](double survey::Attitude::*angle) {
        return std::remainder(side[1].*angle - side[0].*angle, 2 * kPi) / (2 * step);
      };
      CHECK_THAT(g(0, i), WithinAbs(slope(&survey::Attitude::inclination), 1e-8));
      CHECK_THAT(g(1, i), WithinAbs(slope(&survey::Attitude::azimuth), 1e-8));
      CHECK_THAT(g(2, i), WithinAbs(slope(&survey::Attitude::toolface), 1e-8));
    }
  }
}

TEST_CASE("Readings without errors give the attitude exactly, wherever the tool points", "[chained]") {
  const Model m = slide7();
  sensor::ChainedRunSetup setup = run_setup(m, hard_attitudes());
  setup.first_sd = setup.step_sd = {};
  setup.noise = {};
  setup.random_toolface = false;
  const sensor::ChainedRun run = sensor::simulate_chained_run(setup, random::Stream(1, 8), 0);
  const Readings r{run.readings, {}};
  for (const Solution& s : {solve_blocks(m, r), run_smoother(m, r), run_filter(m, r),
                            solve_alone(m, Mode::smoother, r.y), solve_alone(m, Mode::filter, r.y)}) {
    REQUIRE(s.converged);
    // Readings are rounded to 7e-12 nT and 2e-15 m/s2: 1e-15 rad, a few times over.
    CHECK_THAT(s.cost, WithinAbs(0, 1e-18));
    for (std::size_t k = 0; k < run.frames.size(); ++k) {
      CHECK(rotation_between(s.stations[k].frame, run.frames[k]).norm() < 2e-14);
      CHECK(s.stations[k].chain.cwiseQuotient(vector_of(m.prior_sd)).cwiseAbs().maxCoeff() < 1e-11);
    }
  }
}

TEST_CASE("Block solver and Kalman smoother agree, with and without what can be added", "[chained]") {
  struct Case {
    const char* name;
    ChainReferences references;
    Eigen::Index interference;
    bool left_out;
  };
  const Case cases[] = {{"chained references", ChainReferences::chained, 0, false},
                        {"independent references", ChainReferences::independent, 0, false},
                        {"readings left out", ChainReferences::chained, 0, true},
                        {"known direction", ChainReferences::chained, 1, false},
                        {"free vector", ChainReferences::chained, 3, true}};
  for (const Case& c : cases) {
    INFO(c.name);
    Model m = slide7(c.references);
    m.interference.directions = Matrix3d::Identity().leftCols(c.interference);
    for (std::uint64_t trial = 0; trial < 5; ++trial) {
      Readings r = readings_of(m, 18, trial);
      if (c.left_out) {
        r.left_out.assign(18, {});
        r.left_out[4][5] = r.left_out[9][0] = r.left_out[17][3] = true;
      }
      // Each is short of the minimum by the last step's contraction, a few hundredths of it. With the usual 1e-9 of a
      // mrad that is up to 3e-13 rad here, which is alike in both only as long as both take the same steps.
      const Options tight{.step_tolerance = 1e-11};
      const Solution a = solve_blocks(m, r, tight), b = run_smoother(m, r, tight);
      REQUIRE(a.converged);
      REQUIRE(b.converged);
      const Difference d = difference(m, a, b);
      // Rounding of 50000 nT, 80 nT of noise and weights of 1e5: 1e-13 where all is well determined.
      const double loose = c.interference == 3 ? 100 : 1;
      CHECK(d.frame < 1e-13 * loose);
      CHECK(d.chain < 1e-11 * loose);
      CHECK(d.covariance < 1e-11 * loose);
      CHECK_THAT(a.cost, WithinAbs(b.cost, 1e-9));
      if (c.interference > 0)
        CHECK((a.interference - b.interference).cwiseAbs().maxCoeff() < 1e-8 * m.interference.prior_sd);
      if (c.interference > 0)
        CHECK((a.interference_covariance - b.interference_covariance).cwiseAbs().maxCoeff() <
              1e-9 * a.interference_covariance.diagonal().maxCoeff());
    }
  }
}

TEST_CASE("One pass of the smoother is one step of Gauss-Newton", "[chained]") {
  const Model m = slide7();
  const Readings r = readings_of(m, 18, 3);
  const Options one{.max_iterations = 1, .damped = false};
  const Difference d = difference(m, solve_blocks(m, r, one), run_smoother(m, r, one));
  CHECK(d.frame < 1e-13);
  CHECK(d.chain < 1e-11);
}

TEST_CASE("The last station of filter and smoother is the same to first order", "[chained]") {
  const Model m = slide7();
  const Readings r = readings_of(m, 18, 4);
  const Solution s = solve_blocks(m, r), f = run_filter(m, r);
  // The filter does not linearise again what it has seen: noise over field, 1e-2, of a sd.
  const double sd = std::sqrt(s.stations[17].covariance.topLeftCorner<3, 3>().trace());
  CHECK(rotation_between(s.stations[17].frame, f.stations[17].frame).norm() < 0.05 * sd);
  CHECK(rotation_between(s.stations[3].frame, f.stations[3].frame).norm() > 0.05 * sd);
}

TEST_CASE("The chain turns with the tool", "[chained]") {
  // Another zero of the toolface: readings, offsets and their estimates turn about z; attitudes and cost do not.
  Model m = slide7();
  const Readings r = readings_of(m, 6, 5);
  Readings turned_readings = r;
  const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d::UnitZ()).toRotationMatrix();
  for (StationReading& y : turned_readings.y) {
    const Vector3d f = turn * Vector3d(y[0], y[1], y[2]), h = turn * Vector3d(y[3], y[4], y[5]);
    y = {f.x(), f.y(), f.z(), h.x(), h.y(), h.z()};
  }
  const Solution a = solve_blocks(m, r), b = solve_blocks(m, turned_readings);
  CHECK_THAT(a.cost, WithinAbs(b.cost, 1e-9));
  for (std::size_t k = 0; k < 6; ++k) {
    CHECK((turn * a.stations[k].frame - b.stations[k].frame).cwiseAbs().maxCoeff() < 1e-13);
    for (const int first : {3, 6})
      CHECK((turn * a.stations[k].chain.segment<3>(first) - b.stations[k].chain.segment<3>(first)).norm() <
            1e-11 * m.prior_sd[static_cast<std::size_t>(first)]);
  }
}

TEST_CASE("Lanes have the bits of the same kernel in plain doubles, whoever is beside them",
          "[chained][chained_lanes]") {
  const std::vector<survey::Attitude> profile = building_profile(18);
  for (const ChainReferences references : {ChainReferences::chained, ChainReferences::independent})
    for (const Mode mode : {Mode::smoother, Mode::filter}) {
      const Model m = slide7(references);
      constexpr int kTrials = 11;
      Runs in(run_setup(m, profile), kTrials, random::Stream(3, 8));
      in.runs[5].readings[7] = {};  // not a number in one lane: the others must not notice
      in.set(5);
      BatchSolution out(kTrials, 18);
      solve_batch(m, mode, in.batch, out);
      for (int t = 0; t < kTrials; ++t) {
        const auto& y = in.runs[static_cast<std::size_t>(t)].readings;
        const Solution a = out.solution(t), b = solve_alone(m, mode, y);
        CHECK(a.converged == (t != 5));
        CHECK(a.converged == b.converged);
        if (t == 5) continue;
        CHECK(a.iterations == b.iterations);
        CHECK(a.cost == b.cost);
        for (std::size_t k = 0; k < 18; ++k) {
          CHECK(a.stations[k].frame == b.stations[k].frame);
          CHECK(a.stations[k].chain == b.stations[k].chain);
          CHECK(a.stations[k].covariance == b.stations[k].covariance);
        }
        const Solution c = mode == Mode::smoother ? run_smoother(m, {y, {}}) : run_filter(m, {y, {}});
        const Difference d = difference(m, a, c);
        CHECK(d.frame < 1e-13);
        CHECK(d.chain < 1e-11);
        CHECK(d.covariance < 1e-11);
        CHECK_THAT(a.cost, WithinAbs(c.cost, 1e-9));
      }
    }
}

TEST_CASE("A chain without noise or walk is refused", "[chained]") {
  Model m = slide7();
  m.link_sd[4] = 0;
  CHECK_THROWS_AS(solve_blocks(m, case_readings()), InputError);
  m = slide7();
  m.noise[1] = 0;
  CHECK_THROWS_AS(run_smoother(m, case_readings()), InputError);
}
