/// `[source]` of drift_monitoring: a simulated gas-lift well or a user's CSV.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "drift_monitoring_scenario.h"
#include "monitoring/gas_lift_well.h"

namespace surveymc {
namespace {

MonitoringData read_gas_lift_well(ConfigReader& c) {
  MonitoringData d;
  d.simulated = true;
  d.sensors = {"PT_f", "PT_t", "PT_g", "PT_m"};
  d.units.assign(4, "kPa");
  InjectionSchedule schedule = gas_lift_schedule(c.boolean("source.out_of_range", false));
  schedule.step_h = c.number("source.step_h", Range{0.5, 100, false, false}, schedule.step_h);
  const double sample_s = c.number("source.sample_s", Range{10, 3600, false, false}, 60);
  c.require(std::fmod(sample_s, 5) == 0, "source.sample_s", "must be a multiple of the 5 s of a simulation step");
  const std::vector<double> rates =
      c.numbers("source.injection_kgps", Range{0.05, 5, false, false}, -1, schedule.rates);
  schedule.rates = rates;
  d.readings = 1e-3 * simulate_gas_lift({}, schedule, sample_s, 5);
  for (Eigen::Index i = 0; i < d.readings.rows(); ++i) d.time_h.push_back(static_cast<double>(i) * sample_s / 3600);
  d.noise_sd = c.number("source.noise_to_signal", Range{0, 10, false, false}, 0.3) * population_sd(d.readings);
  return d;
}

std::vector<std::string> sensor_units(ConfigReader& c, const std::vector<std::string>& sensors) {
  if (c.has("source.units")) {
    const std::vector<std::string> units = c.texts("source.units");
    c.require(units.size() == sensors.size(), "source.units", "must be one unit for each of source.sensors");
    return units;
  }
  std::vector<std::string> units;
  for (const std::string& s : sensors) {
    units.push_back(sensor_unit_of_name(s));
    c.require(!units.back().empty(), "source.sensors",
              "the unit of " + s + " is missing: name columns with it (pt_f_kPa) or give source.units");
  }
  return units;
}

MonitoringData read_csv_source(ConfigReader& c) {
  MonitoringData d;
  const std::string file = c.text("source.file");
  SensorCsvOptions options;
  options.time = c.text("source.time");
  options.sensors = d.sensors = c.texts("source.sensors");
  c.require(!d.sensors.empty(), "source.sensors", "must name at least one column");
  options.zero_is_defect = c.boolean("source.zeros_are_bad", true);
  options.gap_factor = c.number("source.gap_factor", Range{1, 1e6, true, false}, 1.5);
  d.units = sensor_units(c, d.sensors);
  const bool skip = c.choice("source.bad_rows", {"reject", "skip"}, "reject") == "skip";
  SensorCsv csv = read_sensor_csv(c.file_text("source.file").text, file, options);
  if (!skip) reject_findings(csv, file);
  d.time_h = csv.time_h;
  d.readings = Eigen::Map<const Samples>(csv.values.data(), static_cast<Eigen::Index>(csv.lines.size()),
                                         static_cast<Eigen::Index>(d.sensors.size()));
  d.noise_sd = Eigen::RowVectorXd::Zero(d.readings.cols());
  csv.values.clear();
  d.found = std::move(csv);
  return d;
}

}  // namespace

MonitoringData read_monitoring_data(ConfigReader& c, bool has_model) {
  const bool simulated = c.choice("source.name", {"gas_lift_well", "csv"}) == "gas_lift_well";
  MonitoringData d = simulated ? read_gas_lift_well(c) : read_csv_source(c);
  const double all_h = d.time_h.back();
  if (!simulated && c.has("source.train_fraction")) {  // of the good rows: files may have gaps of days
    c.require(!c.has("source.train_h"), "source.train_h", "leave it out where source.train_fraction is given");
    const double share = c.number("source.train_fraction", Range::open(0, 1));
    d.train = static_cast<Eigen::Index>(std::floor(share * static_cast<double>(d.readings.rows())));
    c.require(d.train >= 2 && d.tested() >= 2, "source.train_fraction",
              "must leave two samples to train on and to monitor");
    return d;
  }
  const double train_h = simulated    ? c.number("source.train_h", Range::non_negative(), 90)
                         : !has_model ? c.number("source.train_h", Range::positive())
                                      : c.number("source.train_h", Range::non_negative(), 0);
  // Times are sums of steps: a sample that is meant to lie at train_h belongs to the test.
  d.train = std::lower_bound(d.time_h.begin(), d.time_h.end(), train_h - 1e-9) - d.time_h.begin();
  c.require(d.tested() >= 2, "source.train_h", fmt::format("must leave samples to monitor: there are {:g} h", all_h));
  c.require(has_model || d.train >= 2, "source.train_h", "must leave at least two samples to train on");
  return d;
}

}  // namespace surveymc
