#include <cmath>

#include "base/units.h"
#include "chained_performance_tables.h"
#include "config/readings_csv.h"
#include "estimate/chained_newton.h"
#include "estimate/chained_smoother.h"
#include "study/table_rows.h"

namespace surveymc {

Table tracks_table(const ChainedScenario& s, const Stream& stream) {
  static constexpr std::array<const char*, kChainStates> kNames{
      "gravity_mg",         "horizontal_nT",     "down_nT",           "accelerometer_x_mg", "accelerometer_y_mg",
      "accelerometer_z_mg", "magnetometer_x_nT", "magnetometer_y_nT", "magnetometer_z_nT"};
  TableRows t("tracks",
              "first trial: errors of the references and offsets of the sensors, true and estimated (slide 9)");
  const ChainedRun run = simulate_chained_run(s.truth, stream, 0);
  const ChainedReadings readings{run.readings, {}};
  const ChainedSolution smoother = solve_chained(s.model(ChainReferences::chained), readings),
                        filter = filter_chained(s.model(ChainReferences::independent), readings);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    t.count("station", "number of the station, from 1", k + 1);
    t.number("md_m", "m", "measured depth", s.md[k]);
    for (std::size_t i = 0; i < kChainStates; ++i) {
      const bool milli_g = i == 0 || (i >= 3 && i < 6);
      const double size = milli_g ? kMilliG : 1;
      const std::string name = kNames[i], unit = milli_g ? "mg" : "nT";
      const auto state = static_cast<Eigen::Index>(i);
      const auto sd = [&](const StationEstimate& e) { return std::sqrt(e.covariance(3 + state, 3 + state)) / size; };
      const StationEstimate &smoothed = smoother.stations[k], &filtered = filter.stations[k];
      t.number("true_" + name, unit, "truth", run.states[k][i] / size);
      t.number("smoother_" + name, unit, "estimate of the smoother, references chained", smoothed.chain[state] / size);
      t.number("smoother_sd_" + name, unit, "one standard deviation claimed", sd(smoothed));
      t.number("filter_" + name, unit, "estimate of the filter, references independent", filtered.chain[state] / size);
      t.number("filter_sd_" + name, unit, "one standard deviation claimed", sd(filtered));
    }
  }
  return t.take();
}

}  // namespace surveymc
