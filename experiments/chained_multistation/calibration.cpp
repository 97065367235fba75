/// Calibration of the study "performance" of `chained_multistation`.
#include <fmt/format.h>

#include "chained_multistation/performance_tables.h"

namespace surveymc::studies::chained_multistation {

PerformanceCalibration::PerformanceCalibration(const Scenario& s) {
  if (!s.calibration.on) return;
  std::vector<compare::Row> names = rows_of(s);
  std::erase_if(names, [](const compare::Row& row) { return !row.calibrated; });
  const auto stations = static_cast<std::size_t>(s.stations());
  const std::array<std::size_t, 3> station{0, stations / 2, stations - 1};
  std::size_t at = 0;
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    if (!is_chained(s.estimators[e])) continue;
    const auto add = [&](const Source& source, double degrees) {
      const compare::Row& row = names[at++];
      if (!s.calibration.wants(row.quantity)) return;
      quantities_.push_back(degrees > 0 ? compare::chi_squared_quantity(row.formulation, row.quantity, degrees)
                                        : compare::normal_quantity(row.formulation, row.quantity, 1));
      sources_.push_back(source);
    };
    for (const std::size_t k : station) {
      for (std::size_t z = 0; z < kTestedStates; ++z) add({e, k, static_cast<int>(z)}, 0);
      add({e, k, kNees}, kTestedStates);
    }
    add({e, 0, kCost}, 3.0 * s.stations());
  }
}

void PerformanceCalibration::add(const std::vector<RunCheck>& checks, std::uint64_t* counts) const {
  for (std::size_t i = 0; i < quantities_.size(); ++i) {
    const Source& from = sources_[i];
    const RunCheck& run = checks[from.estimator];
    if (!run.converged()) continue;
    const StationCheck& station = run.stations[from.station];
    const double x = from.state == kCost   ? run.cost
                     : from.state == kNees ? station.nees
                                           : station.z[static_cast<std::size_t>(from.state)];
    ++counts[i * stats::kPitSlots + quantities_[i].cells.of(x)];
  }
}

}  // namespace surveymc::studies::chained_multistation
