/// `[source]` of drift_monitoring: a simulated gas-lift well or a user's CSV.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include <fmt/format.h>

#include "base/error.h"
#include "drift_monitoring/study.h"

namespace surveymc::studies::drift_monitoring {
namespace {

constexpr std::string_view kTrainHours = "time to train on, from the first sample";

MonitoringData read_gas_lift_well(config::ConfigReader& c) {
  MonitoringData d;
  d.sensors = {"PT_f", "PT_t", "PT_g", "PT_m"};
  d.units.assign(4, "kPa");
  const bool out_of_range = c.boolean("source.out_of_range",
                                      "raise the last of the built-in injection rates out of the trained range; not "
                                      "together with `source.injection_kgps`",
                                      false);
  c.require(!out_of_range || !c.has("source.injection_kgps"), "source.out_of_range",
            "must be left out where source.injection_kgps is given: it changes the last steps of the built-in rates");
  d.schedule = monitoring::gas_lift_schedule(out_of_range);
  d.schedule.step_h = c.number("source.step_h", config::Range{0.5, 100, false, false},
                               "time between changes of the injection rate", d.schedule.step_h);
  d.sample_s = c.number("source.sample_s", config::Range{10, 3600, false, false}, "time between samples", 60);
  c.require(std::fmod(d.sample_s, 5) == 0, "source.sample_s", "must be a multiple of the 5 s of a simulation step");
  d.schedule.rates = c.numbers("source.injection_kgps", config::Range{0.05, 5, false, false},
                               "injection rates, in turn", -1, d.schedule.rates);
  d.rows = monitoring::gas_lift_samples(d.schedule, d.sample_s);
  d.noise_to_signal = c.number("source.noise_to_signal", config::Range{0, 10, false, false},
                               "noise of each gauge, as a part of its sd over all of the test", 0.3);
  return d;
}

std::vector<double> sample_times_h(const MonitoringData& d) {
  std::vector<double> time_h;
  for (Eigen::Index i = 0; i < d.rows; ++i) time_h.push_back(static_cast<double>(i) * d.sample_s / 3600);
  return time_h;
}

std::vector<std::string> sensor_units(config::ConfigReader& c, const std::vector<std::string>& sensors) {
  if (c.has("source.units")) {
    const std::vector<std::string> units = c.texts("source.units",
                                                   "units of the sensors; not needed where the columns' names end in "
                                                   "Pa, kPa, MPa, bar, psi, degC, degF, K, m3ps, m3ph or kgps");
    c.require(units.size() == sensors.size(), "source.units", "must be one unit for each of source.sensors");
    return units;
  }
  std::vector<std::string> units;
  for (const std::string& s : sensors) {
    units.push_back(config::sensor_unit_of_name(s));
    c.require(!units.back().empty(), "source.sensors",
              "the unit of " + s + " is missing: name columns with it (pt_f_kPa) or give source.units");
  }
  return units;
}

MonitoringData read_csv_source(config::ConfigReader& c) {
  MonitoringData d;
  config::SensorCsvOptions options;
  options.time = c.text("source.time", "column of the times");
  options.sensors = d.sensors = c.texts("source.sensors", "columns of the sensors");
  c.require(!d.sensors.empty(), "source.sensors", "must name at least one column");
  options.zero_is_defect = c.boolean("source.zeros_are_bad", "readings of exactly 0 count as bad", true);
  options.gap_factor =
      c.number("source.gap_factor", config::Range{1, 1e6, true, false},
               "a step above so many median steps is a gap; the median is that of the first 65536 steps", 1.5);
  d.units = sensor_units(c, d.sensors);
  d.file = SensorFile{c.file("source.file", "CSV of the readings"), std::move(options), {}};
  return d;
}

constexpr std::size_t kRowsAtATime = 4096;

/// Times are sums of steps, or cells in any unit: a sample that is meant to lie at a time lies there, whatever rounding
/// did.
constexpr double kSameTime_h = 1e-9;

/// Hours since the first monitored sample; that of the start of the drift is exact.
double test_time(double time_h, const Scenario& s) {
  const double t = time_h - s.data.test_start_h;
  return std::abs(t - s.start_h) <= kSameTime_h ? s.start_h : t;
}

/// Calls each(time_h, values) for the good rows of a file until it returns false; the bytes are read to their end.
template <class Each>
void for_rows(const SensorFile& f, Each each) {
  config::SensorCsvReader reader(f.file, f.options);
  const auto p = static_cast<Eigen::Index>(f.options.sensors.size());
  config::SensorBlock block;
  while (reader.next(block, kRowsAtATime))
    for (std::size_t i = 0; i < block.time_h.size(); ++i)
      if (!each(block.time_h[i],
                Eigen::Map<const Eigen::RowVectorXd>(block.values.data() + i * static_cast<std::size_t>(p), p)))
        return reader.skip_to_end();
}

/// Findings on the file, the number of its good rows, how many lie before `train_h`, and the time of the last one.
struct FileSpan {
  Eigen::Index rows = 0, before = 0;
  double end_h = 0;
};
FileSpan scan(SensorFile& f, double train_h) {
  config::SensorCsvReader reader(f.file, f.options);
  FileSpan span;
  config::SensorBlock block;
  while (reader.next(block, kRowsAtATime)) {
    for (const double t : block.time_h) span.before += t < train_h;
    span.rows += static_cast<Eigen::Index>(block.time_h.size());
    span.end_h = block.time_h.back();
  }
  f.found = reader.found();
  return span;
}

/// The row with the largest (sign 1) or smallest (-1) value of a sensor, the first of equals.
struct Extreme {
  Eigen::Index sensor;
  double sign;
  Eigen::Index row = -1;
  Eigen::RowVectorXd values = {};

  template <class Values>
  void offer(Eigen::Index number, const Values& x) {
    if (row >= 0 && sign * x[sensor] <= sign * values[sensor]) return;
    row = number;
    values = x;
  }
};

/// `most` rows to train on, or all: every so many-th of the first `train`, and those that hold the largest and the
/// smallest value of a sensor, which the memory needs. Also finds the time of the first monitored row.
void read_training(MonitoringData& d, Eigen::Index most) {
  const auto p = static_cast<Eigen::Index>(d.sensors.size());
  d.thinned = std::max<Eigen::Index>(1, (d.train + most - 1) / most);
  std::vector<Extreme> extremes;
  for (Eigen::Index j = 0; j < p && d.thinned > 1; ++j) {
    extremes.push_back({j, 1});
    extremes.push_back({j, -1});
  }
  std::map<Eigen::Index, Eigen::RowVectorXd> kept;  // by row number
  Eigen::Index row = 0;
  for_rows(*d.file, [&](double time_h, const Eigen::Map<const Eigen::RowVectorXd>& x) {
    if (row == d.train) {
      d.test_start_h = time_h;
      return false;
    }
    if (row % d.thinned == 0) kept.emplace_hint(kept.end(), row, x);
    for (Extreme& e : extremes) e.offer(row, x);
    ++row;
    return true;
  });
  for (const Extreme& e : extremes) kept.emplace(e.row, e.values);
  d.training.resize(static_cast<Eigen::Index>(kept.size()), p);
  Eigen::Index out = 0;
  for (const auto& [number, x] : kept) d.training.row(out++) = x;
}

/// That source.train_h leaves samples to train on, and to monitor until `end_h`.
void require_samples(const config::ConfigReader& c, const MonitoringData& d, bool has_model, double end_h) {
  c.require(d.tested() >= 2, "source.train_h", fmt::format("must leave samples to monitor: there are {:g} h", end_h));
  c.require(has_model || d.train >= 2, "source.train_h", "must leave at least two samples to train on");
}

/// `[source] train_fraction` or `train_h`, and what follows from it.
void divide_file(config::ConfigReader& c, MonitoringData& d, bool has_model) {
  SensorFile& f = *d.file;
  const bool by_share = c.has("source.train_fraction");
  double share = 0, train_h = 0;
  if (by_share) {  // of the good rows: files may have gaps of days
    c.require(!c.has("source.train_h"), "source.train_h", "leave it out where source.train_fraction is given");
    share = c.number("source.train_fraction", config::Range::open(0, 1),
                     "share of the good rows to train on, in place of `source.train_h`");
  } else {
    train_h = has_model ? c.number("source.train_h", config::Range::non_negative(), kTrainHours, 0)
                        : c.number("source.train_h", config::Range::positive(), kTrainHours);
  }
  const Eigen::Index most =
      c.integer("source.training_rows", 1000, 100'000'000,
                "rows to train on: of more, every so many-th is taken, and the extremes of each sensor", 200'000);
  // A sample at train_h belongs to the test.
  const FileSpan span = scan(f, train_h - kSameTime_h);
  if (c.choice("source.bad_rows", {"reject", "skip"},
               "'skip': rows with anything wrong, and the gaps over them, are left out and counted",
               "reject") == "reject")
    config::reject_findings(f.found, f.file.path);
  require(span.rows >= 2, "{}: {} good row{} of {}: must be at least two", f.file.path, span.rows,
          span.rows == 1 ? "" : "s", f.found.rows_read);
  d.rows = span.rows;
  d.train = by_share ? static_cast<Eigen::Index>(std::floor(share * static_cast<double>(d.rows))) : span.before;
  if (by_share) {
    c.require(d.train >= 2 && d.tested() >= 2, "source.train_fraction",
              "must leave two samples to train on and to monitor");
  } else {
    require_samples(c, d, has_model, span.end_h);
  }
  read_training(d, most);
  d.test_end_h = span.end_h - d.test_start_h;
}

/// What its samples without noise depend on.
struct Well {
  monitoring::InjectionSchedule schedule;
  double sample_s;
  bool operator==(const Well&) const = default;
};

monitoring::Samples simulate(const Well& w, const std::atomic<bool>*) {
  return 1e-3 * monitoring::simulate_gas_lift({}, w.schedule, w.sample_s, 5);
}

}  // namespace

MonitoringData read_monitoring_data(config::ConfigReader& c, bool has_model) {
  if (c.choice("source.name", {"gas_lift_well", "csv"}, "a simulated gas-lift well, or readings in a CSV") == "csv") {
    MonitoringData d = read_csv_source(c);
    divide_file(c, d, has_model);
    return d;
  }
  MonitoringData d = read_gas_lift_well(c);
  const double train_h = c.number("source.train_h", config::Range::non_negative(), kTrainHours, 90);
  const std::vector<double> time_h = sample_times_h(d);
  // A sample at train_h belongs to the test.
  d.train = std::lower_bound(time_h.begin(), time_h.end(), train_h - kSameTime_h) - time_h.begin();
  require_samples(c, d, has_model, time_h.back());
  d.test_start_h = time_h[static_cast<std::size_t>(d.train)];
  d.test_end_h = time_h.back() - d.test_start_h;
  return d;
}

bool operator==(const ExactSamples& a, const ExactSamples& b) {
  return a.values == b.values || (a.values->rows() == b.values->rows() && a.values->cols() == b.values->cols() &&
                                  std::memcmp(a.values->data(), b.values->data(), a.bytes()) == 0);
}

ExactSamples simulated_samples(const MonitoringData& d, const montecarlo::RunOptions& options) {
  return {shared_work(options.shared, Well{d.schedule, d.sample_s}, simulate,
                      sizeof(double) * 4 * static_cast<std::size_t>(d.rows), options.stop)};
}

void set_samples(MonitoringData& d, const monitoring::Samples& samples) {
  d.time_h = sample_times_h(d);
  d.readings = samples;
  d.noise_sd = d.noise_to_signal * monitoring::population_sd(d.readings);
  d.training = d.readings.topRows(d.train);
}

void for_each_block(const Scenario& s, const monitoring::Samples& simulated,
                    const std::function<void(const ReadingBlock&)>& each) {
  const MonitoringData& d = s.data;
  ReadingBlock block;
  if (d.simulated()) {
    constexpr auto kMost = static_cast<Eigen::Index>(kRowsAtATime);
    for (Eigen::Index i = d.train; i < d.rows; i += kMost) {
      const Eigen::Index n = std::min(kMost, d.rows - i);
      block.test_h.clear();
      for (Eigen::Index k = i; k < i + n; ++k)
        block.test_h.push_back(test_time(d.time_h[static_cast<std::size_t>(k)], s));
      block.readings = simulated.middleRows(i, n);
      block.truth = d.readings.middleRows(i, n);
      each(block);
    }
    return;
  }
  config::SensorCsvReader reader(d.file->file, d.file->options);
  const auto p = s.sensors();
  config::SensorBlock read;
  Eigen::Index row = 0;
  while (reader.next(read, kRowsAtATime)) {
    const auto n = static_cast<Eigen::Index>(read.time_h.size()), skip = std::clamp<Eigen::Index>(d.train - row, 0, n);
    row += n;
    if (skip == n) continue;
    block.test_h.assign(read.time_h.begin() + skip, read.time_h.end());
    for (double& t : block.test_h) t = test_time(t, s);
    block.readings = Eigen::Map<const monitoring::Samples>(read.values.data(), n, p).bottomRows(n - skip);
    each(block);
  }
}

}  // namespace surveymc::studies::drift_monitoring
