// What fits predict of stations that they have not seen, and which set a run justifies (lib/multistation/hold_out.h).
#include "multistation/hold_out.h"

#include <cmath>
#include <numeric>
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

constexpr double kGravityNoise = 1e-4, kFieldNoise = 70;  // so little of gravity that no tilt of it shows in the field

FitOptions held_out_options(const std::string& set) {
  FitOptions o;
  o.parameters = ParameterSet::named(set);
  o.sizes = {kGravityNoise, kFieldNoise, kFieldNoise};
  o.total = kTotal;
  o.dip = kDip;
  return o;
}

/// A building well with noise; `error`: what the reference has more than the truth.
Stations noisy_well(const PerParameter<double>& tool, int stations, std::mt19937_64& random,
                    const ReferenceErrors& error = {}) {
  std::normal_distribution<double> normal;
  Stations out;
  for (int k = 0; k < stations; ++k) {
    const double x = k / (stations - 1.0);
    const survey::Attitude at{(3 + 87 * x) * kDegree, (30 + 40 * x) * kDegree, 122.0 * k * kDegree};
    StationReadings s = readings_of(
        tool, kGravity * survey::to_eigen(survey::down_T(at)), survey::to_eigen(survey::magnetic_T(at, kTotal, kDip)),
        reference_of(ResidualKind::survey, kGravity + error.gravity, kTotal + error.total, kDip + error.dip));
    for (double* v : {&s.gravity_T.x, &s.gravity_T.y, &s.gravity_T.z}) *v += kGravityNoise * normal(random);
    for (double* v : {&s.magnetic_T.x, &s.magnetic_T.y, &s.magnetic_T.z}) *v += kFieldNoise * normal(random);
    out.push_back(s);
  }
  return out;
}

std::vector<std::vector<int>> alternating(int stations) {
  std::vector<std::vector<int>> folds(2);
  for (int k = 0; k < stations; ++k) folds[static_cast<std::size_t>(k % 2)].push_back(k);
  return folds;
}

/// Shots of an instrument that is turned about `axis` (tool frame) while it points to an azimuth and a slope.
Stations turned_about(const Eigen::Vector3d& axis, double azimuth, double down, int rolls,
                      const PerParameter<double>& tool) {
  const Eigen::Vector3d pointed(std::cos(down) * std::cos(azimuth), std::cos(down) * std::sin(azimuth), std::sin(down)),
      field(kTotal * std::cos(kDip), 0, kTotal * std::sin(kDip));
  const Eigen::Matrix3d aim = Eigen::Quaterniond::FromTwoVectors(axis, pointed).toRotationMatrix();
  Stations out;
  for (int k = 0; k < rolls; ++k) {
    const Eigen::Matrix3d earth =
        Eigen::AngleAxisd(2 * kPi * k / rolls + 0.3, pointed).toRotationMatrix() * aim;  // earth from tool
    out.push_back(readings_of(tool, earth.transpose() * Eigen::Vector3d(0, 0, kGravity), earth.transpose() * field,
                              reference_of(ResidualKind::calibration, kGravity, kTotal, kDip)));
  }
  return out;
}

}  // namespace

TEST_CASE("Stations that a fit has not seen are off by as much as it says of them") {
  std::normal_distribution<double> normal;
  constexpr int kRuns = 150, kStations = 41;
  for (const bool estimates : {false, true}) {
    FitOptions o = held_out_options("12");
    o.reference = {1e-4, 100, 0.2 * kDegree};
    o.estimates_reference = estimates;
    // The claim by the a-priori sizes: those of the fit are uncertain by a tenth, and so the mean of 1 / s0^2 is not 1.
    const Fitter fitter = [&o](const Stations& s) { return FittedStations{fit(s, o), {}, 1}; };
    std::mt19937_64 random(7);
    double raw = 0, corrected = 0;
    std::vector<double> nees, median,
        coverage;  // of a run: its stations share the errors of the reference and of the fit
    for (int run = 0; run < kRuns; ++run) {
      PerParameter<double> tool{};
      for (int i = 0; i < o.parameters.size(); ++i)
        tool[static_cast<std::size_t>(o.parameters.index(i))] = normal(random) * o.parameters[i].prior_sd;
      const ReferenceErrors error{o.reference.gravity * normal(random), o.reference.total * normal(random),
                                  o.reference.dip * normal(random)};
      const CrossValidation c =
          cross_validate(noisy_well(tool, kStations, random, error), alternating(kStations), false, o, fitter);
      REQUIRE(c.stations.size() == kStations);
      CHECK(c.axis_scatter.empty());
      nees.push_back(c.nees);
      median.push_back(c.nees_median);
      coverage.push_back(c.coverage);
      raw += c.spread_before.total / kRuns;
      corrected += c.spread_after.total / kRuns;
    }
    const auto is_mean = [](const std::vector<double>& x, double expected) {
      const double n = kRuns;
      double mean = 0, squares = 0;
      for (const double v : x) mean += v / n;
      for (const double v : x) squares += (v - mean) * (v - mean) / (n - 1);
      CAPTURE(mean, std::sqrt(squares / n));
      CHECK(std::abs(mean - expected) < 4 * std::sqrt(squares / n));
      CHECK(std::sqrt(squares / n) < 0.05 * expected);
    };
    CAPTURE(estimates, raw, corrected);
    is_mean(nees, 1);
    CHECK(std::accumulate(median.begin(), median.end(), 0.0) / kRuns == Approx(1).epsilon(0.15));
    is_mean(coverage, 0.95);
    CHECK(corrected < 0.8 * raw);
    CHECK(corrected > kFieldNoise);
  }
}

TEST_CASE("Variance components find the sizes of a run's residuals, whatever was given") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 100;
  FitOptions given = held_out_options("12");
  const double gravity = given.sizes[0];
  given.sizes[0] *= 4;
  given.sizes[1] /= 3;
  std::array<double, kResiduals> sum{}, squares{};
  for (int run = 0; run < kRuns; ++run) {
    PerParameter<double> tool{};  // from the priors: what they take of the residuals is right on average
    for (int i = 0; i < given.parameters.size(); ++i)
      tool[static_cast<std::size_t>(given.parameters.index(i))] = normal(random) * given.parameters[i].prior_sd;
    const VarianceComponents v = residual_components(noisy_well(tool, 41, random), given);
    CHECK(v.converged);
    const FitOptions found = with_components(given, v);
    double redundancy = 0;
    for (std::size_t j = 0; j < kResiduals; ++j) {
      const double ratio = std::pow(found.sizes[j] / (j == 0 ? gravity : held_out_options("12").sizes[j]), 2);
      sum[j] += ratio / kRuns;
      squares[j] += ratio * ratio / kRuns;
      redundancy += v.groups[j].redundancy;
      CHECK(v.groups[j].estimated);
    }
    CHECK(redundancy > 3 * 41 - 12);
    CHECK(redundancy < 3 * 41 - 6);  // what is not learnt is the priors'
  }
  for (std::size_t j = 0; j < kResiduals; ++j)
    CHECK(std::abs(sum[j] - 1) < 4 * std::sqrt((squares[j] - sum[j] * sum[j]) / kRuns));
}

TEST_CASE("A wrong size of the residuals scales what they tell, not the priors, nor errors of the reference") {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  constexpr double kTooLarge = 3;
  FitOptions o = held_out_options("12");
  for (double& size : o.sizes) size *= kTooLarge;
  o.prior_sd[kMagnetometerBias] = 1e-3;  // nT: no run tells more
  const FittedStations f = fit_by_least_squares(noisy_well({}, 41, random), o);
  CHECK(f.s0 == Approx(1 / kTooLarge).epsilon(0.3));
  const int unlearnt = ParameterSet::named("6").size();  // mbx, after the errors of the accelerometers
  REQUIRE(o.parameters.index(unlearnt) == kMagnetometerBias);
  CHECK(std::sqrt(f.fit.covariance(unlearnt, unlearnt)) == Approx(1e-3).epsilon(1e-6));
  CHECK(f.fit.learnt[unlearnt] == Approx(0).margin(1e-6));
  FitOptions free = o;
  free.prior_sd.fill(kInfinity);
  const FittedStations g = fit_by_least_squares(noisy_well({}, 41, random), free);
  CHECK((g.fit.covariance - g.s0 * g.s0 * g.fit.inverse).norm() < 1e-9 * g.fit.covariance.norm());

  // Tools are drawn from the priors and references from their sds: what a fit says of new stations holds, all the same.
  constexpr int kRuns = 100, kStations = 81;
  o.prior_sd = default_priors();
  o.reference = {1e-4, 300, 0.3 * kDegree};
  for (const bool estimates : {false, true}) {
    o.estimates_reference = estimates;
    double nees = 0;
    for (int run = 0; run < kRuns; ++run) {
      PerParameter<double> tool{};
      for (int i = 0; i < o.parameters.size(); ++i)
        tool[static_cast<std::size_t>(o.parameters.index(i))] = normal(random) * o.parameters[i].prior_sd;
      const ReferenceErrors error{o.reference.gravity * normal(random), o.reference.total * normal(random),
                                  o.reference.dip * normal(random)};
      const Stations well = noisy_well(tool, kStations, random, error);
      const Fitter fitter = [&o](const Stations& s) {
        FittedStations fitted = fit_by_least_squares(s, o);
        if (o.estimates_reference) return fitted;
        // Errors of a reference that is not estimated are in the residuals, too: their size alone is not to be claimed.
        fitted.s0 = 1 / kTooLarge;
        claim_for_variance(fitted.fit, o, fitted.s0 * fitted.s0);
        return fitted;
      };
      nees += cross_validate(well, alternating(kStations), false, o, fitter).nees / kRuns;
    }
    CAPTURE(estimates);
    CHECK(nees == Approx(1).epsilon(0.1));
  }
}

TEST_CASE("The criterion takes the parameters that are there, and no more") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 60;
  for (const std::string truth : {"6", "9"}) {
    int right = 0, too_few = 0;
    for (int run = 0; run < kRuns; ++run) {
      PerParameter<double> tool{};
      for (int axis = 0; axis < 3; ++axis) {
        tool[static_cast<std::size_t>(kMagnetometerBias + axis)] = 200 * normal(random);
        if (truth == "9") tool[static_cast<std::size_t>(kRotation + axis)] = axis == 2 ? 0.01 : -0.008;
      }
      const Stations well = noisy_well(tool, 61, random);
      std::string best;
      double least = kInfinity;
      for (const std::string& name : {"6", "9", "18"}) {
        FitOptions o = held_out_options(name);
        o.prior_sd.fill(kInfinity);
        const double value = information_criterion(fit(well, o), o, well.size());
        if (value < least) {
          least = value;
          best = name;
        }
      }
      right += best == truth;
      too_few += best == "6" && truth == "9";
    }
    CAPTURE(truth, right);
    CHECK(right >= 0.9 * kRuns);  // three more unknowns gain chi-squared(3): above 3 ln 183 = 15.6 in 1 of 700 runs
    CHECK(too_few == 0);
  }
}

TEST_CASE("A parameter that a run says nothing of counts for nothing") {
  std::mt19937_64 random(5);
  // Gravity of the accelerometers alone: what their priors say is far better than what 1 m/s2 of noise tells.
  FitOptions o = held_out_options("12");
  o.sizes[0] = 1000;
  o.sizes[1] = o.sizes[2] = 1e7;
  const Stations well = noisy_well({}, 41, random);
  CHECK(learnt_parameters(fit(well, o), o) < 1e-3);
  o.prior_sd.fill(kInfinity);
  CHECK(learnt_parameters(fit(well, o), o) == Approx(12).epsilon(1e-12));
}

TEST_CASE("The axis of turned shots is found, and its scatter is what errors of the tool make") {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.06, 0.99, -0.04).normalized();
  std::vector<Group> groups{{turned_about(axis, 0.4, 0.1, 8, {})}, {turned_about(axis, 2.5, -0.3, 8, {})}};
  const Eigen::Vector3d found = turning_axis(groups, {});
  CHECK(std::abs(found.dot(axis)) == Approx(1).epsilon(1e-12));
  for (const Group& group : groups) CHECK(scatter_of_axis(group.stations, {}, found) < 1e-7);
  // An axis that is off by 0.1 draws a cone.
  const Eigen::Vector3d off = Eigen::AngleAxisd(0.1, axis.unitOrthogonal()) * axis;
  CHECK(scatter_of_axis(groups[0].stations, {}, off) == Approx(0.1).epsilon(1e-6));

  // A wrong shot without weight does not turn it.
  groups[0].stations[3].magnetic_T.x += 20000;
  CHECK(std::abs(turning_axis(groups, {}).dot(axis)) < 1 - 1e-4);
  groups[0].weights = {1, 1, 1, 0, 1, 1, 1, 1};
  CHECK(std::abs(turning_axis(groups, {}).dot(axis)) == Approx(1).epsilon(1e-12));

  PerParameter<double> tool{};
  tool[kMagnetometerBias] = 900;
  tool[kMagnetometerScale + 1] = 0.03;
  tool[kAccelerometerBias + 2] = 0.2;
  Stations shots = turned_about({0, 0, 1}, 1.0, 0.2, 5, tool);
  for (const auto& [azimuth, down] : {std::pair{0.4, 0.1}, {2.5, -0.3}})
    for (const StationReadings& s : turned_about(axis, azimuth, down, 8, tool)) shots.push_back(s);
  for (const StationReadings& s : turned_about({1, 0, 0}, -1.0, 1.0, 5, tool)) shots.push_back(s);
  std::vector<std::vector<int>> folds(2);
  for (int k = 0; k < 16; ++k) folds[static_cast<std::size_t>(k / 8)].push_back(5 + k);
  FitOptions o = held_out_options("12");
  o.residuals = ResidualKind::calibration;
  o.prior_sd.fill(kInfinity);
  o.sizes = {0.02, 200, 0.004};
  o.dip = 60 * kDegree;  // unknown: 12 deg off
  o.estimates_reference = true;
  o.reference = {0, 0, kInfinity};
  const CrossValidation c =
      cross_validate(shots, folds, true, o, [&o](const Stations& s) { return fit_by_least_squares(s, o); });
  CHECK(c.axis_rms_before > 0.5 * kDegree);
  CHECK(c.axis_rms < 1e-5);
  CHECK(c.axis_scatter.size() == 2);
  CHECK(c.stations.size() == 16);
  CHECK(c.spread_after.total < 1e-3);
  CHECK(c.spread_before.total > 100);
}

TEST_CASE("A fit that does not converge is not judged") {
  std::mt19937_64 random(5);
  FitOptions o = held_out_options("12");
  o.max_iterations = 1;
  PerParameter<double> tool{};
  tool[kMagnetometerBias] = 3000;
  CHECK_THROWS_AS(cross_validate(noisy_well(tool, 21, random), alternating(21), false, o,
                                 [&o](const Stations& s) { return fit_by_least_squares(s, o); }),
                  InputError);
}
