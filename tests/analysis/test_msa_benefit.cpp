/// The first-order prediction of the study `msa_benefit`, and the wells that it is made for.
#include "analysis/msa_benefit_prediction.h"

#include <algorithm>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "analysis/msa_prediction.h"
#include "analysis/well_design.h"
#include "base/units.h"
#include "msa_trials.h"
#include "random_runs.h"
#include "sensor/tool_spread.h"
#include "stats/moments.h"
#include "survey/corrected_position.h"

using namespace surveymc;
using namespace surveymc::analysis;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const survey::ReferenceField kField{9.80665, 51000, 72 * kDegree, 0, 0};

survey::Survey well(WellKind kind, double inclination_deg, double azimuth_deg, int stations = 20) {
  return make_well({.kind = kind, .stations = stations, .build_rate = 3 * kDegree / 30}, inclination_deg * kDegree,
                   azimuth_deg * kDegree);
}

/// ISCWSA a-priori errors of the magnetometers, noise of 30 nT, a reference of a global model's quality.
estimate::InputErrors errors(double axial_bias = 0) { return {30, 0, 130, .2 * kDegree, false, .0016, 70, axial_bias}; }

sensor::NoiseModel noise_of(double scale) {
  return {.magnetometer = 30 * scale,
          .accelerometer = .002 * scale,
          .reference = sensor::ReferenceNoise::per_run,
          .reference_total = 130 * scale,
          .reference_dip = .2 * kDegree * scale};
}

/// Across the hole at its end, level.
Eigen::RowVector3d lateral_of(const survey::Survey& s) {
  return survey::rotation_hla_from_nev(s.stations.back().inclination, s.stations.back().azimuth).row(1);
}

estimate::EstimatorOptions estimator(const std::string& name, std::array<bool, 6> estimated,
                                     const estimate::InputErrors& assumed) {
  return {.name = name, .assumed = assumed, .estimated = estimated};
}

constexpr std::array<bool, 6> kAll{true, true, true, true, true, true}, kNone{},
    kBiases{false, false, false, true, true, true}, kNoGainZ{true, true, false, true, true, true};

void check_same(const BenefitSd& a, const BenefitSd& b, double relative) {
  CHECK_THAT(a.azimuth, WithinRel(b.azimuth, relative));
  CHECK_THAT(a.lateral, WithinRel(b.lateral, relative));
}

}  // namespace

TEST_CASE("Before MSA, averaged over toolface, azimuth has the variance of the ISCWSA weighting functions") {
  // MBXY-TI1, -TI2, MBZ, MSXY-TI1, -TI2, -TI3, MSZ of the error model Rev 5.10 (per nT of bias, per unit of scale).
  for (const double i_deg : {1e-4, 20.0, 90.0, 135.0, 179.0})
    for (const double a_deg : {0.0, 33.0, 90.0, 200.0, 359.0}) {
      const double i = i_deg * kDegree, a = a_deg * kDegree, si = std::sin(i), ci = std::cos(i), sa = std::sin(a),
                   ca = std::cos(a), tan_dip = std::tan(kField.dip), bh = kField.total * std::cos(kField.dip);
      const std::array<double, 3> bias{-ci * sa / bh, ca / bh, -si * sa / bh};
      const std::array<double, 4> gain{
          si * sa * (tan_dip * ci + si * ca) / std::sqrt(2.0), sa * (tan_dip * si * ci - ci * ci * ca - ca) / 2,
          (ci * ca * ca - ci * sa * sa - tan_dip * si * ca) / 2, -(si * ca + tan_dip * ci) * si * sa};
      double expected = 0, mean = 0;
      for (const double w : bias) expected += 70 * 70 * w * w;
      for (const double w : gain) expected += .0016 * .0016 * w * w;
      constexpr int n = 8;  // variances go with the fourth harmonic of toolface at most
      for (int k = 0; k < n; ++k) {
        const double toolface = 2 * kPi * k / n + .1;
        const survey::Survey s{{{0, i, a, toolface}, {30, i, a, toolface}}};
        const double sd =
            predict_benefit(s, kField, {0, 0, 0, 0, false, .0016, 70}, estimator("msa", kNone, {})).before.azimuth;
        mean += sd * sd / n;
      }
      CAPTURE(i_deg, a_deg);
      CHECK_THAT(mean, WithinRel(expected, 1e-9));  // at 1e-4 deg azimuth loses 6 digits
    }
}

TEST_CASE("Estimating nothing changes nothing") {
  estimate::InputErrors e = errors(220);
  e.down = 1e-4;
  for (const std::string name : {"msa", "msa_joint", "msa_weighted"}) {
    const Benefit b = predict_benefit(well(WellKind::building, 60, 40), kField, e, estimator(name, kNone, e));
    check_same(b.after, b.before, 1e-12);
    CHECK(b.condition == 1);
  }
}

TEST_CASE("A perfect reference and no noise leave nothing; a perfect tool can only lose") {
  estimate::InputErrors perfect_reference = errors(), perfect_tool = errors();
  perfect_reference.magnetometer = perfect_reference.total = perfect_reference.dip = 0;
  const survey::Survey s = well(WellKind::building, 60, 40);
  const estimate::EstimatorOptions msa = estimator("msa", kAll, {});
  const Benefit none = predict_benefit(s, kField, perfect_reference, msa);
  CHECK(none.after.azimuth < 1e-9 * none.before.azimuth);
  CHECK(none.after.lateral < 1e-9 * none.before.lateral);
  perfect_tool.gain = perfect_tool.bias = perfect_tool.magnetometer = 0;
  const Benefit lost = predict_benefit(s, kField, perfect_tool, msa);
  CHECK(lost.before.azimuth == 0);
  CHECK(benefit_ratio(lost.before.azimuth, lost.after.azimuth) == INFINITY);
  perfect_tool.magnetometer = 30;
  const Benefit noisy = predict_benefit(s, kField, perfect_tool, msa);
  CHECK(noisy.after.azimuth > noisy.before.azimuth);
  CHECK(benefit_ratio(0, 0) == 1);
  CHECK(benefit_ratio(2, 1) == .5);
}

TEST_CASE("West mirrors east, where toolfaces are mirrored too") {
  const estimate::InputErrors e = errors(220);
  for (const double inclination : {1e-4, 30.0, 90.0, 150.0})
    for (const double azimuth : {0.0, 20.0, 75.0, 130.0}) {
      const survey::Survey east = well(WellKind::building, inclination, azimuth);
      survey::Survey west = east;
      for (survey::Station& s : west.stations) {
        s.azimuth = 2 * kPi - s.azimuth;
        s.toolface = -s.toolface;
      }
      const estimate::EstimatorOptions o = estimator("msa_joint", kAll, e);  // with priors: well conditioned everywhere
      const Benefit a = predict_benefit(east, kField, e, o), b = predict_benefit(west, kField, e, o);
      check_same(a.before, b.before, 1e-8);
      check_same(a.after, b.after, 1e-8);
    }
}

TEST_CASE("Towards the vertical, up or down, the ratios have a limit") {
  const estimate::InputErrors e = errors();
  for (const double vertical : {0.0, 180.0})
    for (const double azimuth : {0.0, 90.0, 217.0}) {
      std::array<double, 2> ratio[2];
      for (int k = 0; k < 2; ++k) {
        const double inclination = std::abs(vertical - (k == 0 ? 1e-3 : 1e-6));
        const Benefit b =
            predict_benefit(well(WellKind::straight, inclination, azimuth), kField, e, estimator("msa", kBiases, {}));
        ratio[k] = {benefit_ratio(b.before.azimuth, b.after.azimuth), benefit_ratio(b.before.lateral, b.after.lateral)};
      }
      for (std::size_t q = 0; q < 2; ++q) {
        CHECK(std::isfinite(ratio[1][q]));
        CHECK_THAT(ratio[0][q], WithinRel(ratio[1][q], 1e-3));  // the ratio's slope is of order 1 per rad
      }
    }
}

TEST_CASE("MSA harms a horizontal well to the east and helps one to the north") {
  const estimate::InputErrors e = errors();
  const auto ratio = [&](double azimuth) {
    const Benefit b = predict_benefit(well(WellKind::straight, 90, azimuth), kField, e, estimator("msa", kBiases, {}));
    return benefit_ratio(b.before.azimuth, b.after.azimuth);
  };
  CHECK(ratio(0) < 1);
  CHECK(ratio(85) > 2);
  CHECK(ratio(85) > ratio(80));
  // Straight east the hole has no component of the field to see its axial bias by: nothing but rounding.
  CHECK(ratio(90) == INFINITY);
  CHECK(ratio(270) == INFINITY);
  const Benefit axial = predict_benefit(well(WellKind::straight, 90, 90), kField, e,
                                        estimator("msa", {false, false, false, false, false, true}, {}));
  CHECK(axial.after.azimuth == INFINITY);
}

TEST_CASE("What a well cannot determine is infinite, with priors it is no worse than before") {
  const estimate::InputErrors e = errors(220);
  const survey::Survey straight = well(WellKind::straight, 50, 70);
  const Benefit six = predict_benefit(straight, kField, e, estimator("msa", kAll, {}));
  CHECK(six.after.azimuth == INFINITY);
  CHECK(six.after.lateral == INFINITY);
  CHECK(six.condition == INFINITY);
  CHECK(std::isnan(six.gain_bias_correlation));
  CHECK(std::isfinite(predict_benefit(straight, kField, e, estimator("msa", kNoGainZ, {})).after.azimuth));
  // A linear estimate with the right weights and priors is the best one; leaving the readings alone is another.
  for (const WellKind kind : {WellKind::straight, WellKind::building})
    for (const double inclination : {5.0, 50.0, 90.0, 130.0})
      for (const double azimuth : {0.0, 60.0, 90.0}) {
        const Benefit b = predict_benefit(well(kind, inclination, azimuth), kField, e, estimator("msa_joint", kAll, e));
        CHECK(b.after.azimuth <= b.before.azimuth * (1 + 1e-9));
        CHECK(b.after.lateral <= b.before.lateral * (1 + 1e-9));
      }
}

TEST_CASE("Lateral after MSA is that of the position study's exact linear covariance") {
  const survey::Survey s = well(WellKind::building, 70, 25);
  const sensor::NoiseModel noise = noise_of(1);
  const sensor::ToolSpread spread{.0016, 70, 220};
  const estimate::InputErrors e = input_errors(noise, spread, kField);
  for (const std::string name : {"msa", "msa_joint"}) {
    const estimate::EstimatorOptions o = estimator(name, kAll, e);
    const MsaPrediction p = predict_msa(s, kField, {}, spread, noise, sensor::clean_readings(s, kField, {}), o);
    const Eigen::RowVector3d lateral = lateral_of(s);
    const Eigen::Matrix3d position = p.linear.covariance.bottomRightCorner<3, 3>();
    const double expected = std::sqrt(lateral * position * lateral.transpose());
    CHECK_THAT(predict_benefit(s, kField, e, o).after.lateral, WithinRel(expected, 1e-9));
  }
}

TEST_CASE("Errors of the reference that last have the position study's lateral, and before MSA none") {
  const survey::Survey s = well(WellKind::building, 70, 25);
  sensor::NoiseModel noise = noise_of(1);
  const sensor::ToolSpread spread{.0016, 70, 220};
  const sensor::CleanReadings clean = sensor::clean_readings(s, kField, {});
  const Eigen::RowVector3d lateral = lateral_of(s);
  noise.reference = sensor::ReferenceNoise::per_station;
  const estimate::InputErrors e = input_errors(noise, spread, kField);
  const Eigen::Index n = 2 * s.size();
  const auto correlation = [&](double r) {  // of a draw and the one of the same element at the station before
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = i % 2; j < n; j += 2) c(i, j) = std::pow(r, std::abs(i - j) / 2);
    return c;
  };
  for (const std::string name : {"msa", "msa_joint"}) {
    const estimate::EstimatorOptions o = estimator(name, kAll, e);
    const Eigen::MatrixXd lasts = correlation(0.8), independent = correlation(0), whole = correlation(1);
    const MsaPrediction p = predict_msa(s, kField, {}, spread, noise, clean, o, &lasts);
    const Eigen::Matrix3d position = p.linear.covariance.bottomRightCorner<3, 3>();
    const Benefit b = predict_benefit(s, kField, e, o, &lasts);
    CHECK_THAT(b.after.lateral, WithinRel(std::sqrt(lateral * position * lateral.transpose()), 1e-9));
    CHECK_THAT(
        b.gain_bias_correlation,
        WithinRel(p.parameter_covariance(2, 5) / std::sqrt(p.parameter_covariance(2, 2) * p.parameter_covariance(5, 5)),
                  1e-9));
    check_same(predict_benefit(s, kField, e, o, &independent).after, predict_benefit(s, kField, e, o).after, 1e-12);
    CHECK(b.after.lateral > 1.05 * predict_benefit(s, kField, e, o).after.lateral);
    check_same(b.before, predict_benefit(s, kField, e, o).before, 0);
    // Errors that last for the whole run are those of the run.
    estimate::InputErrors of_run = e;
    of_run.reference_per_station = false;
    const Benefit run = predict_benefit(s, kField, of_run, o), same = predict_benefit(s, kField, e, o, &whole);
    check_same(same.after, run.after, 1e-9);
    Eigen::Vector2d by_dip = Eigen::Vector2d::Zero();
    for (Eigen::Index i = 1; i < n; i += 2) by_dip += same.after_by_reference.col(i);
    CHECK((run.after_by_reference.col(1) - by_dip).norm() < 1e-9 * run.after_by_reference.norm());
  }
}

TEST_CASE("Azimuth and lateral before and after agree with brute force, whatever is estimated", "[long]") {
  // All sizes a tenth: second-order effects are then a per cent of a sd at most, and a standard error is 0.8 %.
  constexpr double scale = .1;
  constexpr int trials = 8192;
  const sensor::NoiseModel noise = noise_of(scale);
  const sensor::ToolSpread spread{.0016 * scale, 70 * scale, 220 * scale};
  const estimate::InputErrors e = input_errors(noise, spread, kField);
  const survey::Survey s = well(WellKind::building, 70, 50);
  const sensor::CleanReadings clean = sensor::clean_readings(s, kField, {});
  survey::ReadingBlock block = sensor::make_reading_block(trials, s.size(), noise);
  survey::LaneArray deviation(survey::groups_for(trials), 6), position(survey::groups_for(trials), 3),
      nothing(survey::groups_for(trials), 6);
  for (int g = 0; g < survey::groups_for(trials); ++g)
    for (int i = 0; i < 3; ++i) nothing.fill(g, i, 1);
  sensor::simulate_readings(clean, kField, noise, random::Stream(5, 7), 0, block);
  sensor::spread_tools(clean, spread, false, random::Stream(5, 7), 0, block, deviation);
  const Eigen::RowVector3d lateral = lateral_of(s);
  const auto sd_with = [&](const survey::LaneArray& parameters) {
    survey::corrected_final_positions(block, parameters, s.md(), 0, position);
    Eigen::MatrixXd x(trials, 2);
    const int last = s.size() - 1;
    for (int t = 0; t < trials; ++t) {
      const estimate::Vector6d p = test::parameters_of(parameters, t);
      const Eigen::Vector3d m = survey::to_eigen(test::triad(block.magnetic, t, last)),
                            b = (m - p.tail<3>()).cwiseQuotient(p.head<3>());
      x(t, 0) = survey::attitude_from_fields(test::triad(block.down, t, last), survey::from_eigen(b)).azimuth;
      x(t, 1) = lateral.dot(Eigen::RowVector3d(position.value(t, 0), position.value(t, 1), position.value(t, 2)));
    }
    const stats::Moments m = stats::Moments::of(x);
    return BenefitSd{std::sqrt(m.variance(0)), std::sqrt(m.variance(1))};
  };
  const double bound = 4.5 / std::sqrt(2.0 * trials) + .01;
  for (const std::string name : {"msa", "msa_joint", "msa_weighted"})
    for (const std::array<bool, 6>& estimated : {kAll, kBiases, kNoGainZ}) {
      const estimate::EstimatorOptions o = estimator(name, estimated, e);
      estimate::EstimateBlock out(trials);
      estimate::make_estimator(o, kField)->solve(block, out);
      for (int t = 0; t < trials; ++t) REQUIRE(out.converged.value(t, 0) == 1);
      const Benefit b = predict_benefit(s, kField, e, o);
      const BenefitSd before = sd_with(nothing), after = sd_with(out.parameters);
      CAPTURE(name, estimated[0], estimated[2]);
      check_same(before, b.before, bound);
      check_same(after, b.after, bound);
    }
}

TEST_CASE("First order is whole before and after: 200 wells, every subset, against trials of little noise", "[long]") {
  constexpr double scale = 0.02;
  constexpr int trials = 128, sums_of_draws = sensor::NoiseWeights::kSums;
  constexpr std::array<std::array<bool, 6>, 3> subsets{kAll, kBiases, kNoGainZ};
  const std::array<std::string, 3> names{"msa", "msa_joint", "msa_weighted"};
  int number = 0;
  for (int found = 0; found < 200; ++number) {
    test::RandomRun r = test::random_run(number, scale);
    r.errors = {};
    const auto choice = static_cast<std::size_t>(number);
    const sensor::ToolSpread spread{.0016 * scale, 70 * scale, number % 2 == 0 ? 220 * scale : 0};
    const estimate::InputErrors e = input_errors(r.noise, spread, r.field);
    const estimate::EstimatorOptions o = estimator(names[choice % 3], subsets[choice / 3 % 3], e);
    const sensor::CleanReadings clean = sensor::clean_readings(r.survey, r.field, {});
    const estimate::NominalTruth truth{sensor::station_fields(clean), {1, 1, 1}, {0, 0, 0}, r.field};
    const std::optional<estimate::Sensitivity> s = estimate::find_sensitivity(o, truth);
    const estimate::Matrix8d covariance = estimate::error_covariance(*s, truth.stations, e);
    if (covariance.diagonal().head<3>().maxCoeff() > std::pow(scale * 0.05, 2)) continue;
    ++found;

    const BenefitEffects effects = benefit_effects(r.survey, truth, s, e);
    InputEffects<sums_of_draws> both;  // rows: azimuth, lateral before; azimuth, lateral after
    const auto stacked = [](const auto& before, const auto& after, auto& out) {
      out.setZero();
      out.template topRows<2>() = before;
      out.template middleRows<2>(2) = after;
    };
    both.magnetometer.resize(truth.stations.size());
    both.accelerometer.resize(truth.stations.size());
    both.reference.resize(effects.before.reference.size());
    for (std::size_t k = 0; k < truth.stations.size(); ++k) {
      stacked(effects.before.magnetometer[k], effects.after->magnetometer[k], both.magnetometer[k]);
      stacked(effects.before.accelerometer[k], effects.after->accelerometer[k], both.accelerometer[k]);
    }
    for (std::size_t k = 0; k < both.reference.size(); ++k)
      stacked(effects.before.reference[k], effects.after->reference[k], both.reference[k]);
    stacked(effects.before.tool, effects.after->tool, both.tool);
    const sensor::NoiseWeights weights = noise_weights(both, r.noise, spread);

    const int groups = survey::groups_for(trials), last = r.survey.size() - 1;
    survey::ReadingBlock block = sensor::make_reading_block(trials, r.survey.size(), r.noise);
    survey::LaneArray sums(groups, sums_of_draws), deviation(groups, 6), before(groups, 3), after(groups, 3),
        nothing(groups, 6);
    for (int g = 0; g < groups; ++g)
      for (int i = 0; i < 3; ++i) nothing.fill(g, i, 1);
    const random::Stream stream(78, 7);
    sensor::simulate_readings(clean, r.field, r.noise, stream, 0, block, &weights, &sums);
    sensor::spread_tools(clean, spread, true, stream, 0, block, deviation, &weights, &sums);
    estimate::EstimateBlock out(trials);
    estimate::make_estimator(o, r.field)->solve(block, out);
    survey::corrected_final_positions(block, nothing, r.survey.md(), r.field.declination, before);
    survey::corrected_final_positions(block, out.parameters, r.survey.md(), r.field.declination, after);
    const Eigen::RowVector3d lateral = lateral_of(r.survey);
    Eigen::MatrixXd errors(trials, 4), linear(trials, 4);
    for (int t = 0; t < trials; ++t) {
      REQUIRE(out.converged.value(t, 0) == 1);
      for (int half = 0; half < 2; ++half) {
        const survey::LaneArray& position = half == 0 ? before : after;
        const estimate::Vector6d p = test::parameters_of(half == 0 ? nothing : out.parameters, t);
        const Eigen::Vector3d m = survey::to_eigen(test::triad(block.magnetic, t, last)),
                              b = (m - p.tail<3>()).cwiseQuotient(p.head<3>());
        const double azimuth =
            survey::attitude_from_fields(test::triad(block.down, t, last), survey::from_eigen(b)).azimuth;
        errors(t, 2 * half) = std::remainder(azimuth + r.field.declination - r.survey.stations.back().azimuth, 2 * kPi);
        errors(t, 2 * half + 1) =
            lateral.dot(Eigen::RowVector3d(position.value(t, 0), position.value(t, 1), position.value(t, 2)));
      }
      for (int i = 0; i < 4; ++i) linear(t, i) = sums.value(t, i);
    }
    const auto known = sensor::noise_sum_moments(weights, r.noise.law).covariance;
    const Benefit predicted = predict_benefit(r.survey, r.field, e, o);
    const std::array<double, 4> sd{predicted.before.azimuth, predicted.before.lateral, predicted.after.azimuth,
                                   predicted.after.lateral};
    for (int i = 0; i < 4; ++i) {
      CAPTURE(number, o.name, i);
      const double variance = sd[static_cast<std::size_t>(i)] * sd[static_cast<std::size_t>(i)];
      CHECK(std::abs(test::controlled_ratio(errors.col(i), linear.col(i), known(i, i), variance) - 1) < 1e-3);
    }
  }
  CHECK(number < 220);
}

TEST_CASE("Wells end in the direction asked for") {
  WellDesign w{.kind = WellKind::building, .stations = 5, .spacing = 10, .build_rate = 1 * kDegree};
  const survey::Survey s = make_well(w, 25 * kDegree, 100 * kDegree);
  REQUIRE(s.size() == 5);
  CHECK(survey::find_defect(s).rule.empty());
  const std::array<double, 5> inclination{0, 0, 5, 15, 25};
  for (std::size_t k = 0; k < 5; ++k) {
    CHECK_THAT(s.stations[k].md, WithinAbs(10.0 * static_cast<double>(k), 0));
    CHECK_THAT(s.stations[k].inclination, WithinAbs(inclination[k] * kDegree, 1e-12));
    CHECK(s.stations[k].azimuth == 100 * kDegree);
  }
  w.kind = WellKind::straight;
  for (const survey::Station& station : make_well(w, 25 * kDegree, 0).stations)
    CHECK(station.inclination == 25 * kDegree);
}

TEST_CASE("Toolfaces are spread evenly, drawn, or constant") {
  WellDesign w{.stations = 200};
  const auto toolfaces = [&w] {
    std::vector<double> t;
    for (const survey::Station& s : make_well(w, 1, 1).stations) t.push_back(s.toolface);
    return t;
  };
  std::vector<double> even = toolfaces();
  std::sort(even.begin(), even.end());
  double largest_gap = even.front() + 2 * kPi - even.back();
  for (std::size_t k = 1; k < even.size(); ++k) largest_gap = std::max(largest_gap, even[k] - even[k - 1]);
  CHECK(largest_gap < 2 * 2 * kPi / 200);  // the three-gap theorem: at most 1.6 times the mean gap or so
  w.toolface = ToolfaceSequence::constant;
  for (const double t : toolfaces()) CHECK(t == 0);
  w.toolface = ToolfaceSequence::random;
  const std::vector<double> first = toolfaces();
  CHECK(first == toolfaces());
  w.seed.seed = 1;
  CHECK(first != toolfaces());
  double sum = 0;
  for (const double t : first) {
    CHECK((t > 0 && t < 2 * kPi));
    sum += t;
  }
  CHECK(std::abs(sum / 200 - kPi) < 4 * kPi / std::sqrt(3.0 * 200));  // uniform: sd pi / sqrt 3
}
