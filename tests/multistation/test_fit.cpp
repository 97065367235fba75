#include "multistation/fit.h"

#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "field.h"

using namespace surveymc;
using namespace surveymc::multistation;
using test::kDip, test::kGravity, test::kTotal;

namespace {

/// A well that builds from 3 to 90 deg and turns, with a toolface that goes round.
std::vector<survey::Attitude> building_well(int stations) {
  std::vector<survey::Attitude> at;
  for (int k = 0; k < stations; ++k) {
    const double x = k / (stations - 1.0);
    at.push_back({(3 + 87 * x) * kDegree, (30 + 40 * x) * kDegree, 122.0 * k * kDegree});
  }
  return at;
}

struct Noise {
  double gravity = 0, magnetic = 0;
};
std::vector<StationReadings> readings(const PerParameter<double>& tool, const FitOptions& o, int stations,
                                      const Noise& noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<StationReadings> out;
  for (const survey::Attitude& at : building_well(stations)) {
    StationReadings s = readings_of(tool, kGravity * survey::to_eigen(survey::down_T(at)),
                                    survey::to_eigen(survey::magnetic_T(at, kTotal, kDip)),
                                    reference_of(o.residuals, kGravity, kTotal, kDip));
    for (double* v : {&s.gravity_T.x, &s.gravity_T.y, &s.gravity_T.z}) *v += noise.gravity * normal(random);
    for (double* v : {&s.magnetic_T.x, &s.magnetic_T.y, &s.magnetic_T.z}) *v += noise.magnetic * normal(random);
    out.push_back(s);
  }
  return out;
}

PerParameter<double> random_tool(const ParameterSet& set, double size, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  PerParameter<double> tool{};
  for (int i = 0; i < set.size(); ++i)
    tool[static_cast<std::size_t>(set.index(i))] = size * normal(random) * set[i].prior_sd;
  return tool;
}

FitOptions options(const std::string& set) {
  FitOptions o;
  o.parameters = ParameterSet::named(set);
  o.total = kTotal;
  o.dip = kDip;
  return o;
}

/// Independent of the kernel: Gauss-Newton by Eigen's QR on the readable model, priors as rows.
Eigen::VectorXd oracle(const std::vector<StationReadings>& stations, const FitOptions& o,
                       const std::vector<double>& weights) {
  const int p = o.parameters.size(), rows = 3 * static_cast<int>(stations.size());
  PerParameter<double> at{};
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows + p, p);
    Eigen::VectorXd r = Eigen::VectorXd::Zero(rows + p);
    for (std::size_t k = 0; k < stations.size(); ++k) {
      const StationModel m = station_model(stations[k], at, o.residuals, o.sizes);
      const double w = weights.empty() ? 1 : std::sqrt(weights[k]);
      r.segment<3>(3 * static_cast<int>(k)) = w * m.residual;
      for (int i = 0; i < p; ++i)
        j.block<3, 1>(3 * static_cast<int>(k), i) = w * m.by_parameter.col(o.parameters.index(i));
    }
    for (int i = 0; i < p; ++i) {
      const auto index = static_cast<std::size_t>(o.parameters.index(i));
      j(rows + i, i) = 1 / o.prior_sd[index];
      r[rows + i] = at[index] / o.prior_sd[index];
    }
    Eigen::VectorXd length = j.colwise().norm();
    const Eigen::VectorXd step = length.cwiseInverse().asDiagonal() *
                                 (j * length.cwiseInverse().asDiagonal()).colPivHouseholderQr().solve(-r).eval();
    for (int i = 0; i < p; ++i) at[static_cast<std::size_t>(o.parameters.index(i))] += step[i];
  }
  Eigen::VectorXd x(p);
  for (int i = 0; i < p; ++i) x[i] = at[static_cast<std::size_t>(o.parameters.index(i))];
  return x;
}

}  // namespace

TEST_CASE("Readings without noise give the tool back, with every set and without priors") {
  std::mt19937_64 random(1);
  for (const char* name : {"6", "9", "12", "15", "18"}) {
    FitOptions o = options(name);
    o.prior_sd.fill(kInfinity);
    o.step_tolerance = 1e-10;
    const PerParameter<double> tool = random_tool(o.parameters, 3, random);
    const Fit f = fit(readings(tool, o, 41, {}, random), o);
    REQUIRE(f.converged);
    for (int i = 0; i < o.parameters.size(); ++i) {
      CAPTURE(name, o.parameters[i].name);
      // Rounding of readings, 1e-16 of them, times the condition (below 100).
      CHECK(std::abs(f.estimate[i] - tool[static_cast<std::size_t>(o.parameters.index(i))]) <
            1e-7 * o.parameters[i].prior_sd);
      CHECK(f.learnt[i] == 1);
    }
    CHECK(f.residuals.cwiseAbs().maxCoeff() < 1e-8);
  }
}

TEST_CASE("The kernel's minimum is that of a QR solution of the readable model") {
  std::mt19937_64 random(2);
  for (const ResidualKind kind : {ResidualKind::survey, ResidualKind::calibration})
    for (const char* name : {"6", "9", "12", "15", "18", "21"}) {
      FitOptions o = options(name);
      o.residuals = kind;
      if (kind == ResidualKind::calibration) o.sizes = {0.006, 70, 0.002};
      o.step_tolerance = 1e-10;
      const PerParameter<double> tool = random_tool(o.parameters, 1, random);
      const std::vector<StationReadings> stations = readings(tool, o, 30, {0.006, 70}, random);
      std::vector<double> weights;
      std::uniform_real_distribution<double> uniform(0, 1);
      for (int k = 0; k < 30; ++k) weights.push_back(uniform(random));
      for (const std::vector<double>& w : {std::vector<double>{}, weights}) {
        const Fit f = fit(stations, o, w);
        const Eigen::VectorXd x = oracle(stations, o, w);
        REQUIRE(f.converged);
        for (int i = 0; i < o.parameters.size(); ++i) {
          CAPTURE(name, o.parameters[i].name, w.size());
          CHECK(std::abs(f.estimate[i] - x[i]) < 1e-7 * o.parameters[i].prior_sd);
        }
      }
    }
}

TEST_CASE("A list of parameters is estimated as if the others were known to be zero") {
  std::mt19937_64 random(3);
  FitOptions o = options("6");
  o.parameters = ParameterSet::of({"abz", "mbx", "mbz", "msz", "rz", "axz"});
  o.step_tolerance = 1e-10;
  const PerParameter<double> tool = random_tool(o.parameters, 1, random);
  const std::vector<StationReadings> stations = readings(tool, o, 30, {0.006, 70}, random);
  const Fit f = fit(stations, o);
  const Eigen::VectorXd x = oracle(stations, o, {});
  REQUIRE(f.converged);
  for (int i = 0; i < 6; ++i) CHECK(std::abs(f.estimate[i] - x[i]) < 1e-7 * o.parameters[i].prior_sd);
  for (int i = 0; i < kParameters; ++i)
    if (!o.parameters.contains(i)) CHECK(f.tool[static_cast<std::size_t>(i)] == 0);
}

TEST_CASE("A station of weight zero counts as absent") {
  std::mt19937_64 random(4);
  const FitOptions o = options("12");
  std::vector<StationReadings> stations = readings(random_tool(o.parameters, 1, random), o, 30, {0.006, 70}, random);
  const Fit without = fit(stations, o);
  stations.push_back(stations.front());
  stations.back().magnetic_T.x += 20000;
  std::vector<double> weights(31, 1);
  weights.back() = 0;
  const Fit with = fit(stations, o, weights);
  for (int i = 0; i < 12; ++i) CHECK(with.estimate[i] == Approx(without.estimate[i]).epsilon(1e-9));
  CHECK(with.covariance.isApprox(without.covariance, 1e-9));
}

TEST_CASE("Lanes have the bits of one trial alone, whatever the other lanes do") {
  std::mt19937_64 random(5);
  const int trials = 13, count = 17;
  for (const char* name : {"6", "15", "21"})
    for (const bool estimates_reference : {false, true}) {
      FitOptions o = options(name);
      o.estimates_reference = estimates_reference;
      o.reference = {0.003, 130, 0.2 * kDegree};
      const FitPlan plan = fit_plan(o);
      SixAxisBlock block(trials, count);
      for (int t = 0; t < trials; ++t) {
        const std::vector<StationReadings> s =
            readings(random_tool(o.parameters, 1 + t, random), o, count, {0.006, 70}, random);
        const auto put = [&](survey::LaneArray& a, int r, double v) {
          a.row(t / simd::kGroup, r)[t % simd::kGroup] = v;
        };
        for (int k = 0; k < count; ++k) {
          const StationReadings& q = s[static_cast<std::size_t>(k)];
          put(block.gravity, 3 * k, q.gravity_T.x), put(block.gravity, 3 * k + 1, q.gravity_T.y);
          put(block.gravity, 3 * k + 2, q.gravity_T.z);
          put(block.magnetic, 3 * k, q.magnetic_T.x), put(block.magnetic, 3 * k + 1, q.magnetic_T.y);
          put(block.magnetic, 3 * k + 2, q.magnetic_T.z);
        }
        put(block.reference, 0, s[0].reference.gravity), put(block.reference, 1, s[0].reference.first);
        put(block.reference, 2, s[0].reference.second);
      }
      FitBlock out(trials, o, true);
      fit_block(block, plan, o.parameters, out);
      for (int t = 0; t < trials; ++t) {
        const auto offset = [&](const survey::LaneArray& a) { return a.row(t / simd::kGroup, 0) + t % simd::kGroup; };
        const FitData d{offset(block.gravity), offset(block.magnetic), offset(block.reference), nullptr, count, 0};
        std::array<double, kUnknowns> start{};
        FitSolution<double> s;
        solve_fit<double>(plan, d, start, s);
        CAPTURE(name, t);
        CHECK(out.converged.value(t, 0) == s.converged);
        CHECK(s.converged == 1);
        CHECK(out.iterations.value(t, 0) == s.iterations);
        CHECK(out.cost.value(t, 0) == s.cost);
        for (int i = 0; i < o.parameters.size(); ++i) {
          const auto place = static_cast<std::size_t>(i);  // these sets have whole kinds
          CHECK(out.estimate.value(t, i) == plan.scale[static_cast<std::size_t>(o.parameters.index(i))] * s.x[place]);
        }
      }
    }
}

TEST_CASE("Estimates scatter as the sensitivity says, and the posterior is the claim") {
  // Tools drawn from the priors, noise of the sizes: the mean NEES is the number of parameters, its sd sqrt(2 p / n).
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (const char* name : {"6", "12", "18"}) {
    FitOptions o = options(name);
    o.sizes = {0.0006, 70, 70};  // of one accelerometer; its part of the direction is negligible
    const int p = o.parameters.size(), trials = 300;
    double nees = 0;
    for (int t = 0; t < trials; ++t) {
      const PerParameter<double> tool = random_tool(o.parameters, 1, random);
      const Fit f = fit(readings(tool, o, 30, {0.0006, 70}, random), o);
      REQUIRE(f.converged);
      Eigen::VectorXd error = f.estimate;
      for (int i = 0; i < p; ++i) error[i] -= tool[static_cast<std::size_t>(o.parameters.index(i))];
      nees += error.dot(f.covariance.ldlt().solve(error)) / trials;
    }
    CAPTURE(name, nees);
    CHECK(std::abs(nees - p) < 4 * std::sqrt(2.0 * p / trials));
  }
}

TEST_CASE("What a sensitivity claims for residuals of another variance is the claim of a fit") {
  std::mt19937_64 random(3);
  for (const bool estimates_reference : {false, true}) {
    FitOptions o = options("12");
    o.estimates_reference = estimates_reference;
    o.reference = {0.003, 130, 0.2 * kDegree};
    const std::vector<StationReadings> clean = readings({}, o, 20, {}, random);
    std::vector<double> weights(clean.size(), 0.6);
    Fit f = fit(clean, o, weights);
    claim_for_variance(f, o, 1.7);
    const Eigen::MatrixXd claimed = fit_sensitivity(clean, {}, o, weights).claimed(1.7);
    const Eigen::VectorXd per_sd = f.posterior.diagonal().cwiseSqrt().cwiseInverse();
    CHECK((per_sd.asDiagonal() * (claimed - f.posterior) * per_sd.asDiagonal()).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("The sensitivity is the change of the estimate by each input") {
  std::mt19937_64 random(7);
  for (const bool estimates_reference : {false, true}) {
    FitOptions o = options("12");
    o.estimates_reference = estimates_reference;
    o.reference = {0.003, 130, 0.2 * kDegree};
    o.step_tolerance = 1e-11;
    const PerParameter<double> tool{};
    const std::vector<StationReadings> clean = readings(tool, o, 20, {}, random);
    const FitSensitivity s = fit_sensitivity(clean, tool, o);
    const auto change = [&](auto move, double h) {
      std::vector<StationReadings> up = clean, down = clean;
      move(up, h);
      move(down, -h);
      return Eigen::VectorXd((fit(up, o).estimate - fit(down, o).estimate) / (2 * h));
    };
    const Eigen::VectorXd sd = s.posterior.diagonal().cwiseSqrt();
    const auto agree = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double h) {
      CHECK(((a - b) * h).cwiseQuotient(sd).cwiseAbs().maxCoeff() < 1e-4);  // h^2 of the curvature
    };
    agree(change([](auto& r, double h) { r[4].gravity_T.y += h; }, 1e-3), s.by_gravity[4].topRows(12).col(1), 1e-3);
    agree(change([](auto& r, double h) { r[7].magnetic_T.z += h; }, 10), s.by_magnetic[7].topRows(12).col(2), 10);
    Eigen::MatrixXd of_reference = Eigen::MatrixXd::Zero(12, 3);
    for (const auto& m : s.by_reference) of_reference += m.topRows(12);
    agree(change(
              [](auto& r, double h) {
                for (auto& q : r) q.reference.gravity += h;
              },
              1e-4),
          of_reference.col(0), 1e-4);
    agree(change(
              [](auto& r, double h) {
                for (auto& q : r) q.reference = reference_of(ResidualKind::survey, kGravity, kTotal + h, kDip);
              },
              10),
          of_reference.col(1), 10);
    agree(change(
              [](auto& r, double h) {
                for (auto& q : r) q.reference = reference_of(ResidualKind::survey, kGravity, kTotal, kDip + h);
              },
              1e-4),
          of_reference.col(2), 1e-4);
    // A true rotation, which the set has not; and a true bias, which it has: less the truth, the pull of the prior.
    for (const int index : {kRotation + 1, kMagnetometerBias + 2}) {
      const double h = 0.1 * parameter(index).prior_sd;
      PerParameter<double> moved{};
      const auto estimate = [&](double by) {
        moved[static_cast<std::size_t>(index)] = by;
        Eigen::VectorXd e = fit(readings(moved, o, 20, {}, random), o).estimate;
        for (int i = 0; i < 12; ++i) e[i] -= o.parameters.index(i) == index ? by : 0;
        return e;
      };
      agree((estimate(h) - estimate(-h)) / (2 * h), s.by_truth.topRows(12).col(index), h);
    }
  }
}

TEST_CASE("A reference that is estimated is found, and one that is considered widens the covariance") {
  std::mt19937_64 random(8);
  FitOptions o = options("12");
  o.reference = {kInfinity, kInfinity, kInfinity};
  o.estimates_reference = true;
  o.step_tolerance = 1e-10;
  std::vector<StationReadings> stations = readings({}, o, 41, {}, random);
  for (StationReadings& s : stations) s.reference = reference_of(o.residuals, kGravity - 0.004, kTotal - 150, kDip);
  const Fit f = fit(stations, o);
  REQUIRE(f.converged);
  CHECK(f.reference.total == Approx(150).epsilon(1e-3));
  CHECK(f.reference.gravity == Approx(0.004).epsilon(1e-3));
  CHECK(std::abs(f.reference.dip) < 1e-6);

  o.estimates_reference = false;
  o.reference = {0.003, 130, 0.2 * kDegree};
  const Fit considered = fit(readings({}, o, 41, {}, random), o);
  const Eigen::MatrixXd more = considered.covariance - considered.posterior;
  CHECK(more.diagonal().minCoeff() >= 0);
  CHECK(more(8, 8) > considered.posterior(8, 8));  // mbz
}

namespace {

/// The residuals of another open program (github.com/mwdstd/mwdstdcore, AGPL-3.0; its formulas, not its code): lengths
/// of gravity and field and the dip, of readings that are divided by 1 + scale, then freed of biases, then turned back
/// to first order; then the priors. x: 15 errors in our order and signs, then those of the reference, all over their
/// priors.
Eigen::VectorXd peer_residuals(const std::vector<StationReadings>& stations, const FitOptions& o,
                               const Eigen::VectorXd& x) {
  const auto value = [&](int i) { return x[i] * o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))]; };
  const auto three = [&](const char* first) {
    int at = 0;
    while (std::string(o.parameters[at].name) != first) ++at;
    return Eigen::Vector3d(value(at), value(at + 1), value(at + 2));
  };
  const Eigen::Vector3d ab = three("abx"), as = three("asx"), mb = three("mbx"), ms = three("msx"), r = three("rx");
  const Eigen::Array3d one(1, 1, 1);
  Eigen::VectorXd out(3 * static_cast<Eigen::Index>(stations.size()) + x.size());
  Eigen::Index row = 0;
  for (const StationReadings& s : stations) {
    const Eigen::Vector3d g = (survey::to_eigen(s.gravity_T).array() / (one + as.array())).matrix() - ab,
                          unturned = (survey::to_eigen(s.magnetic_T).array() / (one + ms.array())).matrix() - mb,
                          b = unturned - r.cross(unturned);
    out[row++] = (g.norm() - kGravity - x[15] * o.reference.gravity) / o.sizes[0];
    out[row++] = (b.norm() - kTotal - x[16] * o.reference.total) / o.sizes[1];
    out[row++] = (std::asin(g.dot(b) / (g.norm() * b.norm())) - kDip - x[17] * o.reference.dip) * kTotal / o.sizes[1];
  }
  out.tail(x.size()) = x;
  return out;
}

}  // namespace

TEST_CASE("Fifteen errors are those of another program's residuals and order of correction, to second order") {
  FitOptions o = options("15");
  for (int i = 0; i < 3; ++i)
    o.prior_sd[static_cast<std::size_t>(kMagnetometerBias + i)] = 2000;  // as its set-up has them
  o.estimates_reference = true;
  o.reference = {0.01, 130, 0.2 * kDegree};
  o.sizes = {0.0015, 60, 60};
  PerParameter<double> tool{};  // its test's
  const std::array<double, 12> errors{0.005, -0.005, 0,   500e-6,  -500e-6,  500e-6,
                                      -300,  300,    700, 1600e-6, -2000e-6, -2200e-6};
  for (std::size_t i = 0; i < 3; ++i) {
    tool[kAccelerometerBias + i] = errors[i];
    tool[kAccelerometerScale + i] = errors[3 + i];
    tool[kMagnetometerBias + i] = errors[6 + i];
    tool[kMagnetometerScale + i] = errors[9 + i];
  }
  std::mt19937_64 random(15);
  std::normal_distribution<double> normal;
  std::vector<StationReadings> run;  // its second trajectory
  constexpr int kStations = 20;
  for (int k = 0; k < kStations; ++k) {
    const survey::Attitude at{(8 + 79.0 * k / (kStations - 1)) * kDegree, 285 * kDegree,
                              540.0 * k / (kStations - 1) * kDegree};
    StationReadings s = readings_of(tool, kGravity * survey::to_eigen(survey::down_T(at)),
                                    survey::to_eigen(survey::magnetic_T(at, kTotal, kDip)),
                                    reference_of(o.residuals, kGravity, kTotal, kDip));
    for (double* v : {&s.gravity_T.x, &s.gravity_T.y, &s.gravity_T.z}) *v += o.sizes[0] * normal(random);
    for (double* v : {&s.magnetic_T.x, &s.magnetic_T.y, &s.magnetic_T.z}) *v += o.sizes[1] * normal(random);
    run.push_back(s);
  }
  Eigen::VectorXd x = Eigen::VectorXd::Zero(18);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::VectorXd residual = peer_residuals(run, o, x);
    Eigen::MatrixXd j(residual.size(), x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      constexpr double kStep = 1e-4;
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(x.size(), i);
      j.col(i) = (peer_residuals(run, o, x + step) - peer_residuals(run, o, x - step)) / (2 * kStep);
    }
    x -= j.householderQr().solve(residual);
  }
  const Fit f = fit(run, o);
  REQUIRE(f.converged);
  for (int i = 0; i < 15; ++i) {
    const double theirs = x[i] * o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))];
    INFO(o.parameters[i].name << ": " << f.estimate[i] << " and " << theirs);
    // Asked for is a third of the posterior sd. Products of errors, up to 700 nT times 0.002, are some hundredths.
    CHECK(std::abs(f.estimate[i] - theirs) < 0.1 * std::sqrt(f.posterior(i, i)));
  }
}

TEST_CASE("What stations and priors do not determine is an error, not a number") {
  std::mt19937_64 random(9);
  FitOptions o = options("6");
  o.prior_sd.fill(kInfinity);
  std::vector<StationReadings> stations = readings({}, o, 30, {0.006, 70}, random);
  const std::vector<StationReadings> one(30, stations.front());
  bool refused = false;
  try {
    refused = !fit(one, o).converged;
  } catch (const InputError&) {
    refused = true;
  }
  CHECK(refused);
  o.prior_sd[kMagnetometerBias] = 0;
  CHECK_THROWS_WITH(fit(stations, o), Catch::Contains("mbx"));
  o.sizes[1] = 0;
  CHECK_THROWS_AS(fit(stations, o), InputError);
}
