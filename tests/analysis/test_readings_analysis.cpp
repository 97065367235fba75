#include "analysis/readings_analysis.h"

#include <fmt/format.h>
#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "analysis/estimate_warnings.h"
#include "analysis/msa_prediction.h"
#include "analysis/readings_tests.h"
#include "base/error.h"
#include "base/units.h"
#include "msa_trials.h"
#include "propagate/station_effects.h"
#include "random_runs.h"
#include "stats/intervals.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using namespace surveymc::analysis;
using Catch::Matchers::Contains;

namespace {

sensor::NoiseModel thesis_noise(double accelerometer = 0,
                                sensor::ReferenceNoise per = sensor::ReferenceNoise::per_run) {
  return test::msa_noise(1, per, accelerometer);
}

survey::SixAxisReadings clean_run(const test::ThesisCase& c) {
  const sensor::CleanReadings clean = test::clean_readings(c);
  return {c.survey.md(), clean.gravity_T, clean.magnetic_T};
}

/// Counts, and whether the exact binomial interval (99.9 %) of the share holds the expected one.
struct Share {
  std::uint64_t inside = 0, count = 0;
  void add(bool in) {
    inside += in;
    ++count;
  }
  bool fits(double expected) const {
    const stats::Interval i = stats::binomial_interval(inside, count, 0.999);
    return i.lo < expected && expected < i.hi;
  }
};

bool warns(const std::vector<Warning>& all, const std::string& severity, const std::string& words) {
  return std::any_of(all.begin(), all.end(), [&](const Warning& w) {
    return w.severity == severity && w.message.find(words) != std::string::npos;
  });
}

std::vector<Warning> warnings_of(const survey::SixAxisReadings& r, const survey::ReferenceField& field,
                                 const sensor::NoiseModel& noise) {
  const ReadingsAnalysis a = analyse_readings(r, field, noise, {});
  return warnings_of_estimate(r, field, noise, a, judge_readings(r, a, {}), std::nullopt);
}

/// Attitudes of a run along which the tool keeps its toolface.
survey::SixAxisReadings run_without_rotation(int stations, bool turn, double noise) {
  test::ThesisCase c = test::thesis_case(4);
  c.survey.stations.resize(static_cast<std::size_t>(stations));
  for (int k = 0; k < stations; ++k) {
    survey::Station& s = c.survey.stations[static_cast<std::size_t>(k)];
    s.md = 30 * k;
    s.toolface = 40 * kDegree;
    s.inclination = (turn ? 20 + 2 * k : 30) * kDegree;
    s.azimuth = (turn ? 50 + 3 * k : 60) * kDegree;
  }
  survey::SixAxisReadings r = clean_run(c);
  for (int k = 0; k < stations; ++k) {  // any fixed numbers of sd about 1
    survey::Vec3<double>& m = r.magnetic_T[static_cast<std::size_t>(k)];
    m = m + scale(noise * std::sqrt(2.0),
                  survey::Vec3<double>{std::sin(1.0 + 5.1 * k), std::sin(2.7 + 5.1 * k), std::sin(4.4 + 5.1 * k)});
  }
  return r;
}

}  // namespace

TEST_CASE("Readings without noise give gains, biases, azimuths and positions back, and no residuals") {
  for (int number = 1; number <= 4; ++number) {
    test::ThesisCase c = test::thesis_case(number);
    c.field.declination = 7 * kDegree;
    const ReadingsAnalysis a = analyse_readings(clean_run(c), c.field, thesis_noise(), {});
    CAPTURE(number);
    test::check_parameters(a.parameters, test::true_parameters(c), 1e-9, 1e-6);
    const auto positions = survey::minimum_curvature_positions(c.survey);
    for (std::size_t k = 0; k < a.stations.size(); ++k) {
      const survey::Station& s = c.survey.stations[k];
      const StationAnalysis& found = a.stations[k];
      CHECK(std::abs(found.corrected.inclination - s.inclination) < 1e-12);
      // 1e-6 nT of 16,000; the vertical stations of tests 2 and 3 have azimuth and toolface in one
      if (s.inclination > 1e-6) {
        const double azimuth = found.corrected.azimuth + c.field.declination;
        CHECK(std::abs(std::remainder(azimuth - s.azimuth, 2 * kPi)) < 1e-9);
      }
      CHECK((found.position - positions[k]).norm() < 1e-6);
      CHECK(std::abs(found.after.horizontal) + std::abs(found.after.vertical) + std::abs(found.after.total) < 1e-5);
      CHECK(std::isfinite(found.azimuth_sd));
    }
    CHECK(a.tests.statistic < 1e-9);
    const auto tests = judge_readings(clean_run(c), a, {});
    CHECK(tests[0].decision == "rejected");  // less noise than claimed
    CHECK(tests[0].statistic < 1e-12);
    CHECK(tests[1].decision == "rejected");
    CHECK(suspect(tests) == -1);
    const auto warnings = warnings_of(clean_run(c), c.field, thesis_noise());
    CHECK(warns(warnings, "info", "less noise than claimed"));
    CHECK_FALSE(warns(warnings, "severe", "residuals"));
  }
}

TEST_CASE("Every estimator of readings finds the truth of error-free ones, and its claim is the prediction's") {
  const test::ThesisCase c = test::thesis_case(4);
  const sensor::NoiseModel noise = thesis_noise(0.003, sensor::ReferenceNoise::per_run);
  for (const std::string& name : readings_estimators()) {
    const estimate::EstimatorOptions o = test::options_of(name, input_errors(noise, {}, c.field));
    const ReadingsAnalysis a = analyse_readings(clean_run(c), c.field, noise, o);
    const MsaPrediction p = predict_msa(c.survey, c.field, c.errors, {}, noise, test::clean_readings(c), o);
    CAPTURE(name);
    test::check_parameters(a.parameters, p.parameters, 1e-9, 1e-6);
    for (int i = 0; i < 6; ++i) CHECK(a.covariance(i, i) == Approx(p.parameter_covariance(i, i)).epsilon(1e-7));
    CHECK(a.reference.has_value() == (name == "msa_joint"));
    if (!a.reference) continue;
    CHECK((*a.reference)[0] == Approx(c.field.total).epsilon(1e-12));
    CHECK((*a.reference)[1] == Approx(c.field.dip).epsilon(1e-12));
    for (int i = 0; i < 2; ++i)
      CHECK(a.reference_estimate_covariance(i, i) == Approx(p.reference_covariance(i, i)).epsilon(1e-7));
  }
}

TEST_CASE("Every claim along the well is the whole first order: parameters, reference, azimuths, positions") {
  // That the prediction is the whole first order trials tell, for the same wells (test_msa_prediction.cpp). At full
  // noise all wells are determined well enough; the answer to readings without noise is the truth to 1e-9 of a sd.
  for (int number = 0; number < 40; ++number)
    for (const std::string& name : readings_estimators()) {
      const test::RandomRun r = test::random_run(number, 1);
      const sensor::CleanReadings clean = sensor::clean_readings(r.survey, r.field, r.errors);
      const estimate::NominalTruth truth{sensor::station_fields(clean), r.errors.gain, r.errors.bias, r.field};
      const estimate::InputErrors sizes = input_errors(r.noise, {}, r.field);
      const estimate::EstimatorOptions o = test::options_of(name, sizes);
      const ReadingsAnalysis a =
          analyse_readings({r.survey.md(), clean.gravity_T, clean.magnetic_T}, r.field, r.noise, o);
      const MsaPrediction p = predict_msa(r.survey, r.field, r.errors, {}, r.noise, clean, o);
      CAPTURE(number, name);
      const auto check_covariance = [](const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
        for (int i = 0; i < found.rows(); ++i)
          for (int j = 0; j <= i; ++j)
            CHECK(std::abs(found(i, j) - expected(i, j)) <= 1e-6 * std::sqrt(expected(i, i) * expected(j, j)));
      };
      check_covariance(a.covariance, p.parameter_covariance);
      if (a.reference) check_covariance(a.reference_estimate_covariance, p.reference_covariance);
      const std::array<std::size_t, 3> places = first_middle_last(a.stations.size());
      for (std::size_t i = 0; i < places.size(); ++i)
        CHECK(a.stations[places[i]].azimuth_sd == Approx(p.claimed_azimuth_sd[i]).epsilon(1e-6));
      check_covariance(a.stations.back().position_covariance, p.linear.covariance.bottomRightCorner<3, 3>());
      // Halfway, the stations below move the position through the estimate alone.
      const std::size_t half = places[1];
      std::vector<StationDerivatives<3>> stations(truth.stations.size());
      const std::vector<double> md = r.survey.md();
      const auto until = static_cast<std::ptrdiff_t>(half + 1);
      const auto effects = propagate::final_position_effects({md.begin(), md.begin() + until},
                                                             {truth.stations.begin(), truth.stations.begin() + until},
                                                             r.field.declination);
      for (std::size_t k = 0; k <= half; ++k) stations[k] = {effects[k].by_field, effects[k].by_down};
      const InputEffects<3> by_draws =
          input_effects(stations, by_estimate(stations, truth), estimate::sensitivity(o, truth), truth, sizes);
      check_covariance(a.stations[half].position_covariance, by_draws.covariance());
      if (r.noise.reference == sensor::ReferenceNoise::none) CHECK(a.reference_covariance.isZero());
    }
}

TEST_CASE("Intervals cover what they claim, and the tests reject as often as they claim", "[long]") {
  const test::ThesisCase c = test::thesis_case(4);
  constexpr int kTrials = 400;
  const double z = stats::normal_quantile(0.975);
  const auto positions = survey::minimum_curvature_positions(c.survey);
  for (const sensor::NoiseModel& noise :
       {thesis_noise(), thesis_noise(0.003), thesis_noise(0.003, sensor::ReferenceNoise::none)}) {
    const survey::ReadingBlock block = test::simulated(c, noise, kTrials, random::Stream(404, 9));
    std::array<Share, 6> parameter;
    std::array<Share, 2> azimuth, north, east;
    Share accepted, six;
    double rejected_sum = 0, rejected_squares = 0;  // share of the residuals that a run's w-tests reject
    for (int t = 0; t < kTrials; ++t) {
      const test::NoisyRun run = test::run_of(block, t, c);
      const ReadingsAnalysis a = analyse_readings(run.readings, run.field, noise, {});
      for (int i = 0; i < 6; ++i)
        parameter[static_cast<std::size_t>(i)].add(std::abs(a.parameters[i] - test::true_parameters(c)[i]) <
                                                   z * std::sqrt(a.covariance(i, i)));
      for (std::size_t at = 0; at < 2; ++at) {
        const std::size_t k = at == 0 ? 20 : 52;
        const StationAnalysis& s = a.stations[k];
        azimuth[at].add(std::abs(std::remainder(s.corrected.azimuth - c.survey.stations[k].azimuth, 2 * kPi)) <
                        z * s.azimuth_sd);
        const Eigen::Vector3d off = s.position - positions[k];
        north[at].add(std::abs(off.x()) < z * std::sqrt(s.position_covariance(0, 0)));
        east[at].add(std::abs(off.y()) < z * std::sqrt(s.position_covariance(1, 1)));
      }
      const auto tests = judge_readings(run.readings, a, {0.95, 0.05, 0.05});
      accepted.add(tests[0].decision == "accepted");
      REQUIRE(tests.size() == 108);
      const auto rejections =
          std::count_if(tests.begin() + 2, tests.end(), [](const ReadingsTest& x) { return x.decision == "rejected"; });
      const double rejected = static_cast<double>(rejections) / 106;
      rejected_sum += rejected;
      rejected_squares += rejected * rejected;
      const estimate::Vector6d off = a.parameters - test::true_parameters(c);
      six.add(off.dot(a.covariance.ldlt().solve(off)) < stats::chi_squared_quantile(6, 0.95));
    }
    CAPTURE(noise.accelerometer, noise.reference_total);
    for (const Share& p : parameter) CHECK(p.fits(0.95));
    for (std::size_t at = 0; at < 2; ++at) {
      CAPTURE(at, azimuth[at].inside, north[at].inside, east[at].inside);
      CHECK(azimuth[at].fits(0.95));
      CHECK(north[at].fits(0.95));
      CHECK(east[at].fits(0.95));
    }
    // The w-tests of one run are correlated, so the standard error of their share is taken over the runs.
    const double share = rejected_sum / kTrials, variance = rejected_squares / kTrials - share * share;
    CAPTURE(accepted.inside, share, six.inside);
    CHECK(accepted.fits(0.95));
    CHECK(std::abs(share - 0.05) < 3.5 * std::sqrt(variance / kTrials));
    CHECK(six.fits(0.95));
  }
}

TEST_CASE("A perfect tool is found perfect as often as the test says, with priors too", "[long]") {
  test::ThesisCase c = test::thesis_case(4);
  c.errors = {};
  const sensor::NoiseModel noise = thesis_noise(0.003);
  constexpr int kTrials = 120;
  const survey::ReadingBlock block = test::simulated(c, noise, kTrials, random::Stream(404, 9));
  for (const char* name : {"msa_weighted", "msa_joint", "wls_consider"}) {
    const estimate::EstimatorOptions o = test::options_of(name, input_errors(noise, {0.0016, 70, 0}, c.field));
    double sum = 0;
    for (int t = 0; t < kTrials; ++t) {
      const test::NoisyRun run = test::run_of(block, t, c);
      sum += analyse_readings(run.readings, run.field, noise, o).perfect_tool_statistic;
    }
    CAPTURE(name);
    // The variance of a chi-squared of six degrees is 12.
    CHECK(std::abs(sum / kTrials - 6) < 4 * std::sqrt(12.0 / kTrials));
  }
}

TEST_CASE("The sd of an estimate has three parts: noise, reference and the tools that the priors speak of") {
  test::ThesisCase c = test::thesis_case(4);
  c.errors = {};
  const sensor::NoiseModel noise = thesis_noise(0.003);
  sensor::NoiseModel exact_reference = noise;
  exact_reference.reference = sensor::ReferenceNoise::none;
  const sensor::ToolSpread spread{0.0016, 70, 200};
  const estimate::EstimatorOptions o = test::options_of("wls_consider", input_errors(noise, spread, c.field));
  const sensor::CleanReadings clean = test::clean_readings(c);
  const auto predicted = [&](const sensor::ToolSpread& tools, const sensor::NoiseModel& n) {
    return predict_msa(c.survey, c.field, c.errors, tools, n, clean, o).parameter_covariance;
  };
  const ReadingsAnalysis a = analyse_readings(clean_run(c), c.field, noise, o);
  const estimate::Matrix6d by_noise = predicted({}, exact_reference), by_readings = predicted({}, noise),
                           whole = predicted(spread, noise);
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(a.covariance(i, i) == Approx(whole(i, i)).epsilon(1e-7));
    CHECK(a.noise_covariance()(i, i) == Approx(by_noise(i, i)).epsilon(1e-7));
    CHECK(a.reference_covariance(i, i) == Approx(by_readings(i, i) - by_noise(i, i)).epsilon(1e-7));
    CHECK(a.prior_covariance()(i, i) == Approx(whole(i, i) - by_readings(i, i)).epsilon(1e-7));
    CHECK(a.prior_covariance()(i, i) > 0);
  }
}

TEST_CASE("A gross error is found at its station, and the run is rejected") {
  const test::ThesisCase c = test::thesis_case(4);
  const survey::ReadingBlock block = test::simulated(c, thesis_noise(0.003), 8, random::Stream(3, 9));
  for (int t = 0; t < 8; ++t) {
    test::NoisyRun run = test::run_of(block, t, c);
    run.readings.magnetic_T[30].z += 900;  // 13 sd: magnetic interference
    const ReadingsAnalysis a = analyse_readings(run.readings, run.field, thesis_noise(0.003), {});
    const auto tests = judge_readings(run.readings, a, {});
    const int s = suspect(tests);
    REQUIRE(s > 0);
    CHECK(tests[static_cast<std::size_t>(s)].station == 30);
    CHECK(tests[0].decision == "rejected");
    const auto examined = examine_suspect(run.readings, run.field, thesis_noise(0.003), {}, a, tests);
    REQUIRE(examined);
    // 900 nT along z: found there, or in what the two residuals of the station cannot tell from it.
    const auto bz = std::find_if(examined->readings.begin(), examined->readings.end(),
                                 [](const SuspectReading& x) { return x.reading == "bz"; });
    REQUIRE(bz != examined->readings.end());
    CHECK(bz->in_group);
    CHECK(std::abs(bz->error - 900) < 5 * bz->error_sd);
    REQUIRE(examined->without);
    CHECK(suspect(judge_readings(run.readings, *examined->without, {})) == -1);
    const auto warnings = warnings_of_estimate(run.readings, run.field, thesis_noise(0.003), a, tests, examined);
    CHECK(warns(warnings, "severe", "variance factor"));
    CHECK(warns(warnings, "warning", "station 31 (md 2837.85 m) is suspect"));
    CHECK(warns(warnings, "warning", "without the station s0 is"));
  }
}

TEST_CASE("An engineer is told what MSA cannot separate") {
  const test::ThesisCase c = test::thesis_case(4);
  const auto warnings = warnings_of(clean_run(c), c.field, thesis_noise());
  CHECK(warns(warnings, "warning", "MSA cannot separate gain_z from bias_z here (correlation -0.979)"));
  // With the other known: the inverse of the pair's information, one at a time
  const estimate::Matrix6d all = analyse_readings(clean_run(c), c.field, thesis_noise(), {}).covariance;
  Eigen::Matrix2d pair;
  pair << all(2, 2), all(2, 5), all(5, 2), all(5, 5);
  const Eigen::Matrix2d information = pair.inverse();
  CHECK(warns(
      warnings, "warning",
      fmt::format("sd {:.3g} and {:.3g} nT, but {:.3g} and {:.3g} nT if the other were known", std::sqrt(all(2, 2)),
                  std::sqrt(all(5, 5)), 1 / std::sqrt(information(0, 0)), 1 / std::sqrt(information(1, 1)))));
}

TEST_CASE("Too few stations: three have an answer that nothing checks") {
  test::ThesisCase c = test::thesis_case(4);
  survey::SixAxisReadings r = clean_run(c);
  for (auto* v : {&r.gravity_T, &r.magnetic_T}) *v = {(*v)[0], (*v)[25], (*v)[50]};
  r.md = {100, 200, 300};
  const ReadingsAnalysis a = analyse_readings(r, c.field, thesis_noise(), {});
  CHECK(a.parameters.allFinite());
  CHECK(a.covariance.allFinite());
  CHECK(a.tests.redundancy == 0);
  const auto tests = judge_readings(r, a, {});
  CHECK(tests[0].decision == "not tested");
  CHECK(tests[2].decision == "not tested");
  CHECK(warns(warnings_of(r, c.field, thesis_noise()), "severe", "3 stations give 6 residuals for 6 unknowns"));
  r = clean_run(c);
  r.md.resize(6);
  r.gravity_T.resize(6);
  r.magnetic_T.resize(6);
  CHECK(warns(warnings_of(r, c.field, thesis_noise()), "warning", "few stations: 6 leave 6 redundant residuals"));
}

TEST_CASE("A run without rotation is an error or a severe warning, and never NaN") {
  // Without any change of attitude two residuals are all there is: exactly unobservable.
  CHECK_THROWS_WITH(
      analyse_readings(run_without_rotation(12, false, 0), test::thesis_case(4).field, thesis_noise(), {}),
      Contains("the stations cannot determine"));
  // With noise the numbers come from the noise alone.
  for (const bool turn : {false, true})
    for (const int stations : {4, 12, 25}) {
      const survey::SixAxisReadings r = run_without_rotation(stations, turn, 70);
      const survey::ReferenceField field = test::thesis_case(4).field;
      CAPTURE(turn, stations);
      try {
        const ReadingsAnalysis a = analyse_readings(r, field, thesis_noise(), {});
        CHECK(a.parameters.allFinite());
        CHECK(a.covariance.allFinite());
        for (const StationAnalysis& s : a.stations)
          CHECK((s.position.allFinite() && s.position_covariance.allFinite()));
        const auto warnings = warnings_of(r, field, thesis_noise());
        CHECK(warns(warnings, "warning", "poor rotation"));
        CHECK(warnings.front().severity == "severe");
      } catch (const InputError& e) {
        CHECK_THAT(e.what(), Contains("cannot determine") || Contains("finds no minimum"));
      }
    }
}

TEST_CASE("Accelerometers of the other sign are recognised") {
  const test::ThesisCase c = test::thesis_case(4);
  survey::SixAxisReadings r = clean_run(c);
  for (survey::Vec3<double>& g : r.gravity_T) g = scale(-1.0, g);
  CHECK_THROWS_WITH(analyse_readings(r, c.field, thesis_noise(), {}),
                    Contains("other way round (key `accelerometers`)"));
  // Where an estimate comes out all the same, the warning says it.
  ReadingsAnalysis a = analyse_readings(clean_run(c), c.field, thesis_noise(), {});
  CHECK_FALSE(a.vertical_field_reversed);
  a.vertical_field_reversed = true;
  const auto warnings = warnings_of_estimate(r, c.field, thesis_noise(), a, judge_readings(r, a, {}), std::nullopt);
  CHECK(warns(warnings, "severe", "other way round (key `accelerometers`)"));
}

TEST_CASE("A field along gravity has no azimuth, and gravity that is not is reported") {
  const test::ThesisCase c = test::thesis_case(4);
  survey::SixAxisReadings r = clean_run(c);
  r.magnetic_T[5] = scale(5000.0, r.gravity_T[5]);
  CHECK_THROWS_WITH(analyse_readings(r, c.field, thesis_noise(), {}),
                    Contains("md 1807.38 m: the magnetic field is parallel to gravity"));
  r = clean_run(c);
  r.gravity_T[7] = scale(1.01, r.gravity_T[7]);
  CHECK(warns(warnings_of(r, c.field, thesis_noise()), "warning",
              "gravity is off by up to +0.0981 m/s2 at 1 station (md 1891.08 m)"));
}
