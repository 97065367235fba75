#include "drift_monitoring/scenario.h"

#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "compare/trial_plan.h"
#include "config/meanings.h"
#include "random/study_stream.h"
#include "store/result_file.h"

namespace surveymc::studies::drift_monitoring {
namespace {

/// The table `model` of a result as numbers: mean, sd and bandwidth, then the memory; a column a sensor.
config::InputTable load_model(const std::filesystem::path& path) {
  const store::Result result = store::read_result(path);
  config::InputTable in;
  for (const store::Table& t : result.tables) {
    if (t.name != "model") continue;
    for (const store::Column& c : t.columns)
      if (const auto* x = std::get_if<std::vector<double>>(&c.values); x && c.long_name == "sensor") {
        in.names.push_back(c.name + "_" + c.unit);
        in.columns.push_back(*x);
      }
    for (std::size_t i = 0; i < t.rows(); ++i) in.lines.push_back(static_cast<int>(i) + 2);
  }
  if (in.rows() < 4 || in.names.empty()) throw IoError("has no model: it must be a result of drift_monitoring");
  return in;
}

TrainedModel read_model(config::ConfigReader& c, const MonitoringData& d) {
  config::InputTable in = c.table(
      "model.file", "a result whose model is taken, with the same sensors and units, in place of training", load_model);
  const auto p = static_cast<Eigen::Index>(d.sensors.size()), rows = static_cast<Eigen::Index>(in.rows());
  std::string expected, found;
  for (std::size_t j = 0; j < d.sensors.size(); ++j) expected += (j > 0 ? ", " : "") + d.sensors[j] + "_" + d.units[j];
  for (std::size_t j = 0; j < in.names.size(); ++j) found += (j > 0 ? ", " : "") + in.names[j];
  c.require(expected == found, "model.file",
            "was trained on other sensors or units: " + found + ", and the source has " + expected);
  monitoring::Samples all(rows, p);
  for (Eigen::Index j = 0; j < p; ++j)
    for (Eigen::Index i = 0; i < rows; ++i)
      all(i, j) = in.columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
  return {{all.row(0), all.row(1)}, all.bottomRows(rows - 3), all(2, 0)};
}

/// `[model] bandwidth`, or `[model.search] bandwidths, folds, target`.
void read_bandwidth(config::ConfigReader& c, Scenario& s) {
  if (!c.has("model.search")) {
    s.bandwidth = c.number("model.bandwidth", config::Range::positive(),
                           "bandwidth of the kernel, in sd of the training data", 0.2);
    return;
  }
  c.require(!c.has("model.bandwidth"), "model.bandwidth", "leave it out where [model.search] chooses it");
  BandwidthSearch search;
  search.tried = c.grid("model.search.bandwidths", config::Range::positive(),
                        "bandwidths that a grid search tries, in place of `model.bandwidth`");
  search.folds =
      static_cast<int>(c.integer("model.search.folds", 2, 1000, "folds of the search's cross-validation", 5));
  search.truth =
      c.choice("model.search.target", {"measured", "truth"},
               "error that the search makes least: against readings, or against the truth of a simulated well",
               s.data.simulated() ? "truth" : "measured") == "truth";
  c.require(!search.truth || s.data.simulated(), "model.search.target", "the truth is known of a simulated well only");
  s.search = std::move(search);
}

/// What a search depends on, in z; `clean`: without noise, of no rows where it is not known.
struct SearchInput {
  ExactSamples training, clean;
  Eigen::Index memory_vectors;
  std::vector<double> tried;
  int folds;
  bool operator==(const SearchInput&) const = default;
};

std::vector<monitoring::BandwidthScore> search(const SearchInput& in, const std::atomic<bool>*) {
  return monitoring::search_bandwidth(*in.training, *in.clean, in.memory_vectors, in.tried, in.folds);
}

/// Sets the bandwidth to that of the least error.
void choose_bandwidth(Scenario& s, const montecarlo::RunOptions& options) {
  const auto& [tried, folds, truth] = *s.search;
  const monitoring::Samples training = s.data.simulated() ? s.realisation(0).topRows(s.data.train) : s.data.training;
  const monitoring::Scaling scaling = monitoring::fit_scaling(training);
  const auto exact = [](monitoring::Samples x) {
    return ExactSamples{std::make_shared<const monitoring::Samples>(std::move(x))};
  };
  const SearchInput in{exact(scaling.to_z(training)),
                       exact(s.data.simulated() ? scaling.to_z(s.data.training) : monitoring::Samples{}),
                       s.memory_vectors, tried, folds};
  s.searched = *shared_work(options.shared, in, search, in.training.bytes() + in.clean.bytes(), options.stop);
  const bool by_truth = truth;
  const auto best = std::min_element(s.searched.begin(), s.searched.end(), [&](const auto& a, const auto& b) {
    return by_truth ? a.mse_truth < b.mse_truth : a.mse_measured < b.mse_measured;
  });
  s.bandwidth = best->bandwidth;
}

void require_variation(const MonitoringData& d) {
  const Eigen::RowVectorXd sd = monitoring::population_sd(d.training);
  for (std::size_t j = 0; j < d.sensors.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    require(sd[column] > 1e-12 * d.training.col(column).cwiseAbs().maxCoeff(),
            "sensor {}: does not vary in the training data: it cannot be monitored", d.sensors[j]);
  }
}

void read_model_settings(config::ConfigReader& c, Scenario& s) {
  if (s.model) {
    s.bandwidth = s.model->bandwidth;
    s.memory_vectors = s.model->memory.rows();
    return;
  }
  const auto p = static_cast<std::int64_t>(s.sensors());
  s.memory_vectors = c.integer("model.memory_vectors", 2 * p, 1'000'000, "vectors of the memory, at least two a sensor",
                               std::min<std::int64_t>(1350, s.data.training_rows()));
  c.require(s.memory_vectors <= s.data.training_rows(), "model.memory_vectors",
            fmt::format("must be at most the {} training samples{}", s.data.training_rows(),
                        s.data.thinned > 1 ? " that source.training_rows leaves" : ""));
  if (!s.data.simulated()) require_variation(s.data);
  read_bandwidth(c, s);
}

void read_drift(config::ConfigReader& c, Scenario& s) {
  const auto p = s.sensors();
  std::vector<double> pattern(static_cast<std::size_t>(p), 0.0);
  if (s.data.simulated()) pattern = {1, 1, 1, 0};
  pattern = c.numbers("drift.pattern", config::Range::closed(-1, 1),
                      "drift of each sensor at the end of the test, in units of `drift.amplitude_z`; linear from "
                      "`drift.start_h`. Without it [1, 1, 1, 0] for the simulated well, and none for a CSV",
                      static_cast<int>(p), pattern);
  const double amplitude =
      c.number("drift.amplitude_z", config::Range::non_negative(), "size of the drift, in sd of the training data", 5);
  s.amplitude = amplitude * Eigen::Map<const Eigen::RowVectorXd>(pattern.data(), p);
  s.start_h = c.number("drift.start_h", config::Range::non_negative(),
                       "beginning of the drift, from the first monitored sample", 12);
  const double end = s.data.test_end_h;
  c.require(s.start_h < end, "drift.start_h", fmt::format("must be before the end of the test at {:g} h", end));
}

void read_tests(config::ConfigReader& c, Scenario& s) {
  s.sprt.false_alarm = c.number("sprt.false_alarm", config::Range::open(0, 0.5),
                                "false alarms that the SPRT allows a decision (alpha)", s.sprt.false_alarm);
  s.sprt.missed_alarm = c.number("sprt.missed_alarm", config::Range::open(0, 0.5),
                                 "missed alarms that the SPRT allows a decision (beta)", s.sprt.missed_alarm);
  s.sprt.shift = c.number("sprt.shift_z", config::Range::positive(), "shift that the SPRT looks for (M)", s.sprt.shift);
  s.sprt.variance = c.number("sprt.variance_z2", config::Range::positive(), "variance that the SPRT assumes (eq 11)",
                             s.sprt.variance);
  s.filter.process_variance =
      c.number("filter.process_variance_z2", config::Range::positive(),
               "variance of a step of the drift that the filter assumes (V)", s.filter.process_variance);
  s.filter.measurement_variance =
      c.number("filter.measurement_variance_z2", config::Range::positive(),
               "variance of a measurement that the filter assumes (Q)", s.filter.measurement_variance);
  s.filter.gate = c.number("filter.gate", config::Range::non_negative(),
                           "a row with a sensor beyond this many sqrt(Q) is skipped; 0: none is", 0);
}

/// Refuses settings of CUSUM and plain threshold where the point has neither.
void refuse_settings_of_no_baseline(const config::ConfigReader& c, const Scenario& s) {
  if (s.methods.size() > s.architectures.size()) return;
  const bool has_residual = s.architectures.front() == monitoring::Architecture::aakr_sprt;
  const char* rule = has_residual
                         ? "has no effect with baselines.enabled = false: leave it out, or enable the baselines"
                         : "has no effect without \"aakr_sprt\", on whose residual the baselines are: leave it out, or "
                           "take \"aakr_sprt\" into architecture";
  for (const char* key : {"operating.cusum_threshold_z", "operating.threshold_z"}) c.require(!c.has(key), key, rule);
  if (has_residual) return;  // [baselines] is disabled by a word of its own
  for (const char* key : {"baselines.calibration_trials", "baselines.cusum_allowance_z", "baselines.cusum_threshold_z",
                          "baselines.threshold_z", "baselines.enabled"})
    c.require(!c.has(key), key, rule);
}

/// `[baselines]` and `[operating]`: settings of the methods.
void read_settings(config::ConfigReader& c, Scenario& s) {
  refuse_settings_of_no_baseline(c, s);
  s.cusum.allowance = c.number("baselines.cusum_allowance_z", config::Range::non_negative(),
                               "what a CUSUM takes off each residual", s.cusum.allowance);
  if (s.data.simulated()) {
    s.calibration_trials =
        static_cast<std::uint64_t>(c.integer("baselines.calibration_trials", 0, 1'000'000,
                                             "in place of both thresholds, of a simulated well: they are set by so "
                                             "many fault-free realisations, to as many alarms as AAKR-SPRT has",
                                             0));
    const bool given = c.has("baselines.cusum_threshold_z") || c.has("baselines.threshold_z");
    c.require(s.calibration_trials == 0 || !given, "baselines.calibration_trials",
              "leave out cusum_threshold_z and threshold_z where they are calibrated");
  }
  if (s.calibration_trials == 0) {
    s.cusum.threshold =
        c.number("baselines.cusum_threshold_z", config::Range::positive(), "threshold of the CUSUM", s.cusum.threshold);
    s.threshold =
        c.number("baselines.threshold_z", config::Range::positive(), "threshold of a single residual", s.threshold);
  }
  using Test = AlarmMethod::Test;
  for (AlarmMethod& m : s.methods)
    m.setting = m.test == Test::sprt ? s.sprt.shift : m.test == Test::cusum ? s.cusum.threshold : s.threshold;
  const auto add = [&](const char* key, Test test) {
    if (!c.has(key)) return;
    const std::vector<double> settings =
        c.number_or_list(key, config::Range::positive(), "settings of the table `operating`");
    for (const AlarmMethod& m : s.methods)
      for (const double x : settings)
        if (m.test == test) s.operating.push_back({m.name, m.architecture, test, x});
  };
  add("operating.shift_z", Test::sprt);
  add("operating.cusum_threshold_z", Test::cusum);
  add("operating.threshold_z", Test::threshold);
}

void read_architectures(config::ConfigReader& c, Scenario& s) {
  const std::vector<std::string> wanted = c.has("architecture")
                                              ? c.texts("architecture", "methods that are compared; without it both")
                                              : std::vector<std::string>{"aakr_sprt", "aakr_kf_sprt"};
  for (const monitoring::Architecture a : {monitoring::Architecture::aakr_sprt, monitoring::Architecture::aakr_kf_sprt})
    if (std::find(wanted.begin(), wanted.end(), monitoring::name(a)) != wanted.end()) {
      s.methods.push_back({monitoring::name(a), s.architectures.size(), AlarmMethod::Test::sprt, 0});
      s.architectures.push_back(a);
    }
  c.require(!wanted.empty() && s.architectures.size() == wanted.size(), "architecture",
            "must be of \"aakr_sprt\", \"aakr_kf_sprt\", each once");
  if (s.architectures.front() == monitoring::Architecture::aakr_sprt &&
      c.boolean(
          "baselines.enabled",
          "compare with CUSUM and a plain threshold on the residual of 'aakr_sprt', which must be among the methods",
          true)) {
    s.methods.push_back({"aakr_cusum", 0, AlarmMethod::Test::cusum, 0});
    s.methods.push_back({"aakr_threshold", 0, AlarmMethod::Test::threshold, 0});
  }
}

PredictionInput without_drift(const Scenario& s) {
  const MonitoringData& d = s.data;
  return {s.seed,           d.schedule,  d.sample_s, d.noise_to_signal, d.rows,      d.train,
          s.memory_vectors, s.bandwidth, s.filter,   s.architectures,   std::nullopt};
}

PredictionInput with_drift(const Scenario& s) {
  PredictionInput input = without_drift(s);
  input.drift = {{s.amplitude.begin(), s.amplitude.end()}, s.start_h, s.data.test_end_h};
  return input;
}

}  // namespace

Eigen::RowVectorXd Scenario::drift(double test_h) const {
  if (!(test_h > start_h)) return Eigen::RowVectorXd::Zero(sensors());
  return amplitude * ((test_h - start_h) / (data.test_end_h - start_h));
}

monitoring::Samples Scenario::realisation(std::uint64_t trial) const {
  const random::Stream stream = random::stream_of(seed);
  monitoring::Samples x = data.readings;
  const auto total = static_cast<std::uint64_t>(x.size());
  for (std::uint64_t call = 0; 4 * call < total; ++call) {
    const auto draws = stream.normals<double>(trial, random::Channel::sensor_noise, call);
    for (std::uint64_t i = 0; i < 4 && 4 * call + i < total; ++i) {
      const auto at = static_cast<Eigen::Index>(4 * call + i);
      x.data()[at] += data.noise_sd[at % x.cols()] * draws[i];
    }
  }
  return x;
}

Scenario with_data(Scenario s, const montecarlo::RunOptions& options) {
  if (s.data.simulated()) {
    set_samples(s.data, *simulated_samples(s.data, options));
    if (!s.model) require_variation(s.data);
  }
  if (s.search) choose_bandwidth(s, options);
  return s;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  const bool has_model = c.has("model.file");
  s.data = read_monitoring_data(c, has_model);
  s.trials = static_cast<std::uint64_t>(
      s.data.simulated()
          ? c.integer("trials", 1, 1'000'000, "realisations of the noise; readings of a CSV have one, whatever it says")
          : c.integer("trials", 0, 1'000'000'000'000, config::kMeaningElsewhere, 1));
  if (!s.data.simulated()) s.trials = 0;  // nothing is drawn: the one pass of a file is in report()
  read_architectures(c, s);
  if (has_model) s.model = read_model(c, s.data);
  read_model_settings(c, s);
  read_drift(c, s);
  read_tests(c, s);
  read_settings(c, s);
  s.series_every = c.integer("series_every", 0, 1'000'000'000, "keep every n-th sample of the series; 0: no series", 1);
  const Eigen::Index most = c.integer("series_rows", 2, 10'000'000,
                                      "most samples a sensor in the series: `series_every` is raised to fit", 60'000);
  if (s.series_every > 0)
    s.series_every = std::max(s.series_every, (s.data.tested() - 1 + most - 2) / (most - 1));  // and the last row
  s.verdict.confidence =
      c.number("verdict.confidence", compare::kConfidences, config::meaning::kConfidence, s.verdict.confidence);
  s.annotations = compare::Annotations::read(c, row_names(s));
  c.finish();
  if (s.data.simulated() && !s.model && !s.search) {
    s.shared_without = SharedPredictions::of(without_drift(s));
    s.shared_with = SharedPredictions::of(with_drift(s));
  }
  return s;
}

}  // namespace surveymc::studies::drift_monitoring
