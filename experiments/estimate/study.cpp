/// Study for real runs: gains and biases from a file of six-axis readings with their covariance, the corrected survey
/// with its covariance, and tests that say how far to trust them. No simulation, no trials.
///
///   readings -> estimator, tests of its residuals (estimate) -> corrected survey and covariance (propagate)
#include <algorithm>
#include <optional>

#include "analysis/estimate_warnings.h"
#include "analysis/msa_prediction.h"
#include "analysis/readings_analysis.h"
#include "analysis/readings_profile.h"
#include "analysis/readings_tests.h"
#include "config/meanings.h"
#include "config/readings_csv.h"
#include "estimate/chained_readings.h"
#include "estimate/multistation_readings.h"
#include "estimate/run_tables.h"
#include "estimate/single_station_readings.h"
#include "scenario/input_remarks.h"
#include "scenario/scenario.h"
#include "study/experiment.h"

namespace surveymc::studies::estimate {
namespace {

struct Scenario {
  std::optional<StationEstimation> by_station;  ///< every station by itself; then noise and estimator are not used
  survey::ReferenceField field;
  survey::SixAxisReadings readings;
  sensor::NoiseModel noise;
  surveymc::estimate::EstimatorOptions estimator;
  analysis::TestLevels levels;
  bool has_trials = false;
  config::ConfigPlace place;  ///< of the file
};

bool solves_by_station(config::ConfigReader& c) {
  std::vector<std::string> known = analysis::readings_estimators();
  known.insert(known.end(), station_estimators().begin(), station_estimators().end());
  known.emplace_back("chained");  // which have readers of their own
  known.emplace_back("multistation");
  const std::string name =
      c.choice("estimator.name", known, "estimator of the readings; all that need no true attitude");
  return std::find(station_estimators().begin(), station_estimators().end(), name) != station_estimators().end();
}

void read_run_estimator(config::ConfigReader& c, Scenario& s) {
  s.noise = scenario::read_noise(c);
  c.require(s.noise.magnetometer > 0, "noise.magnetometer_nT",
            "must be > 0: standard deviations and tests come from it");
  c.require(s.noise.law == sensor::NoiseLaw::gaussian, "noise.law",
            "must be \"gaussian\": intervals and tests are for it");
  s.estimator = scenario::read_estimator(c, analysis::input_errors(s.noise, {}, s.field), s.field,
                                         analysis::readings_estimators());
}

Scenario read_scenario(config::ConfigReader& c) {
  Scenario s;
  s.field = scenario::read_field(c);
  const bool by_station = solves_by_station(c);
  const std::string sign =
      c.choice("accelerometers", {"gravity", "specific_force"}, config::meaning::kAccelerometers, "gravity");
  s.readings = config::readings_from_table(
      scenario::read_readings_table(c),
      {sign == "gravity" ? config::AccelerometerSign::gravity : config::AccelerometerSign::specific_force,
       s.field.gravity, s.field.total, by_station ? 1 : config::kFewestStations});
  scenario::remark_on_readings(c, s.readings, s.field);
  if (by_station)
    s.by_station = read_station_estimation(c);
  else
    read_run_estimator(c, s);
  s.levels.confidence =
      c.number("confidence", config::Range::open(0, 1), config::meaning::kConfidenceOfIntervals, s.levels.confidence);
  if (!s.by_station)
    s.levels.alpha = c.number("tests.alpha", config::Range::open(0, 1),
                              "level of the tests `variance_factor` and `perfect_tool`", s.levels.alpha);
  s.levels.alpha_w = c.number("tests.alpha_w", config::Range::open(0, 1),
                              "level of the test of each residual, both sides: 0.001 is +-3.29", s.levels.alpha_w);
  s.has_trials = c.has("trials");
  if (s.has_trials) c.integer("trials", 0, 1'000'000'000'000, config::meaning::kUnusedTrials);
  s.place = c.place("readings");
  c.finish();
  return s;
}

std::vector<store::Table> estimate_run(const Scenario& s) {
  if (s.by_station) return station_estimate_tables(s.readings, s.field, *s.by_station, s.levels);
  const analysis::ReadingsAnalysis a = analysis::analyse_readings(s.readings, s.field, s.noise, s.estimator);
  const std::vector<analysis::ReadingsTest> tests = analysis::judge_readings(s.readings, a, s.levels);
  const std::optional<analysis::Suspect> examined =
      analysis::examine_suspect(s.readings, s.field, s.noise, s.estimator, a, tests);
  const std::vector<analysis::ProfiledInterval> profiled =
      analysis::profile_readings(s.readings, s.field, s.noise, s.estimator, a, s.levels.confidence);
  std::vector<analysis::Warning> warnings =
      analysis::warnings_of_estimate(s.readings, s.field, s.noise, a, tests, examined, profiled);
  if (s.has_trials) warnings.push_back({"info", "the config's trials are not used: there is one run of readings"});
  return result_tables(s.readings, s.field, a, s.levels, tests, examined, profiled, warnings);
}

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::estimate,
          "Your own six-axis readings: gains and biases, corrected survey, covariance, tests, warnings",
          "multi-station analysis (S. Vis, TU Delft 2019, eqs 16-17), tests after Baarda 1968",
          [](config::ConfigReader& config, random::StudySeed) -> std::unique_ptr<study::PointPlan> {
            const std::string name =
                config.has("estimator.name") ? config.text("estimator.name", config::kMeaningElsewhere) : "";
            if (name == "multistation") return multistation_readings_result(config);
            for (const char* key : {"estimator.parameters", "estimator.robust"})
              config.require(!config.has(key), key, "needs estimator.name = \"multistation\"");
            if (name == "chained") return chained_readings_result(config);
            return std::make_unique<EstimatePlan<Scenario, estimate_run>>(read_scenario(config));
          }};
}

}  // namespace surveymc::studies::estimate
