#pragma once
/// Noisy trials of the thesis tests, and the minima that ways to solve them must share.
#include <array>
#include <cstdint>
#include <vector>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/estimator.h"
#include "estimate/msa_kernel.h"
#include "sensor/magnetometer.h"
#include "thesis_cases.h"

namespace surveymc::test {

/// The thesis' noise times `scale`.
inline sensor::NoiseModel msa_noise(double scale, sensor::ReferenceNoise reference, double accelerometer = 0) {
  sensor::NoiseModel n;
  n.magnetometer = 70 * scale;
  n.accelerometer = accelerometer;
  n.reference = reference;
  n.reference_total = 107 * scale;
  n.reference_dip = 0.16 * kDegree * scale;
  return n;
}

/// Full and little noise, a reference for each station, noisy accelerometers.
inline std::array<sensor::NoiseModel, 4> kinds_of_msa_noise() {
  using sensor::ReferenceNoise;
  return {msa_noise(1, ReferenceNoise::per_run), msa_noise(0.1, ReferenceNoise::per_run),
          msa_noise(1, ReferenceNoise::per_station), msa_noise(1, ReferenceNoise::per_run, 2e-3)};
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

  ThesisCase c;
  sensor::CleanReadings clean;
  survey::ReadingBlock block;
};

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
