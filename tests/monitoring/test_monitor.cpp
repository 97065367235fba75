/// Kalman drift tracker, tests of alarms, metrics, and the two architectures.
#include <cstring>
#include <random>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "monitoring/alarm_tests.h"
#include "monitoring/metrics.h"
#include "monitoring/monitor.h"
#include "monitoring/sequential_tests.h"
#include "monitoring/sprt_false_alarms.h"
#include "simd/instruction_set.h"

using namespace surveymc;
using namespace surveymc::monitoring;
using Catch::Matchers::WithinAbs;

namespace {
Eigen::RowVectorXd one(double x) { return Eigen::RowVectorXd::Constant(1, x); }
}  // namespace

TEST_CASE("The drift filter follows a constant drift as computed, and ends in its steady state", "[monitoring]") {
  const DriftFilterOptions options;
  DriftFilter filter(options, 1);
  auto run_to = [&, done = 0](int samples) mutable {
    for (; done < samples; ++done) filter.update(one(1));
    return filter.drift()[0];
  };
  CHECK_THAT(run_to(1), WithinAbs(.00033322225924691776, 1e-15));
  CHECK_THAT(run_to(10), WithinAbs(.01805636924132389, 1e-15));
  CHECK_THAT(run_to(100), WithinAbs(.68864492274741, 1e-13));
  run_to(5000);
  const SteadyDriftFilter steady = steady_drift_filter(options);
  CHECK_THAT(steady.predicted_variance, WithinAbs(5.527454e-3, 5e-10));  // printed digits
  CHECK_THAT(steady.gain, WithinAbs(1.809151e-2, 5e-9));
  CHECK_THAT(filter.gain(), WithinAbs(steady.gain, 1e-14));
}

TEST_CASE("The gate skips a row that one sensor spoils, and only widens the variance", "[monitoring]") {
  const DriftFilterOptions options{.gate = 5};
  DriftFilter gated(options, 2);
  for (int i = 0; i < 200; ++i) CHECK(gated.update(Eigen::RowVector2d(.1, -.1)));
  const Eigen::RowVectorXd before = gated.drift();
  const double variance = gated.variance();
  for (int i = 0; i < 6; ++i) CHECK_FALSE(gated.update(Eigen::RowVector2d(.1, -60)));
  CHECK(gated.drift() == before);
  CHECK_THAT(gated.variance(), WithinAbs(variance + 6e-4, 1e-15));
  CHECK_FALSE(gated.update(Eigen::RowVector2d(.1, kNaN)));
  CHECK(gated.update(Eigen::RowVector2d(.1, -.1 - 5 * std::sqrt(.3) + .02)));  // inside: d is about -0.1
}

TEST_CASE("SPRT bounds, restart and two sides", "[monitoring]") {
  const SprtOptions options{.variance = 1};
  CHECK_THAT(sprt_lower(options), WithinAbs(-2.251292, 5e-7));
  CHECK_THAT(sprt_upper(options), WithinAbs(2.890372, 5e-7));

  // d = 2: S grows by 3 (2 - 1.5) = 1.5 a sample: alarms at samples 2, 4, 6 (3 >= 2.89), each from a new sum.
  Sprt up(options);
  std::vector<int> accepted;
  for (int i = 0; i < 6; ++i) accepted.push_back(up.update(2));
  CHECK(accepted == std::vector<int>{0, 1, 0, 1, 0, 1});
  CHECK(up.decision() == 1);
  up.update(0);  // -4.5 <= ln A: H0 at once
  CHECK(up.decision() == 0);

  Sprt down(options);
  CHECK(down.update(-3) == -1);
  CHECK(down.decision() == -1);
  CHECK(down.update(-1.5) == 0);  // at M/2 the sum stays, and the decision holds
  CHECK(down.decision() == -1);
}

TEST_CASE("Under its own hypotheses the SPRT errs no more often than alpha and beta say", "[monitoring]") {
  // Wald: P(accept H1 | H0) <= alpha / (1 - beta), P(accept H0 | H1) <= beta / (1 - alpha). A shift of 0.5 sd keeps the
  // overshoot small, so that the rates are also not far below.
  const SprtOptions options{.shift = 0.5, .variance = 1};
  std::mt19937_64 g(20);
  std::normal_distribution<double> normal;
  const double lower = sprt_lower(options), upper = sprt_upper(options);
  for (const bool shifted : {false, true}) {
    int wrong = 0;
    constexpr int kDecisions = 20000;
    for (int t = 0; t < kDecisions; ++t) {
      double s = 0;
      while (s > lower && s < upper)
        s += options.shift * (normal(g) + (shifted ? options.shift : 0) - options.shift / 2);
      wrong += (s >= upper) != shifted;
    }
    const double bound = shifted ? .10 / .95 : .05 / .90, rate = static_cast<double>(wrong) / kDecisions;
    CHECK(rate < bound + 4 * std::sqrt(bound / kDecisions));
    CHECK(rate > bound / 3);
    // The class decides like the sums above.
    Sprt sprt(options);
    double s = 0;
    for (int i = 0; i < 3000; ++i) {
      const double d = normal(g) + (shifted ? options.shift : 0);
      s += options.shift * (d - options.shift / 2);
      const bool alarm = s >= upper;
      if (s <= lower || alarm) s = 0;
      REQUIRE((sprt.update(d) == 1) == alarm);
    }
  }
}

TEST_CASE("CUSUM and threshold", "[monitoring]") {
  Cusum c({.allowance = .5, .threshold = 5});
  int first = 0;
  for (int i = 1; i <= 20 && first == 0; ++i)
    if (c.update(-1) == -1) first = i;
  CHECK(first == 10);
  for (int i = 0; i < 1000; ++i) CHECK(c.update(.5) == 0);
  CHECK(Threshold(3).update(2.9) == 0);
  CHECK(Threshold(3).update(3) == 1);
  CHECK(Threshold(3).update(-3.1) == -1);
}

TEST_CASE("Sensitivities leave samples without drift out and know who drifts", "[monitoring]") {
  Samples with(4, 3), without = Samples::Zero(4, 3), drift(4, 3);
  with << 9, 9, 9, .5, .1, .2, 1, .2, .4, 1.5, .3, .6;  // the first row is before the drift
  drift << 0, 0, 0, 1, 2, 0, 2, 4, 0, 3, 6, 0;
  const Eigen::MatrixXd s = sensitivities(with, without, drift);
  CHECK_THAT(s(0, 0), WithinAbs(.5, 1e-15));
  CHECK_THAT(s(1, 1), WithinAbs(.05, 1e-15));
  CHECK_THAT(s(2, 0), WithinAbs(.2, 1e-15));
  CHECK_THAT(s(2, 1), WithinAbs(.1, 1e-15));
  CHECK(std::isnan(s(2, 2)));
  CHECK_THAT(mean_auto_sensitivity(s), WithinAbs(.275, 1e-15));
  CHECK_THAT(mean_cross_sensitivity(s), WithinAbs(.15, 1e-15));
  CHECK(mean_square_error(with, without)[0] == (81 + .25 + 1 + 2.25) / 4);
}

TEST_CASE("AKS corrects what AS spreads: one drifting sensor of three", "[monitoring]") {
  std::mt19937_64 g(21);
  std::normal_distribution<double> normal;
  const auto readings = [&](int n, double noise) {
    Samples x(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double t = 1.5 * std::sin(.01 * static_cast<double>(i));
      x.row(i) << t + noise * normal(g), -t + noise * normal(g), .5 * t * t + noise * normal(g);
    }
    return x;
  };
  const Samples memory = readings(1000, .05);
  const Aakr model(memory, .2);
  Samples test = readings(3000, .05);
  Samples drifted = test;
  for (Eigen::Index i = 0; i < 3000; ++i) drifted(i, 0) += 2 * static_cast<double>(i) / 2999;
  const DriftFilterOptions filter;
  const auto as = run_monitor(Architecture::aakr_sprt, model, filter, drifted),
             aks = run_monitor(Architecture::aakr_kf_sprt, model, filter, drifted);
  CHECK(as.signal == drifted - as.prediction);
  CHECK(aks.signal.row(0).cwiseAbs().maxCoeff() < .01);
  const auto tail = [](const MonitorTrace& t, Eigen::Index j) { return t.signal.col(j).tail(600).mean(); };
  CHECK(std::abs(tail(aks, 0) - 1.8) < std::abs(tail(as, 0) - 1.8));
  CHECK(std::abs(tail(aks, 1)) < std::abs(tail(as, 1)));
  CHECK_THROWS_AS(run_monitor(Architecture::aakr_sprt, model, filter, Samples::Zero(3, 2)), InputError);
}

TEST_CASE("A monitor gives the same bits however its readings are divided", "[monitoring]") {
  std::mt19937_64 g(22);
  std::normal_distribution<double> normal;
  const Samples memory = Samples::NullaryExpr(50, 2, [&] { return normal(g); }),
                readings = Samples::NullaryExpr(300, 2, [&] { return normal(g); });
  const Aakr model(memory, .3);
  const DriftFilterOptions filter{.gate = 4};
  for (const Architecture a : {Architecture::aakr_sprt, Architecture::aakr_kf_sprt}) {
    const MonitorTrace whole = run_monitor(a, model, filter, readings);
    MonitorStream stream(a, model, filter);
    Eigen::Index at = 0, skipped = 0;
    for (const Eigen::Index n : {1, 7, 200, 92}) {
      const MonitorTrace part = stream.next(readings.middleRows(at, n));
      CHECK(part.signal == whole.signal.middleRows(at, n));
      CHECK(part.prediction == whole.prediction.middleRows(at, n));
      CHECK(part.nearest == whole.nearest.segment(at, n));
      skipped += part.skipped;
      at += n;
    }
    CHECK(skipped == whole.skipped);
  }
}

TEST_CASE("Alarms of the SPRT by integration are those of simulation, and of the first sample in closed form",
          "[monitoring][long]") {
  const SprtOptions options{.shift = 1, .variance = 1};
  const auto phi = [](double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); };
  const auto p = sprt_alarm_probability(options, 0, 1, 40);
  // S = d - 1/2 after the first sample.
  CHECK_THAT(p[0], WithinAbs(1 - phi(sprt_upper(options) + 0.5), 1e-15));
  // Two-dimensional by hand: not decided after one sample, then above; or H0 after one sample, then above at once.
  double two = p[0] + phi(sprt_lower(options) + 0.5) * p[0];
  constexpr int kSteps = 20000;
  const double width = (sprt_upper(options) - sprt_lower(options)) / kSteps;
  for (int i = 0; i < kSteps; ++i) {  // midpoint rule: error width^2 / 24 of a curvature of 1
    const double s = sprt_lower(options) + (i + 0.5) * width;
    two +=
        width * std::exp(-0.5 * (s + 0.5) * (s + 0.5)) / std::sqrt(2 * M_PI) * (1 - phi(sprt_upper(options) - s + 0.5));
  }
  CHECK_THAT(p[1], WithinAbs(two, 1e-7 * two + 1e-8));

  std::mt19937_64 g(23);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 200'000;
  std::vector<int> alarms(40, 0);
  for (int r = 0; r < kRuns; ++r) {
    double s = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      s += normal(g) - 0.5;
      if (s <= sprt_lower(options)) s = 0;
      if (s < sprt_upper(options)) continue;
      for (std::size_t k = i; k < 40; ++k) ++alarms[k];
      break;
    }
  }
  for (const std::size_t i : {std::size_t{4}, std::size_t{39}}) {
    const double seen = static_cast<double>(alarms[i]) / kRuns;
    CHECK(std::abs(seen - p[i]) < 4 * std::sqrt(p[i] * (1 - p[i]) / kRuns));
  }
  // Finer increments, more panels: the same sum scaled.
  SprtOptions fine = options;
  fine.shift = 0.1;
  const auto q = sprt_alarm_probability(fine, 0.1, 1, 3000);
  CHECK(q.back() > 0.99);  // under H1 it ends there
  CHECK(std::is_sorted(q.begin(), q.end()));
  CHECK(q.back() <= 1 + 1e-9);
  // Up to the largest number of panels the steps may be small; beyond it there is no value.
  const double distance = sprt_upper(options) - sprt_lower(options);
  fine.shift = 1.0001 * distance / (0.5 * kMostSprtPanels);
  CHECK(sprt_alarm_probability(fine, 1, 1, 200).back() > 0.99);  // 111 +- 11 steps of the mean
  fine.shift *= 0.999;
  const auto none = sprt_alarm_probability(fine, 0, 1, 5);
  CHECK(none.size() == 5);
  CHECK(std::all_of(none.begin(), none.end(), [](double x) { return std::isnan(x); }));
}

TEST_CASE("A two-sided SPRT has its alarms between those of independent and of exclusive sides", "[monitoring]") {
  const SprtOptions options{.false_alarm = 0.2, .shift = 0.2, .variance = 1};
  constexpr int kRuns = 60'000, kSamples = 80;
  std::mt19937_64 g(24);
  std::normal_distribution<double> normal;
  int alarms = 0;
  for (int r = 0; r < kRuns; ++r) {
    Sprt test(options);
    int alarm = 0;
    for (int i = 0; i < kSamples && alarm == 0; ++i) alarm = test.update(normal(g));
    alarms += alarm != 0;
  }
  const double one_side = sprt_alarm_probability(options, 0, 1, kSamples).back();
  const TwoSided p = two_sided_alarm_probability(one_side);
  const double seen = static_cast<double>(alarms) / kRuns, four_se = 4 * std::sqrt(seen * (1 - seen) / kRuns);
  CHECK(p.exclusive - p.independent > 3 * four_se);  // what is tested can be seen
  CHECK(seen > p.independent + four_se);             // here the sides are clearly not independent
  CHECK(seen < p.exclusive + four_se);
}

TEST_CASE("Tests side by side raise the alarms of each alone, on both instruction sets", "[monitoring]") {
  // A signal that wanders through all bounds, in two blocks. Eleven settings: a full group and a part of one.
  std::mt19937_64 g(30);
  std::normal_distribution<double> normal;
  constexpr std::size_t kSamples = 3000, kSensors = 3, kFirstBlock = 1234;
  std::vector<double> signal(kSamples * kSensors), time_h(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) {
    time_h[i] = static_cast<double>(i) / 60;
    for (std::size_t j = 0; j < kSensors; ++j)
      signal[i * kSensors + j] = 2 * std::sin(.004 * static_cast<double>((j + 1) * i)) + normal(g);
  }
  const double start_h = 20;
  std::vector<SprtOptions> sprt(11);
  std::vector<CusumOptions> cusum(11);
  std::vector<double> threshold(11);
  for (std::size_t k = 0; k < 11; ++k) {
    sprt[k].shift = .5 + .4 * static_cast<double>(k);
    cusum[k].threshold = .5 * std::exp2(1.5 * static_cast<double>(k));
    threshold[k] = 1 + .5 * static_cast<double>(k);
  }
  const auto expect = [&](AlarmTests lanes, auto make_alone, std::size_t sensor) {
    for (const std::size_t first : {std::size_t{0}, kFirstBlock})
      lanes.update({signal.data() + first * kSensors + sensor, time_h.data() + first, kSensors,
                    first == 0 ? kFirstBlock : kSamples - kFirstBlock, start_h});
    std::size_t alarms = 0, silent = 0;
    for (std::size_t k = 0; k < 11; ++k) {
      auto alone = make_alone(k);
      double first = kNaN, after = kNaN, count = 0;
      for (std::size_t i = 0; i < kSamples; ++i) {
        if (alone.update(signal[i * kSensors + sensor]) == 0) continue;
        if (std::isnan(first)) first = time_h[i];
        if (std::isnan(after) && time_h[i] >= start_h) after = time_h[i];
        ++count;
      }
      const AlarmTimes t = lanes.times(k);
      INFO("setting " << k);
      CHECK(t.count == count);
      CHECK((t.first == first || (std::isnan(t.first) && std::isnan(first))));
      CHECK((t.first_after_start == after || (std::isnan(t.first_after_start) && std::isnan(after))));
      (count > 0 ? alarms : silent) += 1;
    }
    return std::pair(alarms, silent);
  };
  for (std::size_t j = 0; j < kSensors; ++j) {
    CHECK(expect(
              AlarmTests(sprt), [&](std::size_t k) { return Sprt(sprt[k]); }, j)
              .first == 11);
    const auto [cusums, endless] = expect(
        AlarmTests(cusum), [&](std::size_t k) { return Cusum(cusum[k]); }, j);
    CHECK((cusums >= 5 && endless >= 1));
    const auto [crossed, above] = expect(
        AlarmTests(threshold), [&](std::size_t k) { return Threshold(threshold[k]); }, j);
    CHECK((crossed >= 5 && above >= 1));
  }

  if (simd::instruction_set() == simd::InstructionSet::v4) {
    AlarmLanes wide{}, narrow{};
    for (AlarmLanes* a : {&wide, &narrow}) {
      a->kind = AlarmLanes::Kind::sprt;
      for (std::size_t k = 0; k < 8; ++k) {
        const double of_one[] = {sprt[k].shift / sprt[k].variance, sprt[k].shift / 2, sprt_lower(sprt[k]),
                                 sprt_upper(sprt[k])};
        for (std::size_t i = 0; i < 4; ++i) a->settings[i][k] = of_one[i];
        a->first[k] = a->first_after_start[k] = kInfinity;
      }
    }
    const AlarmSignal all{signal.data(), time_h.data(), kSensors, kSamples, start_h};
    isa_v4::update_alarms(wide, all);
    isa_v3::update_alarms(narrow, all);
    CHECK(std::memcmp(&wide, &narrow, sizeof wide) == 0);
  }
}

TEST_CASE("A monitor that is given its predictions makes the same signal", "[monitoring]") {
  std::mt19937_64 g(31);
  std::normal_distribution<double> normal;
  const Samples memory = Samples::NullaryExpr(60, 3, [&] { return normal(g); }),
                readings = Samples::NullaryExpr(200, 3, [&] { return 2 * normal(g); });
  const Aakr model(memory, .4);
  const DriftFilterOptions options{.gate = 6};  // some rows are skipped
  for (const Architecture a : {Architecture::aakr_sprt, Architecture::aakr_kf_sprt}) {
    const MonitorTrace own = run_monitor(a, model, options, readings);
    MonitorStream told(a, model, options, false), unasked(a, model, options, false);
    const MonitorTrace first = told.next(readings.topRows(77), own.prediction.topRows(77)),
                       second = told.next(readings.bottomRows(123), own.prediction.bottomRows(123));
    CHECK(first.signal == own.signal.topRows(77));
    CHECK(second.signal == own.signal.bottomRows(123));
    CHECK(first.skipped + second.skipped == own.skipped);
    CHECK((a == Architecture::aakr_sprt) == (own.skipped == 0));
    const MonitorTrace without = unasked.next(readings);  // the distances to the nearest vectors are not asked for
    CHECK(without.prediction == own.prediction);
    CHECK(without.nearest.size() == 0);
  }
}
