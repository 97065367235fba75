#pragma once
/// Shared by the benchmarks: one core, thesis trajectory 4 (53 stations) or a made-up well of any number of stations,
/// an ideal tool with 70 nT of noise, the reference without error, and batches as the studies make them.
/// The work is that of configs/bench/msa_traj4.toml.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <vector>

#include <benchmark/benchmark.h>

#include "base/units.h"
#include "bench_kernels.h"
#include "estimate/msa.h"
#include "sensor/magnetometer.h"
#include "simd/instruction_set.h"
#include "survey/corrected_position.h"
#include "thesis_cases.h"

namespace surveymc::bench {

inline const Kernels& kernels(simd::InstructionSet set) {
  return set == simd::InstructionSet::v4 ? isa_v4::kernels : isa_v3::kernels;
}
inline const Ceilings& ceilings(simd::InstructionSet set) {
  return set == simd::InstructionSet::v4 ? isa_v4::ceilings : isa_v3::ceilings;
}

/// Registers `f` as name/avx2 and, where the machine has it, name/avx512; with one argument each if some are given.
using Benchmark = void (*)(benchmark::State&, simd::InstructionSet);
inline bool on_both(const std::string& name, Benchmark f, std::initializer_list<int> arguments = {}) {
  for (const simd::InstructionSet set : {simd::InstructionSet::v3, simd::InstructionSet::v4}) {
    if (set == simd::InstructionSet::v4 && simd::instruction_set() != simd::InstructionSet::v4) continue;
    auto* b =
        benchmark::RegisterBenchmark((name + (set == simd::InstructionSet::v4 ? "/avx512" : "/avx2")).c_str(), f, set);
    for (const int a : arguments) b->Arg(a);
  }
  return true;
}

/// Times f(), and keeps its result or what it writes from being left out. `items`: of one call.
template <class F>
void time_calls(benchmark::State& state, std::int64_t items, const F& f) {
  for (auto _ : state) {
    if constexpr (std::is_void_v<decltype(f())>) {
      f();
      benchmark::ClobberMemory();
    } else {
      benchmark::DoNotOptimize(f());
    }
  }
  state.SetItemsProcessed(state.iterations() * items);
}

/// A well of `stations` that builds to 60 deg and turns, 40 m apart, toolfaces all round.
inline survey::Survey synthetic_survey(int stations) {
  survey::Survey s;
  for (int k = 0; k < stations; ++k) {
    const double along = static_cast<double>(k) / stations;
    s.stations.push_back(
        {40.0 * k, 60 * kDegree * along, (30 + 90 * along) * kDegree, std::fmod(137.5 * k, 360) * kDegree});
  }
  return s;
}

struct Setup {
  static constexpr int kThesis = 53;

  survey::ReferenceField field;
  survey::Survey survey;
  std::vector<double> md;
  sensor::NoiseModel noise;
  sensor::CleanReadings clean;
  int trials;  ///< of a batch, by the rule of experiments/study.cpp
  survey::ReadingBlock readings;
  estimate::EstimateBlock estimates;
  survey::LaneArray position, sums;
  sensor::NoiseWeights weights;
  estimate::MsaExpansion expansion;
  estimate::NewtonOptions options{.max_iterations = 50, .step_tolerance = 1e-6};

  explicit Setup(int stations = kThesis)
      : Setup(stations == kThesis ? test::thesis_case(4).survey : synthetic_survey(stations), {},
              {.magnetometer = 70}) {}

  /// A thesis test as published: sensor errors, and a reference with an error.
  static Setup of_test(int number, double noise_scale) {
    const test::ThesisCase c = test::thesis_case(number);
    return {c.survey,
            c.errors,
            {.magnetometer = 70 * noise_scale,
             .reference = sensor::ReferenceNoise::per_run,
             .reference_total = 107 * noise_scale,
             .reference_dip = 0.16 * kDegree * noise_scale}};
  }

  Setup(const survey::Survey& well, const sensor::MagnetometerErrors& errors, const sensor::NoiseModel& noise_model)
      : field(test::thesis_case(4).field),
        survey(well),
        md(survey.md()),
        noise(noise_model),
        clean(sensor::clean_readings(survey, field, errors)),
        trials(std::clamp(65536 / (survey.size() * 24) / simd::kGroup * simd::kGroup, simd::kGroup, 512)),
        readings(sensor::make_reading_block(trials, survey.size(), noise)),
        estimates(trials),
        position(survey::groups_for(trials), 3),
        sums(survey::groups_for(trials), sensor::NoiseWeights::kSums),
        expansion(*estimate::msa_expansion(sensor::station_fields(clean), clean.magnetic_T, field)) {
    weights.magnetometer.assign(static_cast<std::size_t>(3 * survey.size() * sensor::NoiseWeights::kSums), 1e-3);
    isa_v3::kernels.simulate(simulate_batch(0));
    isa_v3::kernels.msa_solve(msa_batch());
  }

  sensor::SimulateBatch simulate_batch(std::uint64_t first, bool with_sums = false) {
    return {.rows = sensor::reading_rows(clean, field, readings),
            .groups = readings.groups(),
            .first_trial = first,
            .noise = noise,
            .stream = random::Stream(1, 1),
            .magnetometer_weights = with_sums ? weights.magnetometer.data() : nullptr,
            .accelerometer_weights = nullptr,
            .reference_weights = nullptr,
            .sums = with_sums ? sums.row(0, 0) : nullptr,
            .sums_stride = with_sums ? sums.group_stride() : 0,
            .mixing = nullptr,
            .mixing_stride = 0,
            .slot_of = nullptr,
            .made = nullptr,
            .made_stride = 0};
  }
  estimate::MsaData msa_data() const {
    return {readings.magnetic.row(0, 0), readings.down.row(0, 0),   readings.reference.row(0, 0),
            readings.stations,           readings.reference_stride, 1 / field.total};
  }
  estimate::MsaBatch msa_batch(bool with_expansion = true) {
    return {.first = msa_data(),
            .magnetic_stride = readings.magnetic.group_stride(),
            .down_stride = readings.down.group_stride(),
            .reference_stride = readings.reference.group_stride(),
            .parameters = estimates.parameters.row(0, 0),
            .cost = estimates.cost.row(0, 0),
            .iterations = estimates.iterations.row(0, 0),
            .converged = estimates.converged.row(0, 0),
            .parameters_stride = estimates.parameters.group_stride(),
            .scalar_stride = estimates.cost.group_stride(),
            .groups = readings.groups(),
            .total = field.total,
            .options = options,
            .expansion = with_expansion ? &expansion : nullptr,
            .valley = nullptr};
  }
  survey::CorrectedPositionBatch position_batch() {
    return {.magnetic = readings.magnetic.row(0, 0),
            .down = readings.down.row(0, 0),
            .parameters = estimates.parameters.row(0, 0),
            .magnetic_stride = readings.magnetic.group_stride(),
            .down_stride = readings.down.group_stride(),
            .parameters_stride = estimates.parameters.group_stride(),
            .position = position.row(0, 0),
            .position_stride = position.group_stride(),
            .md = md.data(),
            .stations = readings.stations,
            .groups = readings.groups(),
            .sin_declination = std::sin(field.declination),
            .cos_declination = std::cos(field.declination)};
  }
};

}  // namespace surveymc::bench
