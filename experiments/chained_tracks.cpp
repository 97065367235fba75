#include <cmath>

#include "base/units.h"
#include "chained_performance_tables.h"
#include "config/readings_csv.h"
#include "estimate/chained_newton.h"
#include "estimate/chained_smoother.h"
#include "study/table_writer.h"

namespace surveymc {

Table tracks_table(const ChainedScenario& s, const Stream& stream) {
  static constexpr std::array<const char*, kChainStates> kNames{
      "gravity_mg",         "horizontal_nT",     "down_nT",           "accelerometer_x_mg", "accelerometer_y_mg",
      "accelerometer_z_mg", "magnetometer_x_nT", "magnetometer_y_nT", "magnetometer_z_nT"};
  Table t{"tracks", "first trial: errors of the references and offsets of the sensors, true and estimated (slide 9)"};
  t.columns = {count_column("station", "number of the station, from 1"), number_column("md_m", "m", "measured depth")};
  const auto unit = [](std::size_t i) { return i == 0 || (i >= 3 && i < 6) ? kMilliG : 1.0; };
  for (std::size_t i = 0; i < kChainStates; ++i) {
    const std::string name = kNames[i], u = unit(i) == 1 ? "nT" : "mg";
    t.columns.push_back(number_column("true_" + name, u, "truth"));
    t.columns.push_back(number_column("smoother_" + name, u, "estimate of the smoother, references chained"));
    t.columns.push_back(number_column("smoother_sd_" + name, u, "one standard deviation claimed"));
    t.columns.push_back(number_column("filter_" + name, u, "estimate of the filter, references independent"));
    t.columns.push_back(number_column("filter_sd_" + name, u, "one standard deviation claimed"));
  }
  TableWriter w(std::move(t));
  const ChainedRun run = simulate_chained_run(s.truth, stream, 0);
  const ChainedReadings readings{run.readings, {}};
  const ChainedSolution smoother = solve_chained(s.model(ChainReferences::chained), readings),
                        filter = filter_chained(s.model(ChainReferences::independent), readings);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    w << static_cast<std::int64_t>(k + 1) << s.md[k];
    for (std::size_t i = 0; i < kChainStates; ++i) {
      const auto state = static_cast<Eigen::Index>(i);
      w << run.states[k][i] / unit(i);
      for (const ChainedSolution* x : {&smoother, &filter}) {
        const StationEstimate& e = x->stations[k];
        w << e.chain[state] / unit(i) << std::sqrt(e.covariance(3 + state, 3 + state)) / unit(i);
      }
    }
  }
  return w.take();
}

}  // namespace surveymc
