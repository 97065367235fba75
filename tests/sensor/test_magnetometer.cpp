#include "sensor/magnetometer.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "msa_trials.h"
#include "stats/moments.h"

using namespace surveymc;
using namespace surveymc::sensor;

TEST_CASE("Clean readings are gain times field plus bias; the first station of tests 3 and 4") {
  // thesis spec, expected numbers, in uT
  const auto first = [](int number) {
    const test::ThesisCase c = test::thesis_case(number);
    return clean_readings(c.survey, c.field, c.errors);
  };
  const CleanReadings three = first(3), four = first(4);
  const double tolerance = 1e-5;  // printed to 1e-8 uT
  for (const auto& [found, expected] :
       {std::pair(three.field_T[0], Eigen::Vector3d(14042.14406, -7154.82976, 48503.88233)),
        {four.field_T[0], Eigen::Vector3d(-15647.41948, 11387.59385, 47185.60130)}})
    for (int i = 0; i < 3; ++i) CHECK(std::abs(survey::to_eigen(found)[i] - expected[i]) < tolerance);
  CHECK(four.magnetic_T[0].z == Approx(1.018 * four.field_T[0].z - 811).epsilon(1e-15));
}

TEST_CASE("Noise laws have their mean and variance") {
  const test::ThesisCase c = test::thesis_case(3);
  const CleanReadings clean = clean_readings(c.survey, c.field, c.errors);
  for (const NoiseLaw law :
       {NoiseLaw::gaussian, NoiseLaw::gaussian_half_open, NoiseLaw::uniform, NoiseLaw::uniform_half_open}) {
    const NoiseModel noise{.law = law, .magnetometer = 70};
    constexpr int trials = 4096;
    const survey::ReadingBlock block = test::simulated(c, noise, trials, random::Stream(3, 1));
    Eigen::MatrixXd x(1, trials * 30);
    for (int t = 0; t < trials; ++t)
      for (int r = 0; r < 30; ++r) {
        const survey::Vec3<double>& m = clean.magnetic_T[static_cast<std::size_t>(r / 3)];
        x(0, t * 30 + r) = block.magnetic.value(t, r) - (r % 3 == 0 ? m.x : r % 3 == 1 ? m.y : m.z);
      }
    const stats::Moments m = stats::Moments::of(x.transpose());
    const double n = static_cast<double>(m.count), sd = 70 * std::sqrt(unit_noise_variance(law));
    CAPTURE(static_cast<int>(law));
    CHECK(std::abs(m.mean[0] - 70 * unit_noise_mean(law)) < 4 * sd / std::sqrt(n));
    CHECK(std::abs(m.variance(0) / (sd * sd) - 1) < 4 * std::sqrt((m.kurtosis(0) - 1) / n));
    if (law == NoiseLaw::uniform) CHECK(x.cwiseAbs().maxCoeff() < 70 * (1 + 1e-9));
    if (law == NoiseLaw::uniform_half_open) CHECK(x.minCoeff() > -1e-9);
  }
}

TEST_CASE("The reference is one draw a run or one a station, and exact without noise") {
  const test::ThesisCase c = test::thesis_case(3);
  NoiseModel noise{.reference_total = 107, .reference_dip = 0.16 * kDegree};
  const auto block_of = [&](ReferenceNoise per) {
    noise.reference = per;
    return test::simulated(c, noise, 16, random::Stream(3, 1));
  };
  const survey::ReadingBlock none = block_of(ReferenceNoise::none), run = block_of(ReferenceNoise::per_run),
                             station = block_of(ReferenceNoise::per_station);
  CHECK(std::abs(none.reference.value(3, 0) - 51000 * std::cos(72 * kDegree)) < 1e-10);
  CHECK(std::abs(none.reference.value(3, 1) - 51000 * std::sin(72 * kDegree)) < 1e-10);
  CHECK(run.reference_stride == 0);
  CHECK(station.reference_stride == 2);
  CHECK(station.reference.value(3, 0) == run.reference.value(3, 0));  // station 0 has the address of the run
  CHECK(station.reference.value(3, 2) != station.reference.value(3, 0));
  // Total and dip come back with the draws of their address.
  const random::Stream stream(3, 1);
  for (int t = 0; t < 16; ++t) {
    const double h = run.reference.value(t, 0), v = run.reference.value(t, 1);
    const auto trial = static_cast<std::uint64_t>(t);
    CHECK(std::abs(std::hypot(h, v) - (51000 + 107 * stream.normal(trial, random::Channel::reference_field, 0))) <
          1e-9);
    CHECK(std::abs(std::atan2(v, h) -
                   (72 + 0.16 * stream.normal(trial, random::Channel::reference_field, 1)) * kDegree) < 1e-14);
  }
}

TEST_CASE("Accelerometer noise tilts the down direction by noise over gravity and keeps it a unit vector") {
  const test::ThesisCase c = test::thesis_case(4);
  NoiseModel noise{.accelerometer = 0.01};
  noise.law = NoiseLaw::uniform_half_open;  // speaks of magnetometers only
  constexpr int trials = 4096;
  const survey::ReadingBlock block = test::simulated(c, noise, trials, random::Stream(3, 1));
  Eigen::MatrixXd tilt(2, trials);
  const survey::Vec3<double> u = survey::down_T(survey::magnetic_attitude(c.survey.stations[0], 0));
  const survey::Vec3<double> across = scale(1 / std::hypot(u.y, u.z), survey::Vec3<double>{0, -u.z, u.y});
  for (int t = 0; t < trials; ++t) {
    const survey::Vec3<double> v = test::triad(block.down, t, 0);
    CHECK(std::abs(norm(v) - 1) < 4e-16);
    tilt(0, t) = dot(v, across);
    tilt(1, t) = dot(v - u, cross(u, across));
  }
  const stats::Moments m = stats::Moments::of(tilt.transpose());
  for (int i = 0; i < 2; ++i) {
    CHECK(std::abs(m.mean[i]) < 4 * (0.01 / 9.80665) / std::sqrt(trials));
    CHECK(std::sqrt(m.variance(i)) / (0.01 / 9.80665) == Approx(1).margin(4 / std::sqrt(2.0 * trials)));
  }
}

TEST_CASE("A trial has the same readings in whatever batch it comes") {
  const test::ThesisCase c = test::thesis_case(2);
  const NoiseModel noise = test::msa_noise(1, ReferenceNoise::per_run, 0.01);
  const survey::ReadingBlock large = test::simulated(c, noise, 64, random::Stream(8, 1), 512),
                             small = test::simulated(c, noise, 8, random::Stream(8, 1), 512 + 40);
  for (int t = 0; t < 8; ++t) {
    for (int r = 0; r < 3 * c.survey.size(); ++r) {
      REQUIRE(small.magnetic.value(t, r) == large.magnetic.value(40 + t, r));
      REQUIRE(small.down.value(t, r) == large.down.value(40 + t, r));
    }
    CHECK(small.reference.value(t, 0) == large.reference.value(40 + t, 0));
  }
}

TEST_CASE("Antithetic trials 2j and 2j + 1 have the draws of trial j and their negatives") {
  const test::ThesisCase c = test::thesis_case(4);
  const CleanReadings clean = clean_readings(c.survey, c.field, c.errors);
  const random::Stream stream(8, 1);
  NoiseWeights weights;
  const auto rows = static_cast<std::size_t>(3 * c.survey.size());
  for (std::size_t i = 0; i < rows * NoiseWeights::kSums; ++i)
    weights.magnetometer.push_back(std::sin(0.1 + double(i)));
  weights.accelerometer = weights.reference = weights.magnetometer;
  constexpr int trials = 32, first = 1024;  // across groups, and not from trial 0
  for (const NoiseLaw law : {NoiseLaw::gaussian, NoiseLaw::uniform})
    for (const ReferenceNoise per : {ReferenceNoise::per_run, ReferenceNoise::per_station}) {
      NoiseModel noise = test::msa_noise(1, per, 0.01);
      noise.law = law;
      const auto simulate = [&](bool antithetic, int begin, int count, survey::LaneArray& sums) {
        noise.antithetic = antithetic;
        survey::ReadingBlock b = make_reading_block(count, c.survey.size(), noise);
        simulate_readings(clean, c.field, noise, stream, static_cast<std::uint64_t>(begin), b, &weights, &sums);
        return b;
      };
      survey::LaneArray pair_sums(survey::groups_for(trials), NoiseWeights::kSums),
          own_sums(survey::groups_for(trials), NoiseWeights::kSums);
      const survey::ReadingBlock pairs = simulate(true, first, trials, pair_sums),
                                 own = simulate(false, first / 2, trials / 2, own_sums);
      for (int t = 0; t < trials; ++t) {
        const double sign = t % 2 == 0 ? 1 : -1;
        for (int q = 0; q < NoiseWeights::kSums; ++q)
          REQUIRE(pair_sums.value(t, q) == sign * own_sums.value(t / 2, q));  // to the last bit
        for (int r = 0; r < 3 * c.survey.size(); ++r) {
          const double truth = (&clean.magnetic_T.front().x)[r];
          const double noise_of_own = own.magnetic.value(t / 2, r) - truth;
          REQUIRE(std::abs(pairs.magnetic.value(t, r) - truth - sign * noise_of_own) < 2e-11);  // two roundings of 1e5
          if (law == NoiseLaw::gaussian)
            REQUIRE(std::abs(noise_of_own - 70 * stream.normal(static_cast<std::uint64_t>((first + t) / 2),
                                                               random::Channel::magnetometer_noise,
                                                               static_cast<std::uint32_t>(r))) < 2e-11);
          if (sign > 0) REQUIRE(pairs.down.value(t, r) == own.down.value(t / 2, r));
        }
        const int references = per == ReferenceNoise::per_station ? c.survey.size() : 1;
        for (int k = 0; k < references; ++k) {
          const auto total = [&](const survey::ReadingBlock& b, int trial) {
            return std::hypot(b.reference.value(trial, 2 * k), b.reference.value(trial, 2 * k + 1)) - 51000;
          };
          const auto dip = [&](const survey::ReadingBlock& b, int trial) {
            return std::atan2(b.reference.value(trial, 2 * k + 1), b.reference.value(trial, 2 * k)) - 72 * kDegree;
          };
          REQUIRE(std::abs(total(pairs, t) - sign * total(own, t / 2)) < 1e-9);
          REQUIRE(std::abs(dip(pairs, t) - sign * dip(own, t / 2)) < 1e-14);
        }
        if (sign < 0)  // gravity plus and minus one noise: before normalising, their mean is the clean reading
          for (int k = 0; k < c.survey.size(); ++k) {
            const auto at = static_cast<std::size_t>(k);
            const survey::Vec3<double> u = scale(1 / norm(clean.gravity_T[at]), clean.gravity_T[at]);
            const survey::Vec3<double> plus = test::triad(pairs.down, t - 1, k), minus = test::triad(pairs.down, t, k);
            // Opposite tilts: plus, u and minus lie in one plane.
            CHECK(std::abs(dot(plus, cross(u, minus))) < 1e-15);
          }
      }
    }
}

TEST_CASE("Laws about zero are symmetric, half-open ones are not") {
  CHECK(symmetric(NoiseLaw::gaussian));
  CHECK(symmetric(NoiseLaw::uniform));
  CHECK(!symmetric(NoiseLaw::gaussian_half_open));
  CHECK(!symmetric(NoiseLaw::uniform_half_open));
}
