/// The short way to MSA's minimum, from an expansion point, held against the long one.
#include "estimate/msa_chord.h"

#include <catch2/catch.hpp>

#include "msa_trials.h"
#include "simd/dual.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {

using Trials = test::MsaTrials;
using test::msa_noise;

/// The true parameters, and the inverse of Newton's matrix of the readings without noise.
MsaExpansion expansion(const Trials& trials) {
  const Trials quiet(trials.c.number, 1, {});
  MsaExpansion out{.x = trials.truth(), .inverse = {}};
  const MsaData d = quiet.lane(0);
  const auto factor =
      simd::ldlt<double, 6>(msa_normal_equations<double>(d, msa_reading_sums<double>(d), out.x, 1).matrix);
  for (std::size_t j = 0; j < 6; ++j) {
    std::array<double, 6> unit{};
    unit[j] = 1;
    const auto column = simd::ldlt_solve<double, 6>(factor, unit);
    for (std::size_t i = 0; i < 6; ++i) out.inverse[6 * i + j] = column[i];
  }
  return out;
}

}  // namespace

TEST_CASE("The chord iteration's gradient is that of dual numbers", "[msa_chord]") {
  using D = simd::Dual<double, 6>;
  for (const int number : {1, 3, 4})
    for (const sensor::ReferenceNoise reference :
         {sensor::ReferenceNoise::per_run, sensor::ReferenceNoise::per_station}) {
      const Trials trials(number, 8, msa_noise(1, reference, 1e-3));
      const std::array<double, 6> x{0.93, 1.04, 0.85, 0.004, -0.003, 0.02};
      std::array<D, 6> v;
      for (std::size_t i = 0; i < 6; ++i) v[i] = D::variable(x[i], i);
      const D cost = trials.cost(2, v);
      const auto e = msa_gradient<double>(trials.lane(2), x);
      CHECK(e.cost == Approx(cost.a).epsilon(1e-12));
      // A sum of 2 x stations terms of order one
      for (std::size_t i = 0; i < 6; ++i)
        CHECK(std::abs(e.gradient[i] - cost.d[i] / 2) < 1e-14 * 2 * trials.block.stations);
    }
}

TEST_CASE("The series for 1/Bh is wrong by its fourth-order term", "[msa_chord]") {
  // Readings scaled from the truth by 1 + s: Bh / Bh_ref = 1 + s, tau = 2 s + s^2 at every station, and the horizontal
  // part of the gradient is (series error) x sum of h m, with |h| |m| < 1.2 in units of total^2.
  for (const double s : {1e-3, 1e-2, 5e-2}) {
    const Trials trials(4, 8, {});
    auto x = expansion(trials).x;
    for (double& v : x) v *= 1 + s;
    const auto exact = msa_gradient<double>(trials.lane(0), x);
    const auto series = msa_gradient<double, true>(trials.lane(0), x);
    const double tau = 2 * s + s * s, bound = 0.28 * tau * tau * tau * tau * 1.2 * trials.block.stations + 1e-12;
    for (std::size_t i = 0; i < 6; ++i) CHECK(std::abs(series.gradient[i] - exact.gradient[i]) < bound);
  }
}

TEST_CASE("From the expansion point and from unit gains: the same minimum in every trial of every test",
          "[msa_chord][long]") {
  // The long way's last steps may be chord steps too, each a tenth of the one before: both ends are within a ninth of
  // the tolerance. Biases in units of the total field.
  const EstimatorOptions options{.max_iterations = 400};
  for (int number = 1; number <= 4; ++number)
    for (const sensor::NoiseModel& n : test::kinds_of_msa_noise()) {
      const Trials trials(number, 4000, n);
      test::require_same_minima(trials, trials.solve(options, true), trials.solve(options, false),
                                options.step_tolerance);
    }
}

TEST_CASE("Where the chord iteration does not contract, a trial has the bits of the long way", "[msa_chord][long]") {
  const NewtonOptions options;
  int short_way = 0, long_way = 0;
  const Trials trials(1, 2000, msa_noise(1, sensor::ReferenceNoise::per_run));  // two modes in one valley
  const MsaExpansion start = expansion(trials);
  for (int t = 0; t < trials.block.trials; ++t) {
    const auto near = msa_solve_near<double>(trials.lane(t), start, options);
    const auto s = msa_solve<double>(trials.lane(t), &start, options);
    if (near.converged == 1) {
      ++short_way;
      REQUIRE(s.x == near.x);
      REQUIRE(s.iterations == near.iterations);
      continue;
    }
    ++long_way;
    const auto whole = msa_solve<double>(trials.lane(t), options);
    REQUIRE(s.x == whole.x);
    REQUIRE(s.cost == whole.cost);
    REQUIRE(s.converged == whole.converged);
    REQUIRE(s.iterations == near.iterations + whole.iterations);
  }
  CHECK(short_way > 200);
  CHECK(long_way > 200);
}

TEST_CASE("With an expansion point, too, a trial in a lane has the same bits as the trial solved alone",
          "[msa_chord]") {
  for (const int number : {1, 2, 4})
    for (const double tolerance : {1e-9, 1e-6}) {
      const NewtonOptions options{200, tolerance};
      const Trials trials(number, 80, msa_noise(1, sensor::ReferenceNoise::per_run));
      const MsaExpansion start = expansion(trials);
      test::require_bits_of_trials_alone(80,
                                         [&]<class T>(int t) { return msa_solve<T>(trials.lane(t), &start, options); });
    }
}

TEST_CASE("The throughput config's trials need three gradients, and none the long way", "[msa_chord]") {
  const NewtonOptions options{200, 1e-6};
  Trials trials(4, 2000, msa_noise(1, sensor::ReferenceNoise::none));
  const MsaExpansion start = expansion(trials);
  double evaluations = 0;
  for (int t = 0; t < trials.block.trials; ++t) {
    const auto s = msa_solve_near<double>(trials.lane(t), start, options);
    REQUIRE(s.converged == 1);
    evaluations += s.iterations / trials.block.trials;
  }
  CHECK(evaluations < 3.1);
}

TEST_CASE("Nonsense and too few iterations are flagged with an expansion point too", "[msa_chord]") {
  Trials trials(4, 8, msa_noise(1, sensor::ReferenceNoise::per_run));
  test::check_nonsense_is_flagged(trials.block, [&](const EstimatorOptions& o) { return trials.solve(o, true); });
}

TEST_CASE("Readings without noise end at the truth at once", "[msa_chord]") {
  for (int number = 1; number <= 4; ++number) {
    const Trials quiet(number, 1, {});
    const EstimateBlock out = quiet.solve({}, true);
    CHECK(out.converged.value(0, 0) == 1);
    CHECK(out.iterations.value(0, 0) == 3);  // two by series, one exact
    test::check_parameters(test::parameters_of(out.parameters, 0), test::true_parameters(quiet.c), 1e-9, 1e-6);
  }
}

TEST_CASE("Expected readings that determine nothing are left aside", "[msa_chord]") {
  const Trials trials(4, 8, msa_noise(1, sensor::ReferenceNoise::per_run));
  const std::size_t n = trials.clean.magnetic_T.size();
  const std::vector same(n, trials.clean.magnetic_T[0]);
  const std::vector fields(n, sensor::station_fields(trials.clean)[0]);
  EstimateBlock out(8);
  make_estimator({}, trials.c.field, fields, same)->solve(trials.block, out);
  const EstimateBlock whole = trials.solve({}, false);
  for (int t = 0; t < 8; ++t)
    for (int i = 0; i < 6; ++i) CHECK(out.parameters.value(t, i) == Approx(whole.parameters.value(t, i)).epsilon(1e-8));
}
