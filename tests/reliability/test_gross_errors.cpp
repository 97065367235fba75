#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "reliability/gross_error_lanes.h"
#include "reliability/gross_error_trials.h"
#include "reliability/identification.h"
#include "reliability/snooping.h"
#include "reliability_cases.h"
#include "simd/instruction_set.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Index;

namespace {

constexpr Index kBx = 3;
/// Tests of one trial by two independent derivations, of one minimum: what is left is rounding, and both stop within
/// 1e-9 sd of it.
void check_same_tests(const TrialTests& fast, const TrialTests& slow) {
  REQUIRE(fast.converged);
  REQUIRE(slow.converged);
  CHECK_THAT(fast.largest, WithinRel(slow.largest, 1e-6));
  for (Index i = 0; i < slow.w.size(); ++i) CHECK_THAT(fast.w[i], WithinAbs(slow.w[i], 1e-5));
}

}  // namespace

TEST_CASE("Trials on lanes are those of the general adjustment") {
  // Here three conditions in relative units, there Eigen with the angles' conditions.
  int compared = 0;
  for (const AdjustmentMode mode : kAllModes)
    for (const double inclination : {0.0, 1e-8, 30.0, 90.0, 150.0, 180.0})
      for (const double toolface : {0.0, 45.0, 200.0}) {
        const GrossErrorTrials trials(model_of(mode), {degrees(inclination, toolface, 60)}, {{kBx, 1500}, {2, -0.05}},
                                      random::Stream(3, 20));
        REQUIRE(trials.on_lanes());
        survey::LaneArray without(2, kTestRows), with(2, kTestRows);
        trials.simulate(8, without, with, 2);
        for (int t = 0; t < 16; t += 5)
          for (const bool with_errors : {false, true}) {
            const TrialTests fast = GrossErrorTrials::tests_of(with_errors ? with : without, t);
            const TrialTests slow = GrossErrorTrials::tests_of(
                trials.adjusted(trials.readings(static_cast<std::uint64_t>(8 + t), with_errors)));
            check_same_tests(fast, slow);
            CHECK_THAT(fast.omega, WithinRel(slow.omega, 1e-6) || WithinAbs(slow.omega, 1e-8));
            CHECK(fast.suspects == slow.suspects);
            ++compared;
          }
      }
  CHECK(compared == 4 * 6 * 3 * 4 * 2);
}

namespace {

/// Shots with shared references; with a rotational shot, of one direction.
GrossErrorTrials shots_of(bool rotational, int shots, double inclination, const std::vector<GrossError>& errors) {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared);
  m.rotational_shot = rotational;
  std::vector<survey::Attitude> attitudes;
  for (int k = 0; k < shots; ++k)
    attitudes.push_back(
        degrees(inclination + (rotational ? 0 : 7.0 * k), 185 + 76.0 * k, rotational ? 100 : 100 + 11 * k));
  return {m, attitudes, errors, random::Stream(3, 20)};
}

}  // namespace

TEST_CASE("Several stations on lanes are those of the general adjustment, and so are the searches") {
  // Here unknowns and Cholesky's factor of J'J, there conditions. Searches: redundancy matrix here, whitened
  // misclosures there.
  int searched = 0, found = 0;
  RedundancyFamily family;  // of one trial after the other: nothing of the one before may be left in it
  for (const bool rotational : {true, false})
    for (const int shots : {2, 3, 4})
      for (const double inclination : {0.0, 45.0, 90.0, 135.0}) {
        const GrossErrorTrials trials = shots_of(rotational, shots, inclination, {{6 + 1, .1211}, {6 + kBx, -761.8}});
        REQUIRE(trials.shots_on_lanes());
        REQUIRE_FALSE(trials.on_lanes());
        const ShotsRows rows = trials.shots_rows();
        survey::LaneArray without(1, rows.tests()), with(1, rows.all());
        trials.simulate_shots(16, without, with, 1);
        for (const int t : {0, 5})
          for (const bool with_errors : {false, true}) {
            const TrialTests fast = trials.tests_of_shots(with_errors ? with : without, t);
            const StationAdjustment a =
                trials.adjusted(trials.readings(static_cast<std::uint64_t>(16 + t), with_errors));
            const TrialTests slow = GrossErrorTrials::tests_of(a);
            check_same_tests(fast, slow);
            CHECK_THAT(fast.omega, WithinRel(slow.omega, 1e-6));
            if (!with_errors) continue;
            trials.model_of_shots(with, t, family.begin());
            const RedundancyModel& model = family.whole();
            CHECK(model.redundancy() == a.parity.redundancy);
            CHECK(inseparable_groups(model) == inseparable_groups(a.parity));
            const auto alike = [&](const SnoopingResult& x, const SnoopingResult& y) {
              const auto explanations = [](const SnoopingResult& r) {  // which of the ties comes first is rounding
                auto all = r.ties;
                all.push_back(r.rejected);
                if (all.size() > 1) std::sort(all.begin(), all.end());
                return all;
              };
              CHECK(explanations(x) == explanations(y));
              CHECK(x.accepted == y.accepted);
              CHECK(x.exhausted == y.exhausted);
              ++searched;
              found += !x.rejected.empty();
            };
            for (const double critical : {kCritical, 1.5, 0.3}) {  // low ones reject until little or nothing is left
              alike(data_snooping(family, critical), data_snooping(a.parity, critical));
              alike(iterative_snooping(family, critical), iterative_snooping(a.parity, critical));
              alike(iterative_snooping_with_readmission(family, critical),
                    iterative_snooping_with_readmission(a.parity, critical));
              alike(pair_search(family, critical), pair_search(a.parity, critical));
            }
          }
      }
  CHECK(searched == 2 * 3 * 4 * 2 * 3 * 4);
  CHECK(found > searched / 2);
}

TEST_CASE("Several stations on lanes: the same bits for all neighbours and instruction sets") {
  const GrossErrorTrials trials = shots_of(true, 3, 45, {{7, .1211}});
  const ShotsRows rows = trials.shots_rows();
  survey::LaneArray a(2, rows.tests()), b(2, rows.all()), c(1, rows.tests()), d(1, rows.all());
  trials.simulate_shots(0, a, b, 2);
  trials.simulate_shots(8, c, d, 1);
  for (int t = 0; t < 8; ++t) {
    for (int r = 0; r < rows.tests(); ++r) CHECK(a.value(8 + t, r) == c.value(t, r));
    for (int r = 0; r < rows.all(); ++r) CHECK(b.value(8 + t, r) == d.value(t, r));
  }
  if (simd::instruction_set() != simd::InstructionSet::v4) return;
  reliability::isa_v3::shots_trials(trials.shots_batch(8, c, d, 1));
  for (int t = 0; t < 8; ++t)
    for (int r = 0; r < rows.all(); ++r) REQUIRE(b.value(8 + t, r) == d.value(t, r));
}

TEST_CASE("One lane does not depend on its neighbours") {
  const GrossErrorTrials trials(model_of(AdjustmentMode::sse), {degrees(30, 2, 2)}, {{kBx, 9000}},
                                random::Stream(3, 20));
  survey::LaneArray a(2, kTestRows), b(2, kTestRows), c(1, kTestRows), d(1, kTestRows);
  trials.simulate(0, a, b, 2);
  trials.simulate(8, c, d, 1);
  for (int t = 0; t < 8; ++t)
    for (int r = 0; r < kTestRows; ++r) {
      CHECK(a.value(8 + t, r) == c.value(t, r));
      CHECK(b.value(8 + t, r) == d.value(t, r));
    }
}

TEST_CASE("Readings of a trial: the errors are added to the same noise") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true);
  const std::vector<survey::Attitude> at{degrees(45, 185, 100), degrees(45, 261, 100)};
  const GrossErrorTrials trials(m, at, {{9, 500}, {13, -90}}, random::Stream(3, 20));
  CHECK_FALSE(trials.on_lanes());
  const StationReadings a = trials.readings(7, false), b = trials.readings(7, true), other = trials.readings(8, false);
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < kReadings; ++i) {
      CHECK_THAT(b.readings[k][i] - a.readings[k][i], WithinAbs(k == 1 && i == 3 ? 500 : 0, 1e-9));
      CHECK(a.readings[k][i] != other.readings[k][i]);
    }
  CHECK_THAT(b.references[1] - a.references[1], WithinAbs(-90, 1e-9));
  CHECK(a.references[0] == b.references[0]);
}

TEST_CASE("Noise has the variances of the adjustment, systematic terms included") {
  // Variance of a reading over the trials: noise, and bias and scale factor common to the stations (their covariance).
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true);
  const std::vector<survey::Attitude> at{degrees(45, 185, 100), degrees(45, 185, 100)};
  const GrossErrorTrials trials(m, at, {}, random::Stream(3, 20));
  const double truth = trials.readings_without_noise(false).readings[0][5];
  double square = 0, product = 0;
  constexpr int kTrials = 20000;
  for (int t = 0; t < kTrials; ++t) {
    const StationReadings y = trials.readings(static_cast<std::uint64_t>(t), false);
    square += (y.readings[0][5] - truth) * (y.readings[0][5] - truth) / kTrials;
    product += (y.readings[0][5] - truth) * (y.readings[1][5] - truth) / kTrials;
  }
  const VarianceParts parts = variance_parts(m.sigma, 5, truth);
  // sd of a variance of normal values is sqrt(2 / n): four of them
  CHECK_THAT(square, WithinRel(parts.systematic + parts.noise, 4 * std::sqrt(2.0 / kTrials)));
  CHECK_THAT(product, WithinRel(parts.systematic, 4 * std::sqrt(2.0 / kTrials)));
}

TEST_CASE("An error of exactly the minimal detectable size is found in 80 % of the trials; blamed, in fewer",
          "[long]") {
  const AdjustmentModel m;
  const survey::Attitude at = degrees(30, 45, 60);
  const double detectable = kLambda / sensitivities(linear_model(m, {at}))[kBx];
  const GrossErrorTrials trials(m, {at}, {{kBx, detectable}}, random::Stream(1, 20));
  constexpr int kTrials = 40000;
  survey::LaneArray without(kTrials / simd::kGroup, kTestRows), with(kTrials / simd::kGroup, kTestRows);
  trials.simulate(0, without, with, kTrials / simd::kGroup);
  int detected = 0, identified = 0;
  for (int t = 0; t < kTrials; ++t) {
    const TrialTests tests = GrossErrorTrials::tests_of(with, t);
    REQUIRE(tests.converged);
    detected += std::abs(tests.w[kBx]) > kCritical;
    identified += tests.largest > kCritical && tests.suspects == SuspectGroup{kBx};
  }
  // 0.802 and 0.464 by the specification, whose runs have the same error: four times sqrt(2) standard errors
  CHECK_THAT(detected / double(kTrials), WithinAbs(0.802, 4 * std::sqrt(2 * 0.8 * 0.2 / kTrials)));
  CHECK_THAT(identified / double(kTrials), WithinAbs(0.464, 4 * std::sqrt(2 * 0.464 * 0.536 / kTrials)));
}

TEST_CASE("Powers of the tests") {
  // One dimension: chi2 is the square of w
  CHECK_THAT(chi_squared_power(1, kLambda * kLambda, kCritical * kCritical),
             WithinRel(w_power(kLambda, kCritical), 1e-9));
  CHECK_THAT(chi_squared_power(3, 0, chi_squared_critical(3, 0.01)), WithinRel(0.01, 1e-9));
  const DimensionLevel level = b_method_level(3, kLambda * kLambda, 0.8);
  CHECK_THAT(chi_squared_power(3, kLambda * kLambda, level.critical), WithinRel(0.8, 1e-9));
  // Without error the level, with much redundancy the w-test's power, and in between it grows with both
  CHECK_THAT(pope_power(0, 3, 2e-4), WithinRel(2e-4, 1e-9));
  CHECK_THAT(pope_power(4, 1e6, 2e-4), WithinAbs(w_power(4, w_critical({1e-4, Tails::one, 0.8})), 1e-4));
  CHECK(pope_power(4, 3, 2e-4) < pope_power(5, 3, 2e-4));
  CHECK(pope_power(4, 3, 2e-4) < pope_power(4, 10, 2e-4));
  CHECK_THAT(pope_power(-4, 10, 2e-4), WithinRel(pope_power(4, 10, 2e-4), 1e-12));
  CHECK(pope_power(4, 1, 2e-4) == 0);
}

TEST_CASE("Rates of independent tests by linear theory") {
  ParityModel m{Eigen::MatrixXd::Identity(3, 3), Eigen::VectorXd::Zero(3), Eigen::VectorXd::Ones(3), 3};
  const Eigen::Vector3d shift(2.5, 0, 0);
  const double k = 2;
  const LinearRates rates = linear_rates(m, shift, 0, k);
  const double null = w_power(0, k);
  CHECK_THAT(rates.any, WithinAbs(1 - (1 - w_power(2.5, k)) * (1 - null) * (1 - null), 2e-4));
  double largest = 0;  // integral of phi(s - lambda) P(|z| < |s|)^2 over |s| > k, midpoint rule
  for (double s = -12; s < 12; s += 1e-3) {
    const double x = s + 5e-4, below = 1 - w_power(0, std::abs(x));
    if (std::abs(x) > k) largest += std::exp(-(x - 2.5) * (x - 2.5) / 2) / std::sqrt(2 * kPi) * below * below * 1e-3;
  }
  CHECK_THAT(rates.identified, WithinAbs(largest, 2e-4));
  // Without a shift, and where it is rare
  const double rare = w_power(0, kCritical);
  CHECK_THAT(linear_rates(m, Eigen::Vector3d::Zero(), 0, kCritical).any, WithinRel(1 - std::pow(1 - rare, 3), 1e-2));
  CHECK(
      std::isnan(linear_rates({Eigen::MatrixXd::Identity(4, 4), Eigen::VectorXd::Zero(4), Eigen::VectorXd::Ones(4), 4},
                              Eigen::VectorXd::Zero(4), 0, k)
                     .any));
}

TEST_CASE("Rates are probabilities, however large the shift") {
  const ParityModel m = linear_model(model_of(AdjustmentMode::sse), {degrees(30, 45, 60)});
  for (const double size : {0.0, 1.0, 5.0, 14.0, 50.0, 200.0}) {
    const Eigen::Vector3d shift = m.columns.col(kBx).normalized() * size;
    const LinearRates rates = linear_rates(m, shift, kBx, kCritical);
    CHECK(rates.any >= 0);
    CHECK(rates.any <= 1);
    CHECK(rates.identified <= rates.any);
    // The union is no rarer than its largest member; 2e-4 is the accuracy of the integral
    CHECK(rates.any >= w_power(size, kCritical) - 2e-4);
  }
  CHECK_THAT(linear_rates(m, m.columns.col(kBx).normalized() * 50, kBx, kCritical).any, WithinAbs(1, 1e-12));
}

TEST_CASE("Trials near horizontal in sse_axial converge: on lanes, or one by one") {
  const GrossErrorTrials trials(model_of(AdjustmentMode::sse_axial), {degrees(85, 45, 85)}, {{kBx, 673}},
                                random::Stream(3, 20));
  survey::LaneArray without(64, kTestRows), with(64, kTestRows);
  trials.simulate(0, without, with, 64);
  int converged = 0;
  for (int t = 0; t < 512; ++t)
    converged += GrossErrorTrials::tests_of(without, t).converged && GrossErrorTrials::tests_of(with, t).converged;
  CHECK(converged == 512);
}
