/// Study: drift of an MWD tool's own sensors along a survey. A Kalman filter on six biases with the Jacobian of the
/// channels |g|, |b| and dip, against a plain SPRT on each channel.
///
///   made-up well, toolfaces (a trial) -> readings with noise and a ramp on one sensor -> channels less reference
///   -> SPRT by channel, and bias filter with its own alarm -> which method finds the drift, when, and the sensor named
#include "mwd_drift/study.h"

#include <fmt/format.h>

#include "study/experiment.h"

namespace surveymc::studies::mwd_drift {
namespace {

class MwdDrift final : public study::StudyPoint {
 public:
  explicit MwdDrift(Scenario s) : s_(std::move(s)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    for (const analysis::DriftValues& of_trial : analysis::drift_values(s_, block.first, block.count))
      tally.samples.insert(tally.samples.end(), of_trial.begin(), of_trial.end());
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    const Outcomes o(tally.samples);
    const std::string at = compare::at_confidence(s_.verdict.confidence);
    std::vector<compare::ComparisonRow> rows = comparison_rows(s_, o), claims = claim_rows(s_, o);
    s_.annotations.apply("comparison", rows);
    s_.annotations.apply("claims", claims);
    study::PointResult r;
    r.tables = {
        detection_table(s_, o),
        compare::comparison_table("comparison", "alarms, and consistency of the filter against theory" + at, rows,
                                  tally.trials, 0, true),
        compare::comparison_table("claims", "what the filter is held to do" + at, claims, tally.trials, 0, true),
        alarm_curve_table(s_, o), series_table(s_)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const analysis::DriftRun run = analysis::drift_run(s_, trial, analysis::SensorBias::ramp);
    return fmt::format("well {}: first alarm at station {} (SPRT), {} (filter, which names {}); -1: none\n", trial,
                       run.sprt_alarm, run.filter_alarm,
                       run.named < 0 ? "none" : kSensors[static_cast<std::size_t>(run.named)]);
  }

 private:
  Scenario s_;
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::mwd_drift,
          "Drift of a survey tool's own sensors: a Kalman filter on six biases against an SPRT by channel",
          "the idea of AAKR-KF-SPRT, with the reference field as the prediction",
          study::plan_of<study::PlanOfPoint<Scenario, MwdDrift, 64>, read_scenario>};
}

}  // namespace surveymc::studies::mwd_drift
