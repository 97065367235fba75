#include <cmath>

#include "base/units.h"
#include "chained/block_solver.h"
#include "chained/smoother.h"
#include "chained_multistation/performance_tables.h"
#include "compare/table_rows.h"
#include "config/readings_csv.h"

namespace surveymc::studies::chained_multistation {

store::Table tracks_table(const Scenario& s, const random::Stream& stream) {
  static constexpr std::array<const char*, chained::kChainStates> kNames{
      "gravity_mg",         "horizontal_nT",     "down_nT",           "accelerometer_x_mg", "accelerometer_y_mg",
      "accelerometer_z_mg", "magnetometer_x_nT", "magnetometer_y_nT", "magnetometer_z_nT"};
  compare::TableRows t(
      "tracks", "first trial: errors of the references and offsets of the sensors, true and estimated (slide 9)");
  const sensor::ChainedRun run = sensor::simulate_chained_run(s.truth, stream, 0);
  const chained::Readings readings{run.readings, {}};
  const chained::Solution smoother = chained::solve_blocks(s.model(chained::ChainReferences::chained), readings),
                          filter = chained::run_filter(s.model(chained::ChainReferences::independent), readings);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    t.count("station", "number of the station, from 1", k + 1);
    t.number("md_m", "m", "measured depth", s.md[k]);
    for (std::size_t i = 0; i < chained::kChainStates; ++i) {
      const bool milli_g = i == 0 || (i >= 3 && i < 6);
      const double size = milli_g ? kMilliG : 1;
      const std::string name = kNames[i], unit = milli_g ? "mg" : "nT";
      const auto state = static_cast<Eigen::Index>(i);
      const auto sd = [&](const chained::StationEstimate& e) {
        return std::sqrt(e.covariance(3 + state, 3 + state)) / size;
      };
      const chained::StationEstimate &smoothed = smoother.stations[k], &filtered = filter.stations[k];
      t.number("true_" + name, unit, "truth", run.states[k][i] / size);
      t.number("smoother_" + name, unit, "estimate of the smoother, references chained", smoothed.chain[state] / size);
      t.number("smoother_sd_" + name, unit, "one standard deviation claimed", sd(smoothed));
      t.number("filter_" + name, unit, "estimate of the filter, references independent", filtered.chain[state] / size);
      t.number("filter_sd_" + name, unit, "one standard deviation claimed", sd(filtered));
    }
  }
  return t.take();
}

}  // namespace surveymc::studies::chained_multistation
