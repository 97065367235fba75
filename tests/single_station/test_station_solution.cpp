#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include <Eigen/Dense>

#include "base/error.h"
#include "base/units.h"
#include "sensor/station_draws.h"
#include "simd/dual.h"
#include "single_station/axial_correction.h"
#include "single_station/station_solution.h"
#include "stats/intervals.h"
#include "stats/linear_algebra.h"

using namespace surveymc;
using namespace surveymc::single_station;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Index;

namespace {

constexpr double kTotal = 50000, kGravity = 9.81;
const double kDip = 75 * kDegree, kBh = kTotal * std::cos(kDip), kBd = kTotal * std::sin(kDip);
const StationReferences kReference{kGravity, kBh, kBd};

constexpr std::array<StationMethod, kStationMethods> kAll{StationMethod::basic, StationMethod::simple,
                                                          StationMethod::extended, StationMethod::extended_bh,
                                                          StationMethod::optimising};

/// Accelerometers 0.6 mg, their reference 0.1 mg; of the slides' expected offsets.
StationSigmas sigmas() {
  StationSigmas s;
  s.accelerometer_xy = s.accelerometer_z = 0.006;
  s.gravity = 0.001;
  s.magnetometer_xy = 150;
  s.magnetometer_z = 220;
  s.horizontal = s.vertical = 95;
  s.axial = 500;
  return s;
}

survey::Attitude degrees(double inclination, double azimuth, double toolface) {
  return {inclination * kDegree, azimuth * kDegree, toolface * kDegree};
}

survey::Vec3<double> field_at(const survey::Attitude& at) { return survey::magnetic_T(at, kTotal, kDip); }
survey::Vec3<double> gravity_at(const survey::Attitude& at) { return scale(kGravity, survey::down_T(at)); }

std::vector<survey::Attitude> many_attitudes() {
  std::vector<survey::Attitude> all;
  for (const double i : {1e-8, 0.3, 30.0, 85.0, 90.0, 95.0, 150.0, 179.9})
    for (const double a : {0.0, 1e-8, 35.0, 90.0, 179.0, 200.0, 270.0, 359.999})
      for (const double t : {0.0, 57.0, 147.0, 268.0}) all.push_back(degrees(i, a, t));
  return all;
}

double angle(double difference) { return std::remainder(difference, 2 * kPi); }

/// Slide 3 as it is printed, in the frame of the slides: HTF from x. Unknowns Bh cosA, Bh sinA, Bd, Mz; rows Hx, Hy,
/// Hz, Bd, Mz.
Eigen::Matrix<double, 5, 4> design(double inclination, double htf) {
  const double si = std::sin(inclination), ci = std::cos(inclination), s = std::sin(htf), c = std::cos(htf);
  Eigen::Matrix<double, 5, 4> x;
  x << ci * c, -s, -si * c, 0,  //
      -ci * s, -c, si * s, 0,   //
      si, 0, ci, 1,             //
      0, 0, 1, 0,               //
      0, 0, 0, 1;
  return x;
}

struct Oracle {
  Eigen::Vector4d x;
  Eigen::Matrix4d covariance;
  double cost;
};

/// Weighted least squares with slide 3's matrix and, if asked for, the row of Bh, iterated from a start by Gauss-Newton
/// with step control.
Oracle least_squares(const survey::Attitude& at, const survey::Vec3<double>& b, const StationReferences& ref,
                     const StationSigmas& s, bool with_bh, bool with_axial, Eigen::Vector4d x) {
  const auto five = design(at.inclination, at.toolface - kPi / 2);
  const Index rows = with_bh ? 6 : 5, n = with_axial ? 4 : 3;
  Eigen::VectorXd y(rows), sd(rows);
  y.head(5) << b.x, b.y, b.z, ref.vertical, 0;
  sd.head(5) << s.magnetometer_xy, s.magnetometer_xy, s.magnetometer_z, s.vertical, with_axial ? s.axial : 1;
  if (with_bh) y[5] = ref.horizontal, sd[5] = s.horizontal;
  if (!with_axial) x[3] = 0;
  const auto residual = [&](const Eigen::Vector4d& at_x) {
    Eigen::VectorXd v(rows);
    v.head(5) = five * at_x;
    if (with_bh) v[5] = std::hypot(at_x[0], at_x[1]);
    return Eigen::VectorXd(((y - v).array() / sd.array()).matrix());
  };
  Eigen::MatrixXd jacobian(rows, 4);
  for (int step = 0; step < 500; ++step) {
    jacobian.topRows(5) = five;
    if (with_bh) {
      const double bh = std::hypot(x[0], x[1]);
      jacobian.row(5) << x[0] / bh, x[1] / bh, 0, 0;
    }
    for (Index r = 0; r < rows; ++r) jacobian.row(r) /= sd[r];
    const Eigen::VectorXd dx = stats::least_squares_solution(jacobian.leftCols(n), residual(x), 1e-14);
    double factor = 1;
    Eigen::Vector4d next = x;
    do {
      next = x;
      next.head(n) += factor * dx;
      factor /= 2;
    } while (residual(next).squaredNorm() > residual(x).squaredNorm() && factor > 1e-12);
    if ((next - x).norm() < 1e-9) break;
    x = next;
  }
  Oracle o{x, Eigen::Matrix4d::Zero(), residual(x).squaredNorm()};
  o.covariance.topLeftCorner(n, n) = stats::symmetric_inverse(jacobian.leftCols(n).transpose() * jacobian.leftCols(n));
  return o;
}

Oracle lowest(const survey::Attitude& at, const survey::Vec3<double>& b, const StationReferences& ref,
              const StationSigmas& s, bool with_bh, bool with_axial) {
  Oracle best;
  best.cost = 1e300;
  for (int k = 0; k < 8; ++k) {
    const double a = k * kPi / 4 + 0.1;
    const Oracle o = least_squares(at, b, ref, s, with_bh, with_axial, {kBh * std::cos(a), kBh * std::sin(a), kBd, 0});
    if (o.cost < best.cost) best = o;
  }
  return best;
}

}  // namespace

TEST_CASE("Worked cases of axial correction", "[single_station]") {
  // Thesis frame, toolface 57 deg from x, magnetometer bias (90, -60, 700) nT, Bd reference 50 nT too high.
  StationSigmas s = sigmas();
  StationReferences ref = kReference;
  ref.vertical += 50;
  struct Case {
    double inclination, azimuth, basic, simple, extended, axial;
  };
  for (const Case& c : {Case{30, 35, 33.769, 34.484, 34.388, 459.933}, Case{85, 85, 81.877, 77.540, 81.604, -56.999}}) {
    const survey::Attitude at = degrees(c.inclination, c.azimuth, 57 + 90);
    const survey::Vec3<double> b = field_at(at) + survey::Vec3<double>{90, -60, 700}, g = gravity_at(at);
    const auto azimuth = [&](StationMethod m) { return solve_station(g, b, ref, s, m).attitude.azimuth / kDegree; };
    // printed to three decimals
    CHECK_THAT(azimuth(StationMethod::basic), WithinAbs(c.basic, 5e-4));
    CHECK_THAT(azimuth(StationMethod::simple), WithinAbs(c.simple, 5e-4));
    CHECK_THAT(azimuth(StationMethod::extended), WithinAbs(c.extended, 5e-4));
    CHECK_THAT(solve_station(g, b, ref, s, StationMethod::extended).axial, WithinAbs(c.axial, 5e-4));
  }
}

TEST_CASE("Readings without error give the attitude, by every method", "[single_station]") {
  const StationSigmas s = sigmas();
  for (const survey::Attitude& at : many_attitudes())
    for (const StationMethod m : kAll) {
      const StationSolution x = solve_station(gravity_at(at), field_at(at), kReference, s, m);
      INFO(station_method_names()[static_cast<std::size_t>(m)]
           << " I " << at.inclination / kDegree << " A " << at.azimuth / kDegree << " T " << at.toolface / kDegree);
      if (m == StationMethod::simple && std::abs(std::cos(at.inclination)) < 1e-9) {
        CHECK_FALSE(x.determined);
        continue;
      }
      REQUIRE(x.determined);
      // Rounding of the readings, 1e-16 of them, over the component that tells the angle: sin I of the toolface;
      // with `simple`, tan I Bd / Bh of the azimuth.
      const double lean = std::max(std::sin(at.inclination), 1e-12);
      CHECK_THAT(x.attitude.inclination, WithinAbs(at.inclination, 1e-15));
      CHECK_THAT(angle(x.attitude.toolface - at.toolface), WithinAbs(0, 1e-15 / lean));
      const double amplification = m == StationMethod::simple ? 1 / std::abs(std::cos(at.inclination)) : 1;
      const double sign = std::cos(at.inclination) >= 0 ? 1 : -1;
      CHECK_THAT(angle(x.attitude.azimuth + sign * x.attitude.toolface - at.azimuth - sign * at.toolface),
                 WithinAbs(0, 2e-14 * amplification + 1e-15 / lean * (1 - std::abs(std::cos(at.inclination)))));
      CHECK_THAT(x.horizontal(), WithinAbs(kBh, 1e-10 * amplification));
      CHECK_THAT(x.vertical, WithinAbs(kBd, 1e-10));
      CHECK_THAT(x.axial, WithinAbs(0, 1e-10 * amplification));
      CHECK_THAT(x.gravity, WithinRel(kGravity, 1e-14));
      CHECK_THAT(x.cost, WithinAbs(0, 1e-20));
    }
}

TEST_CASE("A vertical hole has azimuth and toolface in one angle", "[single_station]") {
  for (const double inclination : {0.0, 180.0})
    for (const StationMethod m : kAll) {
      const double sign = inclination > 90 ? -1 : 1;
      survey::Attitude at = degrees(inclination, 40, 25);
      survey::Vec3<double> g = gravity_at(at);
      g.x = g.y = 0;  // the sine of pi is not 0
      const StationSolution x = solve_station(g, field_at(at), kReference, sigmas(), m);
      REQUIRE(x.determined);
      CHECK(x.attitude.toolface == 0);
      CHECK_THAT(angle(x.attitude.azimuth - at.azimuth - sign * at.toolface), WithinAbs(0, 1e-12));
      const StationCovariance c = station_covariance(x, sigmas(), m);
      CHECK(std::isinf(c(2, 2)));
      CHECK(std::isinf(c(1, 1)));
      for (const int q : {0, 3, 4, 5, 6, 7}) CHECK(std::isfinite(c(q, q)));
      StationSigmas perfect = sigmas();
      perfect.accelerometer_xy = 0;
      CHECK(std::isfinite(station_covariance(x, sigmas(), m, perfect)(2, 2)));
    }
}

TEST_CASE("Simple axial correction has the determinant -cos I", "[single_station]") {
  for (const double i : {0.0, 10.0, 60.0, 90.0, 120.0, 180.0})
    CHECK_THAT(std::abs(design(i * kDegree, 0.7).topRows(4).determinant()),
               WithinAbs(std::abs(std::cos(i * kDegree)), 1e-15));
  for (const double a : {0.0, 45.0, 90.0})
    for (const double off : {0.0, 1e-8})
      CHECK_FALSE(solve_station(gravity_at(degrees(90 + off, a, 5)), field_at(degrees(90 + off, a, 5)), kReference,
                                sigmas(), StationMethod::simple)
                      .determined);
}

TEST_CASE("The extended correction has basic and simple as limits", "[single_station]") {
  for (const survey::Attitude& at : many_attitudes()) {
    if (std::abs(std::cos(at.inclination)) < 0.05) continue;  // simple itself has few digits there
    const survey::Vec3<double> b = field_at(at) + survey::Vec3<double>{90, -60, 700}, g = gravity_at(at);
    StationReferences ref = kReference;
    ref.vertical += 50;
    StationSigmas to_basic = sigmas(), to_simple = sigmas();
    to_basic.axial = 0;
    to_basic.vertical = 1e15;
    to_simple.axial = 1e15;
    to_simple.vertical = 0;
    const double basic = solve_station(g, b, ref, sigmas(), StationMethod::basic).attitude.azimuth,
                 simple = solve_station(g, b, ref, sigmas(), StationMethod::simple).attitude.azimuth;
    // 5e-14 deg is the agreement of the source; tan I Bd / Bh = 75 magnifies rounding at 87 deg
    CHECK_THAT(angle(solve_station(g, b, ref, to_basic, StationMethod::extended).attitude.azimuth - basic) / kDegree,
               WithinAbs(0, 6e-14));
    CHECK_THAT(angle(solve_station(g, b, ref, to_simple, StationMethod::extended).attitude.azimuth - simple) / kDegree,
               WithinAbs(0, 6e-14 / std::abs(std::cos(at.inclination))));
  }
}

TEST_CASE("Extended and optimising are the lowest minimum of weighted least squares", "[single_station][long]") {
  StationReferences ref = kReference;
  ref.vertical += 130;
  ref.horizontal -= 70;
  for (const double axial : {30.0, 500.0, 4000.0}) {
    StationSigmas s = sigmas();
    s.axial = axial;
    for (const survey::Attitude& at : many_attitudes()) {
      if (std::sin(at.inclination) < 1e-6) continue;  // toolfaces of the readings and of the matrix differ by rounding
      const survey::Vec3<double> b = field_at(at) + survey::Vec3<double>{190, -260, 700}, g = gravity_at(at);
      for (const StationMethod m : {StationMethod::extended, StationMethod::extended_bh, StationMethod::optimising}) {
        const bool with_bh = m != StationMethod::extended, with_axial = m != StationMethod::optimising;
        StationSigmas equal = s;
        if (!with_axial) equal.axial = 0;
        const StationSolution x = solve_station(g, b, ref, equal, m);
        const Oracle o = lowest(at, b, ref, equal, with_bh, with_axial);
        INFO(station_method_names()[static_cast<std::size_t>(m)]
             << " axial " << axial << " I " << at.inclination / kDegree << " A " << at.azimuth / kDegree << " T "
             << at.toolface / kDegree);
        REQUIRE(x.determined);
        // Gauss-Newton's own end: where Mz is loose it converges slowly, and stops 1e-6 sd short
        CHECK_THAT(x.cost, WithinAbs(o.cost, 1e-9));
        const double found[] = {x.north, x.east, x.vertical, x.axial};
        for (int i = 0; i < 4; ++i)
          CHECK_THAT(found[i], WithinAbs(o.x[i], 1e-6 * std::sqrt(o.covariance(i, i)) + 1e-6));
        // Covariance of the magnetic part: errors of attitude left out
        StationSigmas held = equal;
        held.accelerometer_xy = held.accelerometer_z = held.gravity = 0;
        const StationCovariance c = station_covariance(x, equal, m, held);
        const double ca = x.north / x.horizontal(), sa = x.east / x.horizontal();
        Eigen::Matrix<double, 4, 4> to;
        to << -sa / x.horizontal(), ca / x.horizontal(), 0, 0, ca, sa, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
        const Eigen::Matrix4d oracle = to * o.covariance * to.transpose();
        const int index[] = {2, 5, 6, 7};
        for (int r = 0; r < 4; ++r)
          for (int q = 0; q < 4; ++q)
            CHECK_THAT(c(index[r], index[q]),
                       WithinAbs(oracle(r, q), 1e-6 * std::sqrt(oracle(r, r) * oracle(q, q)) + 1e-12));
      }
    }
  }
}

TEST_CASE("Gains are the derivatives of the solution", "[single_station]") {
  using D = simd::Dual<double, 10>;
  const StationSigmas s = sigmas();
  for (const survey::Attitude& at : many_attitudes()) {
    if (std::sin(at.inclination) < 1e-6) continue;  // the oracle divides by it
    for (const StationMethod m : kAll) {
      const survey::Vec3<double> g = gravity_at(at), b = field_at(at);
      const StationSolution x = solve_station(g, b, kReference, s, m);
      if (!x.determined) continue;
      const double st = std::sin(x.attitude.toolface), ct = std::cos(x.attitude.toolface);
      const auto dual = [](double value, std::array<std::pair<std::size_t, double>, 3> parts) {
        D d(value);
        for (const auto& [i, by] : parts) d.d[i] += by;
        return d;
      };
      const survey::Vec3<D> gd{dual(g.x, {{{0, -st}, {1, -ct}, {2, 0}}}), dual(g.y, {{{0, -ct}, {1, st}, {2, 0}}}),
                               dual(g.z, {{{2, 1}, {0, 0}, {1, 0}}})};
      const survey::Vec3<D> bd{dual(b.x, {{{4, st}, {5, ct}, {6, 0}}}), dual(b.y, {{{4, ct}, {5, -st}, {6, 0}}}),
                               dual(b.z, {{{6, 1}, {7, 1}, {0, 0}}})};
      const ToolAxes<D> axes =
          axes_from_accelerometers(gd, m == StationMethod::optimising, D::variable(kGravity, 3), s);
      const FieldSolution<D> f = solve_field(axes, bd, D::variable(kBh, 9), D::variable(kBd, 8), s, m);
      const StationGains k = station_gains(x, s, m);
      INFO(station_method_names()[static_cast<std::size_t>(m)]
           << " I " << at.inclination / kDegree << " A " << at.azimuth / kDegree << " T " << at.toolface / kDegree);
      const double bh2 = x.horizontal() * x.horizontal();
      for (std::size_t i = 0; i < 10; ++i) {
        const auto c = static_cast<Index>(i);
        // relative to the unit of the gain, over the sine and cosine that the oracle divides by
        const double conditioned =
            1e-11 / std::sin(at.inclination) / (m == StationMethod::simple ? std::abs(std::cos(at.inclination)) : 1);
        const double unit = i < 4 ? 1 / kGravity : 1 / kBh;
        const double inclination = axes.ci.a * axes.si.d[i] - axes.si.a * axes.ci.d[i];
        const double toolface = axes.ct.a * axes.st.d[i] - axes.st.a * axes.ct.d[i];
        const double azimuth = (f.north.a * f.east.d[i] - f.east.a * f.north.d[i]) / bh2;
        CHECK_THAT(k(0, c), WithinAbs(inclination, conditioned * unit));
        CHECK_THAT(k(1, c), WithinAbs(toolface, conditioned * unit));
        CHECK_THAT(k(2, c), WithinAbs(azimuth, 10 * conditioned * unit));
        CHECK_THAT(k(3, c), WithinAbs(azimuth + (axes.ci.a >= 0 ? 1 : -1) * toolface, 10 * conditioned * unit));
        CHECK_THAT(k(4, c), WithinAbs(axes.gravity.d[i], conditioned));
        const double field = i < 4 ? kTotal / kGravity : 1;
        CHECK_THAT(k(5, c), WithinAbs((f.north.a * f.north.d[i] + f.east.a * f.east.d[i]) / x.horizontal(),
                                      10 * conditioned * field));
        CHECK_THAT(k(6, c), WithinAbs(f.vertical.d[i], 10 * conditioned * field));
        CHECK_THAT(k(7, c), WithinAbs(f.axial.d[i] - (i == 7 ? 1 : 0), 10 * conditioned * field));
      }
    }
  }
}

TEST_CASE("What a method leaves over is chi-squared, with errors of the attitude too", "[single_station][long]") {
  // Near the horizontal, and with a small dip, an error of the inclination moves Bd by much of Bh.
  constexpr int kStations = 8000;
  const double total = 40000, dip = 10 * kDegree;
  const StationReferences truth{kGravity, total * std::cos(dip), total * std::sin(dip)};
  StationSigmas s;
  s.magnetometer_xy = s.magnetometer_z = 30;
  s.vertical = 20;
  s.horizontal = 40;
  s.axial = 200;
  s.gravity = 0.002;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sd) { return sd * normal(random); };
  const auto noisy = [&](const survey::Vec3<double>& v, double xy, double z) {
    return survey::Vec3<double>{v.x + draw(xy), v.y + draw(xy), v.z + draw(z)};
  };
  for (const double accelerometer : {0.0, 0.01})
    for (const double inclination : {20.0, 90.0})
      for (const StationMethod m : {StationMethod::extended, StationMethod::extended_bh, StationMethod::optimising}) {
        if (m == StationMethod::optimising && accelerometer == 0) continue;
        s.accelerometer_xy = s.accelerometer_z = accelerometer;
        const double axial = m == StationMethod::optimising ? 0 : s.axial;
        double sum = 0;
        int rejected = 0, degrees_of_freedom = 0;
        for (int k = 0; k < kStations; ++k) {
          const survey::Attitude at = degrees(inclination, 360.0 * k / kStations, 77.0 * k);
          StationReferences ref = truth;
          ref.gravity += draw(s.gravity);
          ref.horizontal += draw(s.horizontal);
          ref.vertical += draw(s.vertical);
          survey::Vec3<double> b = noisy(survey::magnetic_T(at, total, dip), s.magnetometer_xy, s.magnetometer_z);
          b.z += draw(axial);
          const StationSolution x = solve_station(noisy(gravity_at(at), accelerometer, accelerometer), b, ref, s, m);
          REQUIRE(x.determined);
          const double fit = fit_statistic(x, ref, s, m);
          if (accelerometer == 0) CHECK_THAT(fit, WithinRel(x.cost, 1e-9) || WithinAbs(x.cost, 1e-9));
          degrees_of_freedom = x.redundancy;
          sum += fit;
          rejected += fit > stats::chi_squared_quantile(x.redundancy, 0.99);
        }
        INFO(station_method_names()[static_cast<std::size_t>(m)] << " I " << inclination << " sd " << accelerometer);
        // Four standard errors of the mean of so many chi-squared values, and of a share of 1 %.
        CHECK_THAT(sum / kStations, WithinAbs(degrees_of_freedom, 4 * std::sqrt(2.0 * degrees_of_freedom / kStations)));
        CHECK_THAT(rejected, WithinAbs(0.01 * kStations, 4 * std::sqrt(0.01 * kStations)));
      }
  const StationSolution simple = solve_station(gravity_at(degrees(20, 30, 40)), field_at(degrees(20, 30, 40)),
                                               kReference, sigmas(), StationMethod::simple);
  CHECK(std::isnan(fit_statistic(simple, kReference, sigmas(), StationMethod::simple)));
}

TEST_CASE("The point pulled to a circle is the lowest of all", "[single_station]") {
  // Scan of the whole plane around the ring; the scan's own spacing bounds how much lower it could be.
  for (const double x0 : {-0.3, 1e-9, 0.02, 1.1})
    for (const double y0 : {-1.2, 0.01, 0.9})
      for (const double px : {1e-4, 0.3, 4.0})
        for (const double py : {1e-4, 0.3})
          for (const double variance : {1e-4, 0.5}) {
            const estimate::CirclePoint<double> p = estimate::pull_to_circle(x0, y0, px, py, 1.0, variance);
            REQUIRE(p.found == 1);
            const auto cost = [&](double x, double y) {
              const double dr = std::hypot(x, y) - 1;
              return (x - x0) * (x - x0) / px + (y - y0) * (y - y0) / py + dr * dr / variance;
            };
            CHECK_THAT(p.cost, WithinRel(cost(p.x, p.y), 1e-12));
            double least = 1e300;
            for (int i = 0; i < 720; ++i)
              for (int j = 1; j < 200; ++j) {
                const double a = i * kPi / 360, r = j * 0.01;
                least = std::min(least, cost(r * std::cos(a), r * std::sin(a)));
              }
            CHECK(p.cost <= least * (1 + 1e-12));
          }
  // Exactly between the two sides there is no single answer: flagged, not guessed.
  CHECK(estimate::pull_to_circle(0.0, 0.5, 4.0, 1e-4, 1.0, 1e-4).found == 0);
  CHECK(estimate::pull_to_circle(1e-12, 0.5, 4.0, 1e-4, 1.0, 1e-4).found == 1);
}

TEST_CASE("Gravity that is pulled to its reference is the minimum of slide 4", "[single_station]") {
  // Gauss-Newton in (HTF, g_xy, g_z) with the row (0, g_xy/g, g_z/g), z noisier than x and y.
  StationSigmas s = sigmas();
  s.accelerometer_z = 0.02;
  for (const double i : {0.5, 20.0, 70.0, 90.0, 140.0}) {
    const survey::Attitude at = degrees(i, 10, 200);
    const survey::Vec3<double> g = gravity_at(at) + survey::Vec3<double>{0.01, -0.02, 0.03};
    const ToolAxes<double> x = axes_from_accelerometers(g, true, kGravity, s);
    Eigen::Vector3d u(at.toolface, kGravity * std::sin(at.inclination), kGravity * std::cos(at.inclination));
    for (int step = 0; step < 50; ++step) {
      const double sn = std::sin(u[0]), cs = std::cos(u[0]), total = std::hypot(u[1], u[2]);
      Eigen::Matrix<double, 4, 3> j;
      j << -u[1] * cs, -sn, 0, u[1] * sn, -cs, 0, 0, 0, 1, 0, u[1] / total, u[2] / total;
      Eigen::Vector4d e(g.x + u[1] * sn, g.y + u[1] * cs, g.z - u[2], kGravity - total);
      const Eigen::Vector4d w(1 / s.accelerometer_xy, 1 / s.accelerometer_xy, 1 / s.accelerometer_z, 1 / s.gravity);
      u += stats::least_squares_solution(w.asDiagonal() * j, w.asDiagonal() * e, 1e-14);
    }
    CHECK_THAT(x.gravity * x.si, WithinAbs(u[1], 1e-11));
    CHECK_THAT(x.gravity * x.ci, WithinAbs(u[2], 1e-11));
    CHECK_THAT(angle(std::atan2(x.st, x.ct) - u[0]), WithinAbs(0, 1e-11));
  }
}

TEST_CASE("Stations in lanes have the bits of one station, and the draws of the stream", "[single_station]") {
  const random::Stream stream(11, 9);
  const StationSigmas s = sigmas();
  const sensor::StationDrawSd sd{0.006, 0.007, 150, 220, 0.001, 90, 95, 500};
  std::vector<sensor::StationTruth> truth;
  for (const survey::Attitude& at : {degrees(0, 10, 0), degrees(30, 35, 147), degrees(90, 90, 3)})
    truth.push_back({gravity_at(at), field_at(at), kGravity, kBh, kBd, 0});
  const int groups = 5, first_station = 8;
  const survey::LaneArray readings = sensor::draw_stations(truth, first_station, sd, stream, 1000, groups);
  for (const StationMethod m : kAll) {
    const survey::LaneArray found = solve_stations(readings, 3, groups, s, m);
    for (int t = 0; t < groups * simd::kGroup; ++t)
      for (int k = 0; k < 3; ++k) {
        const auto in = [&](int r) { return readings.value(t, k * survey::kStationReadingRows + r); };
        const auto out = [&](int r) { return found.value(t, k * kStationSolutionRows + r); };
        const ToolAxes<double> at = axes_from_accelerometers(survey::Vec3<double>{in(0), in(1), in(2)},
                                                             m == StationMethod::optimising, in(6), s);
        const FieldSolution<double> f = solve_field(at, survey::Vec3<double>{in(3), in(4), in(5)}, in(7), in(8), s, m);
        CHECK(out(kFoundRow) == f.found);
        CHECK(out(0) == at.si);
        CHECK(out(2) == at.st);
        CHECK(out(kTotalRow) == at.gravity);
        CHECK(out(kNorthRow) == f.north);
        CHECK(out(kNorthRow + 1) == f.east);
        CHECK(out(kNorthRow + 2) == f.vertical);
        CHECK(out(kNorthRow + 3) == f.axial);
        CHECK(out(kCostRow) == f.cost);
      }
  }
  for (const int t : {0, 13})
    for (int k = 0; k < 3; ++k) {
      const auto station = static_cast<std::uint32_t>(first_station + k);
      const auto trial = static_cast<std::uint64_t>(1000 + t);
      const auto in = [&](int r) { return readings.value(t, k * survey::kStationReadingRows + r); };
      const sensor::StationTruth& x = truth[static_cast<std::size_t>(k)];
      const double axial = 500 * stream.normal(trial, random::Channel::axial_magnetisation, station);
      CHECK_THAT(in(1), WithinRel(x.gravity_T.y + 0.006 * stream.normal(trial, random::Channel::accelerometer_noise,
                                                                        3 * station + 1),
                                  1e-13));
      CHECK_THAT(in(5), WithinRel(x.magnetic_T.z + axial +
                                      220 * stream.normal(trial, random::Channel::magnetometer_noise, 3 * station + 2),
                                  1e-12));
      CHECK_THAT(in(8), WithinRel(kBd + 95 * stream.normal(trial, random::Channel::station_reference, 4 * station + 2),
                                  1e-14));
      CHECK_THAT(in(survey::kAxialRow), WithinRel(axial, 1e-14));
    }
}

TEST_CASE("Single stations without an answer are flagged; bad sigmas are errors", "[single_station]") {
  const survey::Attitude at = degrees(40, 20, 10);
  CHECK_FALSE(solve_station({0, 0, 0}, field_at(at), kReference, sigmas(), StationMethod::basic).determined);
  const survey::Vec3<double> down = survey::down_T(at);
  // a field along gravity has no azimuth; rounding may leave one, so take it where it is exact
  CHECK_FALSE(solve_station({0, 0, 1}, {0, 0, 40000}, kReference, sigmas(), StationMethod::basic).determined);
  CHECK(solve_station(down, field_at(at), kReference, sigmas(), StationMethod::basic).determined);
  for (const StationMethod m : kAll) {
    StationSigmas s = sigmas();
    s.magnetometer_z = 0;
    CHECK_THROWS_AS(solve_station(down, field_at(at), kReference, s, m), InputError);
    s = sigmas();
    s.axial = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(solve_station(down, field_at(at), kReference, s, m), InputError);
    CHECK(station_method(station_method_names()[static_cast<std::size_t>(m)]) == m);
  }
  StationSigmas s = sigmas();
  s.horizontal = 0;
  CHECK_THROWS_AS(solve_station(down, field_at(at), kReference, s, StationMethod::extended_bh), InputError);
  CHECK_NOTHROW(solve_station(down, field_at(at), kReference, s, StationMethod::extended));
  CHECK_THROWS_AS(station_method("simpel"), InputError);
}
