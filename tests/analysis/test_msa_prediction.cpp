#include "analysis/msa_prediction.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/estimator.h"
#include "msa_trials.h"
#include "stats/moments.h"
#include "stats/tests.h"
#include "survey/corrected_position.h"

using namespace surveymc;
using namespace surveymc::analysis;

namespace {

sensor::NoiseModel full_noise(double scale, sensor::ReferenceNoise per,
                              sensor::NoiseLaw law = sensor::NoiseLaw::gaussian) {
  sensor::NoiseModel n = test::msa_noise(scale, per, 0.003 * scale);
  n.law = law;
  return n;
}

/// Estimates and positions of trials, less their prediction, and the weighted sums of their draws: 9 columns each.
struct Trials {
  Eigen::MatrixXd errors, sums;
};
Trials run(const test::ThesisCase& c, const sensor::NoiseModel& noise, const MsaPrediction& p, int count) {
  const sensor::CleanReadings clean = test::clean_readings(c);
  survey::ReadingBlock block = sensor::make_reading_block(count, c.survey.size(), noise);
  survey::LaneArray sums(survey::groups_for(count), sensor::NoiseWeights::kSums),
      position(survey::groups_for(count), 3);
  sensor::simulate_readings(clean, c.field, noise, random::Stream(31, 7), 0, block, &p.weights, &sums);
  estimate::EstimateBlock estimates(count);
  estimate::make_estimator({}, c.field)->solve(block, estimates);
  survey::corrected_final_positions(block, estimates.parameters, c.survey.md(), c.field.declination, position);
  Trials t{Eigen::MatrixXd(count, 9), Eigen::MatrixXd(count, 9)};
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < 9; ++i) {
      t.errors(k, i) =
          i < 6 ? estimates.parameters.value(k, i) - p.parameters[i] : position.value(k, i - 6) - p.position[i - 6];
      t.sums(k, i) = sums.value(k, i) - p.linear.mean[i];
    }
  return t;
}

MsaPrediction predicted(const test::ThesisCase& c, const sensor::NoiseModel& noise) {
  return predict_msa(c.survey, c.field, c.errors, {}, noise, test::clean_readings(c), {});
}

}  // namespace

TEST_CASE("The linear prediction of a trial is its estimate and its position, when the noise is small") {
  for (const int number : {1, 3, 4})
    for (const sensor::ReferenceNoise per :
         {sensor::ReferenceNoise::none, sensor::ReferenceNoise::per_run, sensor::ReferenceNoise::per_station})
      for (const sensor::NoiseLaw law : {sensor::NoiseLaw::gaussian, sensor::NoiseLaw::uniform_half_open}) {
        const test::ThesisCase c = test::thesis_case(number);
        const sensor::NoiseModel noise = full_noise(1e-4, per, law);
        const MsaPrediction p = predicted(c, noise);
        const Trials t = run(c, noise, p, 16);
        for (int i = 0; i < 9; ++i) {
          const double sd = std::sqrt(p.linear.covariance(i, i));
          if (sd < 1e-9) continue;  // the vertical of a plane well: nothing but rounding
          CAPTURE(number, static_cast<int>(per), static_cast<int>(law), i);
          // Second order is 1e-4 of test 1's at full noise (a few tenths of a sd).
          for (int k = 0; k < 16; ++k) CHECK(std::abs(t.errors(k, i) - t.sums(k, i)) < 2e-3 * sd);
        }
      }
}

TEST_CASE("The weighted sums have the mean and covariance that is claimed for them", "[long]") {
  const test::ThesisCase c = test::thesis_case(4);
  for (const sensor::NoiseLaw law : {sensor::NoiseLaw::gaussian, sensor::NoiseLaw::uniform_half_open}) {
    const sensor::NoiseModel noise = full_noise(1, sensor::ReferenceNoise::per_run, law);
    const MsaPrediction p = predicted(c, noise);
    constexpr int n = 8192;
    const stats::Moments m = stats::Moments::of(run(c, noise, p, n).sums);
    for (int i = 0; i < 9; ++i) CHECK(std::abs(m.mean[i]) < 4.5 * std::sqrt(p.linear.covariance(i, i) / n));
    CHECK(stats::wishart_test(m.covariance(), p.linear.covariance, m.count).p_value > 1e-3);
  }
}

TEST_CASE("The linear covariance is that of the estimate, and joint propagation but for a small correlation") {
  for (const int number : {3, 4}) {
    const test::ThesisCase c = test::thesis_case(number);
    const MsaPrediction p = predicted(c, full_noise(1, sensor::ReferenceNoise::per_run));
    const Eigen::MatrixXd parameters = p.linear.covariance.topLeftCorner<6, 6>(), claimed = p.parameter_covariance;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        CHECK(std::abs(parameters(i, j) - claimed(i, j)) < 1e-10 * std::sqrt(claimed(i, i) * claimed(j, j)));
    for (int i = 0; i < 3; ++i)  // station noise and the estimate share a station's draws: per mille
      CHECK(std::sqrt(p.linear.covariance(6 + i, 6 + i) / p.position_covariance[0](i, i)) == Approx(1).epsilon(2e-3));
  }
}
