#include "analysis/drift_run.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "simd/instruction_set.h"

using namespace surveymc;
using namespace surveymc::analysis;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

DriftRunSetup setup() {
  DriftRunSetup s;
  s.seed = {1, random::StudyId::mwd_drift};
  s.field.total = 51000;
  s.field.dip = 72 * kDegree;
  s.inclination_to = 60 * kDegree;
  s.azimuth = 60 * kDegree;
  const double g = 0.2 * kMilliG, b = 20;
  s.noise << g, g, g, b, b, b;
  s.walk = s.noise / 10;
  s.drift_at_td.setZero();
  s.scatter = {0.1 * kMilliG, 30, 0.05 * kDegree};
  s.sprt.shift = 3;
  s.sprt.variance = 1;
  s.sprt.false_alarm = 1e-4;
  s.sprt.missed_alarm = 0.1;
  return s;
}

}  // namespace

TEST_CASE("The bias filter is consistent where the biases walk as it assumes", "[long]") {
  const DriftRunSetup s = setup();
  constexpr int kWells = 300;
  double nis = 0, nees = 0, nees2 = 0;
  for (std::uint64_t t = 0; t < kWells; ++t) {
    const DriftRun run = drift_run(s, t, SensorBias::walk);
    nis += run.nis_mean / kWells;
    nees += run.nees_mean / kWells;
    nees2 += run.nees_mean * run.nees_mean / kWells;
  }
  CHECK(std::abs(nis - 3) < 4 * std::sqrt(6.0 / (kWells * s.stations)));  // chi-squared(3), independent in time
  CHECK(std::abs(nees - 6) < 4 * std::sqrt((nees2 - nees * nees) / kWells));
}

TEST_CASE("A large drift is found after it begins, and the sensor is named") {
  DriftRunSetup s = setup();
  s.drift_at_td[5] = 3000;  // nT
  const DriftRun with = drift_run(s, 0, SensorBias::ramp, true), without = drift_run(s, 0, SensorBias::none, true);
  CHECK(with.filter_alarm > s.from_station);
  CHECK(with.sprt_alarm > s.from_station);
  CHECK(with.named == 5);
  CHECK(with.stations.back().truth[5] == 3000);
  for (int k = 0; k <= s.from_station; ++k)  // the same draws up to where the drift begins
    CHECK(with.stations[static_cast<std::size_t>(k)].channels ==
          without.stations[static_cast<std::size_t>(k)].channels);
  CHECK(drift_run(s, 0, SensorBias::ramp).filter_alarm == with.filter_alarm);
}

namespace {

/// Alarms are equal, and means equal to rounding: 1e-9, as variances lose up to nine digits in the kernel's updates.
void check_alike(const DriftValues& fast, const DriftValues& slow) {
  for (const int v : {DriftResult::sprt, DriftResult::filter, DriftResult::named, DriftResult::sprt_without,
                      DriftResult::filter_without, DriftResult::nis_inside})
    CHECK_THAT(fast[static_cast<std::size_t>(v)], WithinAbs(slow[static_cast<std::size_t>(v)], 1e-12));
  for (const int v : {DriftResult::nis_mean, DriftResult::nees_mean})
    CHECK_THAT(fast[static_cast<std::size_t>(v)], WithinRel(slow[static_cast<std::size_t>(v)], 1e-9));
}

}  // namespace

TEST_CASE("Drifting wells on lanes are those of the readable run") {
  DriftRunSetup odd = setup();  // other sensors, a horizontal part, every number another
  odd.stations = 33;
  odd.from_station = 7;
  odd.inclination_from = 91 * kDegree;
  odd.inclination_to = 3 * kDegree;
  odd.azimuth = 271 * kDegree;
  odd.field.dip = -35 * kDegree;
  odd.noise << 1e-3, 2e-3, 4e-3, 10, 30, 50;
  odd.walk << 3e-4, 1e-4, 2e-4, 4, 2, 1;
  odd.scatter = {2e-3, 70, 0.3 * kDegree};
  odd.alarm_sd = 2;
  odd.sprt.shift = 2;
  int alarms = 0, compared = 0;
  for (DriftRunSetup s : {setup(), odd})
    for (const int sensor : {1, 5}) {
      s.drift_at_td.setZero();
      s.drift_at_td[sensor] = sensor < 3 ? -0.05 : 900;
      const std::vector<DriftValues> fast = drift_values(s, 20, 13);
      REQUIRE(fast.size() == 13);
      for (std::size_t t = 0; t < fast.size(); ++t, ++compared) {
        check_alike(fast[t], drift_values(s, 20 + t));
        alarms += (fast[t][DriftResult::sprt] >= 0) + (fast[t][DriftResult::filter] >= 0);
      }
    }
  CHECK(compared == 52);
  CHECK(alarms > compared);
}

TEST_CASE("Drifting wells on lanes: the same bits for all neighbours and instruction sets") {
  const DriftRunSetup s = setup();
  const std::vector<DriftValues> all = drift_values(s, 0, 24), part = drift_values(s, 5, 11);
  for (std::size_t t = 0; t < part.size(); ++t) CHECK(part[t] == all[5 + t]);
  if (simd::instruction_set() != simd::InstructionSet::v4) return;
  std::vector<double> columns;
  DriftBatch a = drift_batch(s, 8, columns), b = a;
  isa_v3::drift_trials(a);
  isa_v4::drift_trials(b);
  for (std::size_t t = 0; t < simd::kGroup; ++t) {
    CHECK(a.in_range[t] == 1);
    CHECK(b.in_range[t] == 1);
    for (std::size_t v = 0; v < DriftResult::kValues; ++v) CHECK(a.values[v][t] == b.values[v][t]);
  }
}

TEST_CASE("A drift beyond the kernel's range is left to the readable run") {
  DriftRunSetup far = setup();
  far.drift_at_td[4] = 60000;  // nT: turns the field by more than 30 degrees
  DriftRunSetup certain = setup();
  certain.noise *= 1e-7;  // an update leaves little of a variance
  certain.scatter.setZero();
  for (const DriftRunSetup& s : {far, certain}) {
    std::vector<double> columns;
    DriftBatch b = drift_batch(s, 0, columns);
    isa_v3::drift_trials(b);
    for (const double in_range : b.in_range) CHECK(in_range == 0);
    CHECK(drift_values(s, 3, 2)[1] == drift_values(s, 4));
  }
}
