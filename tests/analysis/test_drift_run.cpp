#include "analysis/drift_run.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "base/units.h"

using namespace surveymc;
using namespace surveymc::analysis;

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
