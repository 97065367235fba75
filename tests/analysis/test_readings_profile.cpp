// Intervals of a user's readings by the profile (lib/analysis/readings_profile.h): where first order holds they are its
// own, and where it does not they hold the truth as often as they say.
#include "analysis/readings_profile.h"

#include <catch2/catch.hpp>

#include "analysis/estimate_warnings.h"
#include "analysis/msa_prediction.h"
#include "analysis/readings_tests.h"
#include "msa_trials.h"
#include "stats/intervals.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using namespace surveymc::analysis;

namespace {

std::vector<ProfiledInterval> intervals_of(const test::NoisyRun& run, const sensor::NoiseModel& noise,
                                           const estimate::EstimatorOptions& options = {}, double confidence = 0.95) {
  return profile_readings(run.readings, run.field, noise, options,
                          analyse_readings(run.readings, run.field, noise, options), confidence);
}

std::vector<Warning> warnings_of(const test::NoisyRun& run, const sensor::NoiseModel& noise) {
  const ReadingsAnalysis a = analyse_readings(run.readings, run.field, noise, {});
  return warnings_of_estimate(run.readings, run.field, noise, a, judge_readings(run.readings, a, {}), std::nullopt,
                              profile_readings(run.readings, run.field, noise, {}, a, 0.95));
}

bool says_that_covariance_fails(const std::vector<Warning>& all) {
  return std::any_of(all.begin(), all.end(), [](const Warning& w) {
    return w.severity == "warning" && w.message.find("the covariance does not hold") == 0;
  });
}

/// Whether the exact binomial interval (99.9 %) of a share holds the expected one.
bool is_share(std::uint64_t inside, std::uint64_t count, double expected) {
  const stats::Interval i = stats::binomial_interval(inside, count, 0.999);
  return i.lo < expected && expected < i.hi;
}

}  // namespace

TEST_CASE("Where first order fails, intervals of the profile hold the truth as often as they say") {
  // Thesis test 2, in which east is bent: one part in 18 of the runs is outside its 99 % interval by the covariance.
  constexpr int kRuns = 300, kEast = 7;
  constexpr double kConfidence = 0.99;
  const sensor::NoiseModel noise = test::msa_noise(1, sensor::ReferenceNoise::per_run, 1e-3);
  const test::MsaTrials trials(2, kRuns, noise);
  const Eigen::Vector3d position = survey::minimum_curvature_positions(trials.c.survey).back();
  std::vector<double> truth(9);
  for (int i = 0; i < 9; ++i)
    truth[static_cast<std::size_t>(i)] = i < 6 ? test::true_parameters(trials.c)[i] : position[i - 6];
  std::vector<std::uint64_t> inside(9, 0);
  std::uint64_t by_covariance = 0;
  for (int t = 0; t < kRuns; ++t) {
    const test::NoisyRun run = test::run_of(trials.block, t, trials.c);
    const std::vector<ProfiledInterval> all = intervals_of(run, noise, {}, kConfidence);
    REQUIRE(all.size() == truth.size());
    for (std::size_t i = 0; i < all.size(); ++i)
      inside[i] += all[i].profile_low <= truth[i] && truth[i] <= all[i].profile_high;
    by_covariance += all[kEast].first_low <= truth[kEast] && truth[kEast] <= all[kEast].first_high;
    CHECK(all[kEast].is_notable());
    if (t == 0) CHECK(says_that_covariance_fails(warnings_of(run, noise)));
  }
  for (std::size_t i = 0; i < inside.size(); ++i) {
    CAPTURE(i, inside[i]);
    CHECK(is_share(inside[i], kRuns, kConfidence));
  }
  CHECK_FALSE(is_share(by_covariance, kRuns, kConfidence));
}

TEST_CASE("A profile without value does not say that the covariance holds") {
  const sensor::NoiseModel noise = test::msa_noise(1, sensor::ReferenceNoise::per_run, 1e-3);
  const test::MsaTrials trials(4, 1, noise);
  const test::NoisyRun run = test::run_of(trials.block, 0, trials.c);
  ProfiledInterval x{"east_m", 100, 2, 96, 104, kNaN, kNaN, kNaN};
  CHECK_FALSE(x.is_determined());
  CHECK_FALSE(x.is_notable());
  const ReadingsAnalysis a = analyse_readings(run.readings, run.field, noise, {});
  const auto warnings =
      warnings_of_estimate(run.readings, run.field, noise, a, judge_readings(run.readings, a, {}), std::nullopt, {x});
  CHECK(std::any_of(warnings.begin(), warnings.end(), [](const Warning& w) {
    return w.message.find("whether the covariance holds of east_m") != std::string::npos;
  }));
  x.profile_low = 95;
  x.profile_high = 105;
  CHECK(x.is_determined());
  CHECK(x.is_notable());
}

TEST_CASE("Where first order holds, the profile gives its intervals") {
  for (const std::string& name : {"msa", "msa_weighted", "msa_joint"})
    for (const double scale : {1.0, 0.1}) {
      const sensor::NoiseModel noise = test::msa_noise(scale, sensor::ReferenceNoise::per_run, 1e-3 * scale);
      const test::MsaTrials trials(4, 8, noise);
      const test::NoisyRun run = test::run_of(trials.block, 3, trials.c);
      const auto all = intervals_of(run, noise, test::options_of(name, input_errors(noise, {}, run.field)));
      CAPTURE(name, scale);
      REQUIRE(all.size() == 9);
      for (const ProfiledInterval& x : all) {
        CAPTURE(x.quantity, x.shift());
        CHECK_FALSE(x.is_notable());
        // Curvature shifts ends by the sizes; residuals, which the covariance leaves out, change the slope by them.
        CHECK(x.shift() < 0.05 * scale);
        CHECK(std::abs(x.profile_sd / x.sd - 1) < 0.01 * scale);
        CHECK(x.jump_probability == 0);
      }
      if (name == "msa") CHECK_FALSE(says_that_covariance_fails(warnings_of(run, noise)));
    }
}

TEST_CASE("Estimators with priors of the tool have no profile: tools that vary are no errors of readings") {
  const sensor::NoiseModel noise = test::msa_noise();
  const test::MsaTrials trials(4, 8, noise);
  const test::NoisyRun run = test::run_of(trials.block, 0, trials.c);
  const auto options = test::options_of("msa_joint", input_errors(noise, {0.002, 60, 40}, run.field));
  CHECK(intervals_of(run, noise, options).empty());
}
