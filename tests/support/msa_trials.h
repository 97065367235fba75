#pragma once
/// Noisy trials of the thesis tests, the readable cost of MSA, and what estimates and ways to solve must share.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/estimator.h"
#include "estimate/msa_kernel.h"
#include "estimate/msa_residual.h"
#include "estimate/sensitivity.h"
#include "sensor/magnetometer.h"
#include "survey/six_axis.h"
#include "thesis_cases.h"

namespace surveymc::test {

/// The thesis' noise times `scale`.
inline sensor::NoiseModel msa_noise(double scale = 1,
                                    sensor::ReferenceNoise reference = sensor::ReferenceNoise::per_run,
                                    double accelerometer = 0) {
  return {.magnetometer = 70 * scale,
          .accelerometer = accelerometer,
          .reference = reference,
          .reference_total = 107 * scale,
          .reference_dip = 0.16 * kDegree * scale};
}

/// Full and little noise, a reference for each station, noisy accelerometers.
inline std::array<sensor::NoiseModel, 4> kinds_of_msa_noise() {
  using sensor::ReferenceNoise;
  return {msa_noise(1, ReferenceNoise::per_run), msa_noise(0.1, ReferenceNoise::per_run),
          msa_noise(1, ReferenceNoise::per_station), msa_noise(1, ReferenceNoise::per_run, 2e-3)};
}

/// An estimator by its name that assumes these errors.
inline estimate::EstimatorOptions options_of(const std::string& name, const estimate::InputErrors& assumed) {
  return {.name = name, .assumed = assumed};
}

/// Gains and biases (nT) of one trial, of estimates or of drawn tools.
inline estimate::Vector6d parameters_of(const survey::LaneArray& parameters, int trial) {
  estimate::Vector6d x;
  for (int i = 0; i < 6; ++i) x[i] = parameters.value(trial, i);
  return x;
}

/// Gains and biases (nT) are within `gain` and `bias` of the expected ones.
inline void check_parameters(const estimate::Vector6d& found, const estimate::Vector6d& expected, double gain,
                             double bias) {
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(std::abs(found[i] - expected[i]) < (i < 3 ? gain : bias));
  }
}

/// Three rows of one trial from row 3 `station` on, times `unit`, as any scalar type.
template <class T = double>
survey::Vec3<T> triad(const survey::LaneArray& a, int trial, int station, double unit = 1) {
  return {T(a.value(trial, 3 * station) * unit), T(a.value(trial, 3 * station + 1) * unit),
          T(a.value(trial, 3 * station + 2) * unit)};
}

/// One trial of a block as a run of readings, with the reference that its trial was given.
struct NoisyRun {
  survey::SixAxisReadings readings;
  survey::ReferenceField field;
};
inline NoisyRun run_of(const survey::ReadingBlock& block, int trial, const ThesisCase& c) {
  NoisyRun run{{c.survey.md(), {}, {}}, c.field};
  for (int k = 0; k < block.stations; ++k) {
    run.readings.magnetic_T.push_back(triad(block.magnetic, trial, k));
    run.readings.gravity_T.push_back(scale(c.field.gravity, triad(block.down, trial, k)));
  }
  const double bh = block.reference.value(trial, 0), bv = block.reference.value(trial, 1);
  run.field.total = std::hypot(bh, bv);
  run.field.dip = std::atan2(bv, bh);
  return run;
}

struct MsaTrials {
  /// `first`: a multiple of simd::kGroup.
  MsaTrials(int number, int count, const sensor::NoiseModel& n, std::uint64_t seed = 11, std::uint64_t first = 0)
      : c(thesis_case(number)),
        clean(sensor::clean_readings(c.survey, c.field, c.errors)),
        block(sensor::make_reading_block(count, c.survey.size(), n)) {
    sensor::simulate_readings(clean, c.field, n, random::Stream(seed, 1), first, block);
  }
  estimate::MsaData lane(int t) const {
    const int g = t / simd::kGroup, i = t % simd::kGroup;
    return {block.magnetic.row(g, 0) + i, block.down.row(g, 0) + i, block.reference.row(g, 0) + i, block.stations,
            block.reference_stride,       1 / c.field.total};
  }
  estimate::EstimateBlock solve(const estimate::EstimatorOptions& options, bool with_expected) const {
    const std::vector<survey::Vec3<double>> none;
    estimate::EstimateBlock out(block.trials);
    make_estimator(options, c.field, sensor::station_fields(clean), with_expected ? clean.magnetic_T : none)
        ->solve(block, out);
    return out;
  }

  /// The two residuals of one station and trial by the readable model at x = (p, q / total), in units of the total
  /// field, for any scalar type.
  template <class T>
  std::array<T, 2> residual(int trial, int station, const std::array<T, 6>& x) const {
    const double s = 1 / c.field.total;
    const int row = block.reference_stride * station;
    return estimate::msa_residual<T>(triad<T>(block.magnetic, trial, station, s), triad<T>(block.down, trial, station),
                                     T(block.reference.value(trial, row) * s),
                                     T(block.reference.value(trial, row + 1) * s),
                                     {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
  }
  /// Cost of one trial by the readable residual, in units of total^2, for any scalar type.
  template <class T>
  T cost(int trial, const std::array<T, 6>& x) const {
    T sum(0.0);
    for (int k = 0; k < block.stations; ++k) {
      const std::array<T, 2> r = residual(trial, k, x);
      sum = sum + r[0] * r[0] + r[1] * r[1];
    }
    return sum;
  }
  /// The true parameters as the kernels have them: p, q / total.
  std::array<double, 6> truth() const {
    std::array<double, 6> x;
    for (std::size_t i = 0; i < 3; ++i) {
      x[i] = 1 / c.errors.gain[i];
      x[3 + i] = c.errors.bias[i] / c.errors.gain[i] / c.field.total;
    }
    return x;
  }

  ThesisCase c;
  sensor::CleanReadings clean;
  survey::ReadingBlock block;
};

/// solve<T>(trial) is the solution of a trial, or in lanes of those from `trial` on: every lane has the bits of its
/// trial alone. `unconverged_too`: also where there is no solution.
template <class Solve>
void require_bits_of_trials_alone(int trials, const Solve& solve, bool unconverged_too = true) {
  constexpr int lanes = simd::lane_count<simd::Lanes>;
  for (int first = 0; first < trials; first += lanes) {
    const auto batch = solve.template operator()<simd::Lanes>(first);
    for (int i = 0; i < lanes; ++i) {
      const auto alone = solve.template operator()<double>(first + i);
      REQUIRE(simd::lane(batch.iterations, i) == alone.iterations);
      REQUIRE(simd::lane(batch.converged, i) == alone.converged);
      if (alone.converged == 0 && !unconverged_too) continue;
      for (std::size_t a = 0; a < alone.x.size(); ++a) REQUIRE(simd::lane(batch.x[a], i) == alone.x[a]);
      REQUIRE(simd::lane(batch.cost, i) == alone.cost);
    }
  }
}

/// Of 8 trials with one that is nonsense, that one alone has no solution, and none with one iteration. `solve`: of the
/// trials' block with these options.
template <class Solve>
void check_nonsense_is_flagged(survey::ReadingBlock& block, const Solve& solve) {
  estimate::EstimatorOptions options{.max_iterations = 1};
  const estimate::EstimateBlock too_few = solve(options);
  for (int t = 0; t < 8; ++t) CHECK(too_few.converged.value(t, 0) == 0);
  block.magnetic.row(0, 7)[3] = kNaN;
  options.max_iterations = 50;
  const estimate::EstimateBlock out = solve(options);
  for (int t = 0; t < 8; ++t) CHECK(out.converged.value(t, 0) == (t == 3 ? 0 : 1));
}

/// `near` has the minima of `whole`, each found within the tolerance.
inline void require_same_minima(const MsaTrials& trials, const estimate::EstimateBlock& near,
                                const estimate::EstimateBlock& whole, double step_tolerance) {
  for (int t = 0; t < trials.block.trials; ++t) {
    CAPTURE(trials.c.number, t, near.iterations.value(t, 0), whole.iterations.value(t, 0));
    REQUIRE(near.converged.value(t, 0) == whole.converged.value(t, 0));
    for (int i = 0; i < 6; ++i) {
      const double unit = i < 3 ? 1 : trials.c.field.total;
      REQUIRE(std::abs(near.parameters.value(t, i) - whole.parameters.value(t, i)) < 3 * step_tolerance * unit);
    }
    REQUIRE(near.cost.value(t, 0) == Approx(whole.cost.value(t, 0)).epsilon(1e-9));
  }
}

}  // namespace surveymc::test
