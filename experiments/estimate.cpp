/// What an engineer runs on a real run: gains and biases from a file of six-axis readings, with their covariance, the
/// corrected survey with its own, and whether all of it can be trusted. No simulation, no trials.
///
///   readings -> estimator, tests of its residuals (estimate) -> corrected survey and covariance (propagate)
#include <algorithm>
#include <optional>

#include <fmt/ranges.h>

#include "base/error.h"
#include "config/readings_csv.h"
#include "estimate_chained.h"
#include "estimate_tables.h"
#include "estimate_warnings.h"
#include "experiments.h"
#include "msa_prediction.h"
#include "readings_analysis.h"
#include "readings_tests.h"
#include "single_station_readings.h"
#include "study/scenario.h"

namespace surveymc {
namespace {

struct Scenario {
  std::optional<StationEstimation> by_station;  ///< every station by itself; then noise and estimator are not used
  ReferenceField field;
  SixAxisReadings readings;
  NoiseModel noise;
  EstimatorOptions estimator;
  TestLevels levels;
  bool has_trials = false;
  ConfigPlace place;  ///< of the file
};

bool solves_by_station(ConfigReader& c) {
  std::vector<std::string> known = estimator_names();
  known.insert(known.end(), station_estimators().begin(), station_estimators().end());
  const std::string name = c.choice("estimator.name", known);
  return std::find(station_estimators().begin(), station_estimators().end(), name) != station_estimators().end();
}

void read_run_estimator(ConfigReader& c, Scenario& s) {
  s.noise = read_noise(c);
  c.require(s.noise.magnetometer > 0, "noise.magnetometer_nT",
            "must be > 0: standard deviations and tests come from it");
  c.require(s.noise.law == NoiseLaw::gaussian, "noise.law", "must be \"gaussian\": intervals and tests are for it");
  s.estimator = read_estimator(c, input_errors(s.noise, {}, s.field), s.field);
  const std::vector<std::string>& known = readings_estimators();
  c.require(std::find(known.begin(), known.end(), s.estimator.name) != known.end(), "estimator.name",
            fmt::format("must be one of {}, chained here: others need the true attitude, which readings do not tell",
                        fmt::join(known, ", ")));
}

Scenario read_scenario(ConfigReader& c) {
  Scenario s;
  s.field = read_field(c);
  const std::string sign = c.choice("accelerometers", {"gravity", "specific_force"}, "gravity");
  s.readings = readings_from_table(c.csv("readings"),
                                   {sign == "gravity" ? AccelerometerSign::gravity : AccelerometerSign::specific_force,
                                    s.field.gravity, s.field.total});
  if (solves_by_station(c))
    s.by_station = read_station_estimation(c);
  else
    read_run_estimator(c, s);
  s.levels.confidence = c.number("confidence", Range::open(0, 1), s.levels.confidence);
  if (!s.by_station) s.levels.alpha = c.number("tests.alpha", Range::open(0, 1), s.levels.alpha);
  s.levels.alpha_w = c.number("tests.alpha_w", Range::open(0, 1), s.levels.alpha_w);
  s.has_trials = c.has("trials");
  if (s.has_trials) c.integer("trials", 0, 1'000'000'000'000);
  s.place = c.place("readings");
  c.finish();
  return s;
}

std::vector<Table> estimate_run(const Scenario& s) {
  if (s.by_station) return station_estimate_tables(s.readings, s.field, *s.by_station, s.levels);
  const ReadingsAnalysis a = analyse_readings(s.readings, s.field, s.noise, s.estimator);
  const std::vector<ReadingsTest> tests = judge_readings(s.readings, a, s.levels);
  const std::optional<Suspect> examined = examine_suspect(s.readings, s.field, s.noise, s.estimator, a, tests);
  std::vector<EstimateWarning> warnings = estimate_warnings(s.readings, s.field, s.noise, a, tests, examined);
  if (s.has_trials) warnings.push_back({"info", "the config's trials are not used: there is one run of readings"});
  return estimate_tables(s.readings, s.field, a, s.levels, tests, examined, warnings);
}

class Estimate final : public StudyPoint {
 public:
  explicit Estimate(std::vector<Table> tables) : tables_(std::move(tables)) {}
  PointResult report(const Tally&, const RunOptions&) const override { return {tables_, {}, {}}; }

 private:
  std::vector<Table> tables_;
};

class EstimatePlan final : public PointPlan {
 public:
  explicit EstimatePlan(Scenario scenario) : s_(std::move(scenario)) {}
  std::unique_ptr<StudyPoint> prepare(const RunOptions&) const override {
    try {
      return std::make_unique<Estimate>(estimate_run(s_));
    } catch (const InputError& e) {  // what the readings as a whole do not tell: say which file, in which case
      s_.place.fail(e.what());
    }
  }

 private:
  Scenario s_;
};

}  // namespace

Experiment estimate_experiment() {
  return {StudyId::estimate,
          "Your own six-axis readings: gains and biases, corrected survey, covariance, tests, warnings",
          "multi-station analysis (S. Vis, TU Delft 2019, eqs 16-17), tests after Baarda 1968",
          [](ConfigReader& config, StudySeed) -> std::unique_ptr<PointPlan> {
            if (config.has("estimator.name") && config.text("estimator.name") == "chained")
              return estimate_chained(config);
            return std::make_unique<EstimatePlan>(read_scenario(config));
          }};
}

}  // namespace surveymc
