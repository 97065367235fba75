/// MSA from the valley of each trial, part by part against the normal equations, and whole against the long way.
#include "estimate/msa_valley.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "estimate/msa.h"
#include "msa_trials.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

using test::msa_noise;

struct NoisyTrials : test::MsaTrials {
  NoisyTrials(int number, int count, const sensor::NoiseModel& n, std::uint64_t first = 0)
      : MsaTrials(number, count, n, 12, first),
        valley(*msa_valley(sensor::station_fields(clean), clean.magnetic_T, c.field)) {}
  EstimateBlock by_valley(const EstimatorOptions& o) const {
    EstimateBlock out(block.trials);
    make_msa_in_valley({o.max_iterations, o.step_tolerance}, c.field, sensor::station_fields(clean), clean.magnetic_T)
        ->solve(block, out);
    return out;
  }
  Matrix6 to_x() const { return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(valley.to_x.data()); }

  MsaValley valley;
};

/// Half the cost, its gradient and Newton's matrix in y.
struct InY {
  double cost;
  Vector6 gradient;
  Matrix6 matrix;
};
InY in_y(const NoisyTrials& trials, const MsaData& data, const Vector6& y) {
  const Vector6 dx = trials.to_x() * y;
  std::array<double, 6> x = trials.valley.x;
  for (int i = 0; i < 6; ++i) x[static_cast<std::size_t>(i)] += dx[i];
  const auto e = msa_normal_equations<double>(data, msa_reading_sums<double>(data), x, 1.0);
  InY out{e.cost / 2, {}, {}};
  for (int i = 0; i < 6; ++i) {
    out.gradient[i] = e.gradient[static_cast<std::size_t>(i)];
    for (int j = 0; j < 6; ++j)
      out.matrix(i, j) =
          e.matrix[simd::packed(static_cast<std::size_t>(std::max(i, j)), static_cast<std::size_t>(std::min(i, j)))];
  }
  out.gradient = trials.to_x().transpose() * out.gradient;
  out.matrix = trials.to_x().transpose() * out.matrix * trials.to_x();
  return out;
}

}  // namespace

TEST_CASE("In the unknowns of the valley the expected matrix is 1, weak directions first", "[msa_valley]") {
  for (int number = 1; number <= 4; ++number) {
    const NoisyTrials quiet(number, 1, {});
    const InY e = in_y(quiet, quiet.lane(0), Vector6::Zero());
    CHECK((e.matrix - Matrix6::Identity()).cwiseAbs().maxCoeff() < 1e-10);
    CHECK(e.gradient.cwiseAbs().maxCoeff() < 1e-10);
    const Vector6 sizes = quiet.to_x().colwise().norm();
    for (int i = 0; i < 5; ++i) CHECK(sizes[i] > sizes[i + 1]);
    CHECK((quiet.to_x().rightCols<4>() * quiet.to_x().rightCols<4>().transpose() -
           Eigen::Map<const Matrix6>(quiet.valley.across.data()))
              .cwiseAbs()
              .maxCoeff() < 1e-12);
  }
}

TEST_CASE("The valley's sums are gradient and weak matrix of a trial, to second order in its noise", "[msa_valley]") {
  for (const int number : {1, 2})
    for (const sensor::ReferenceNoise reference :
         {sensor::ReferenceNoise::per_run, sensor::ReferenceNoise::per_station}) {
      // Noise a ten-thousandth of the usual: what is of second order is then below 1e-4 of what is of first order.
      const NoisyTrials trials(number, 8, msa_noise(1e-4, reference, 2e-7));
      for (int t = 0; t < 8; ++t) {
        const InY e = in_y(trials, trials.lane(t), Vector6::Zero());
        const auto s = msa_valley_sums<double>(trials.lane(t), true, trials.valley);
        const double size = e.gradient.norm();
        for (int i = 0; i < 6; ++i) CHECK(std::abs(s[static_cast<std::size_t>(i)] - e.gradient[i]) < 1e-3 * size);
        const double weak[3] = {e.matrix(0, 0) - 1, e.matrix(1, 0), e.matrix(1, 1) - 1};
        double largest = 0;
        for (std::size_t i = 0; i < 3; ++i) largest = std::max(largest, std::abs(weak[i]));
        for (std::size_t i = 0; i < 3; ++i) {
          double expected = weak[i];
          for (std::size_t j = 0; j < 4; ++j) expected -= trials.valley.t[j][i] * s[2 + j];
          CHECK(std::abs(s[6 + i] - expected) < 1e-2 * largest);
        }
      }
    }
}

TEST_CASE("The quartic is the expected cost, minimised over the strong unknowns", "[msa_valley]") {
  for (const int number : {1, 2, 3}) {
    const NoisyTrials quiet(number, 1, {});
    const MsaData data = quiet.lane(0);
    const MsaValley& v = quiet.valley;
    // What the cost has beyond w'w / 2
    const auto higher = [&](double a, double b) {
      Vector6 y = Vector6::Zero();
      y[0] = a;
      y[1] = b;
      for (int it = 0; it < 20; ++it) {
        const InY e = in_y(quiet, data, y);
        y.tail<4>() -= e.matrix.bottomRightCorner<4, 4>().inverse() * e.gradient.tail<4>();
      }
      return in_y(quiet, data, y).cost - (a * a + b * b) / 2;
    };
    for (const double direction : {0.0, 0.6, 0.8, 1.2, 1.57, 2.0, 2.8}) {
      const double size = 0.01;  // a hundredth of the largest unknown: terms of the next orders are some 1 % of these
      const double a = size * std::cos(direction) / quiet.to_x().col(0).cwiseAbs().maxCoeff(),
                   b = size * std::sin(direction) / quiet.to_x().col(1).cwiseAbs().maxCoeff();
      const double cubic[4] = {v.cubic[0] * a * a * a / 6, v.cubic[1] * a * a * b / 2, v.cubic[2] * a * b * b / 2,
                               v.cubic[3] * b * b * b / 6};
      const double quartic[5] = {v.quartic[0] * a * a * a * a / 24, v.quartic[1] * a * a * a * b / 6,
                                 v.quartic[2] * a * a * b * b / 4, v.quartic[3] * a * b * b * b / 6,
                                 v.quartic[4] * b * b * b * b / 24};
      double cubics = 0, largest_cubic = 0, quartics = 0, largest_quartic = 0;
      for (const double x : cubic) cubics += x, largest_cubic = std::max(largest_cubic, std::abs(x));
      for (const double x : quartic) quartics += x, largest_quartic = std::max(largest_quartic, std::abs(x));
      const double odd = (higher(a, b) - higher(-a, -b)) / 2, even = (higher(a, b) + higher(-a, -b)) / 2;
      CAPTURE(number, direction, cubics, largest_cubic, odd, quartics, largest_quartic, even);
      CHECK(std::abs(odd - cubics) < 0.03 * largest_cubic + 1e-7 * (a * a + b * b));
      CHECK(std::abs(even - quartics) < 0.05 * largest_quartic + 1e-7 * (a * a + b * b));
    }
  }
}

TEST_CASE("From the valley and from unit gains: the same minimum in every trial of every test", "[msa_valley][long]") {
  // A last step is at most the tolerance and half of the one before: both ends are within the tolerance.
  const EstimatorOptions options{.max_iterations = 400};
  for (int number = 1; number <= 4; ++number)
    for (const sensor::NoiseModel& n : test::kinds_of_msa_noise()) {
      const NoisyTrials trials(number, number < 3 ? 4000 : 1000, n);
      test::require_same_minima(trials, trials.by_valley(options), trials.solve(options, false),
                                options.step_tolerance);
    }
}

TEST_CASE("Tests 1 and 2 need few evaluations from the valley, and few trials go on", "[msa_valley]") {
  for (const int number : {1, 2}) {
    const NoisyTrials trials(number, 4000, msa_noise(1, sensor::ReferenceNoise::per_run));
    int went_on = 0, at_once = 0;
    double evaluations = 0;
    for (int t = 0; t < trials.block.trials; ++t) {
      const auto s = msa_solve_in_valley<double>(trials.lane(t), false, trials.valley, {200, 1e-6});
      if (s.converged == 0) ++went_on;
      if (s.converged == 0 && s.iterations < 7) ++at_once;  // as soon as a step does not contract
      evaluations += s.iterations / trials.block.trials;
    }
    CAPTURE(number);
    CHECK(at_once > 0.8 * went_on);
    CHECK(went_on < 0.03 * trials.block.trials);  // 1.7 and 0.1 %
    CHECK(evaluations < 4.6);                     // the sums and some three gradients
  }
}

TEST_CASE("Trials that go on from the valley by Newton's method do not depend on the others", "[msa_valley][long]") {
  const EstimatorOptions options;
  const sensor::NoiseModel n = msa_noise(1, sensor::ReferenceNoise::per_run);
  const NoisyTrials trials(1, 2000, n);
  const EstimateBlock all = trials.by_valley(options);
  int went_on = 0;
  for (int t = 0; t < trials.block.trials; ++t) {
    const auto s = msa_solve_in_valley<double>(trials.lane(t), false, trials.valley,
                                               {options.max_iterations, options.step_tolerance});
    if (s.converged == 1) {
      REQUIRE(all.iterations.value(t, 0) == s.iterations);
      continue;
    }
    ++went_on;
    CHECK(all.converged.value(t, 0) == 1);
    CHECK(all.iterations.value(t, 0) > s.iterations);
    const int place = t % simd::kGroup;  // draws begin at a group: the last trial of its part of one
    const EstimateBlock part = NoisyTrials(1, place + 1, n, static_cast<std::uint64_t>(t - place)).by_valley(options);
    for (int i = 0; i < 6; ++i) REQUIRE(all.parameters.value(t, i) == part.parameters.value(place, i));
    REQUIRE(all.cost.value(t, 0) == part.cost.value(place, 0));
    REQUIRE(all.iterations.value(t, 0) == part.iterations.value(place, 0));
  }
  CHECK(went_on > 20);
}

TEST_CASE("From the valley, too, a trial in a lane has the same bits as the trial solved alone", "[msa_valley]") {
  for (const int number : {1, 2, 4})
    for (const sensor::NoiseModel& n :
         {msa_noise(1, sensor::ReferenceNoise::per_run), msa_noise(1, sensor::ReferenceNoise::per_station, 2e-3)}) {
      const NewtonOptions options{200, 1e-8};
      const NoisyTrials trials(number, 80, n);
      const bool noisy_down = n.accelerometer > 0;
      test::require_bits_of_trials_alone(
          80,
          [&]<class T>(int t) { return msa_solve_in_valley<T>(trials.lane(t), noisy_down, trials.valley, options); },
          false);
    }
}

TEST_CASE("The start that costs least is the same at all noise of a good geometry", "[msa_valley]") {
  // From unit gains, the truth here, trials of little noise take fewer evaluations, but each has a matrix.
  test::ThesisCase ideal = test::thesis_case(4);
  ideal.errors = {};
  for (const double scale : {1.0, 0.9, 0.7, 0.5, 0.1, 0.01, 1e-4}) {
    const survey::ReadingBlock block =
        test::simulated(ideal, msa_noise(scale, sensor::ReferenceNoise::none), 64, random::Stream(11, 1));
    EstimateBlock out(64);
    make_cheapest_msa({200, 1e-6}, ideal.field, test::station_fields(ideal), test::clean_readings(ideal).magnetic_T,
                      block)
        ->solve(block, out);
    for (int t = 0; t < 64; ++t) {
      CAPTURE(scale, t);
      CHECK(out.converged.value(t, 0) == 1);
      CHECK(out.iterations.value(t, 0) >= 3);  // from unit gains: 2, and 1 at last
      CHECK(out.iterations.value(t, 0) <= 4);
    }
  }
}

TEST_CASE("The start that costs least is the valley in test 1, and unit gains where nothing is known", "[msa_valley]") {
  const NoisyTrials trials(1, 64, msa_noise());
  const auto require_bits = [&](const auto& truth, const auto& expected, const EstimateBlock& same) {
    EstimateBlock out(64);
    make_cheapest_msa({}, trials.c.field, truth, expected, trials.block)->solve(trials.block, out);
    for (int t = 0; t < 64; ++t) {
      REQUIRE(out.iterations.value(t, 0) == same.iterations.value(t, 0));
      REQUIRE(test::parameters_of(out.parameters, t) == test::parameters_of(same.parameters, t));
    }
  };
  const std::vector<survey::StationFields> truth = sensor::station_fields(trials.clean);
  const EstimatorOptions options{.max_iterations = NewtonOptions{}.max_iterations,
                                 .step_tolerance = NewtonOptions{}.step_tolerance};
  require_bits(truth, trials.clean.magnetic_T, trials.by_valley(options));
  const std::vector fields(truth.size(), truth[0]);
  const std::vector same(truth.size(), trials.clean.magnetic_T[0]);
  require_bits(fields, same, trials.solve(options, false));
}

TEST_CASE("Nonsense, too few iterations and undetermined readings are flagged from the valley, too", "[msa_valley]") {
  NoisyTrials trials(2, 8, msa_noise(1, sensor::ReferenceNoise::per_run));
  test::check_nonsense_is_flagged(trials.block, [&](const EstimatorOptions& o) { return trials.by_valley(o); });

  const std::size_t n = trials.clean.magnetic_T.size();
  const std::vector same(n, trials.clean.magnetic_T[0]);
  const std::vector fields(n, sensor::station_fields(trials.clean)[0]);
  CHECK_FALSE(msa_valley(fields, same, trials.c.field));
  CHECK_FALSE(make_msa_in_valley({}, trials.c.field, fields, same));
}
