/// Study: drift of an MWD tool's own sensors along a survey. A Kalman filter on six biases with the Jacobian of the
/// channels |g|, |b| and dip, against a plain SPRT on each channel.
///
///   made-up well, toolfaces (a trial) -> readings with noise and a ramp on one sensor -> channels less reference
///   -> SPRT by channel, and bias filter with its own alarm -> who finds it, when, and whom it names
#include "mwd_drift.h"

#include <fmt/format.h>

#include "experiments.h"

namespace surveymc {
namespace {

class MwdDrift final : public StudyPoint {
 public:
  explicit MwdDrift(MwdScenario s) : s_(std::move(s)) {}

  Tally run_block(TrialBlock block) const override {
    Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    for (int i = 0; i < block.count; ++i) {
      const std::uint64_t trial = block.first + static_cast<std::uint64_t>(i);
      const MwdRun with = run_well(s_, trial, SensorBias::ramp), without = run_well(s_, trial, SensorBias::none),
                   walk = run_well(s_, trial, SensorBias::walk);
      for (const int x : {with.sprt_alarm, with.filter_alarm, with.named, without.sprt_alarm, without.filter_alarm})
        tally.samples.push_back(x);
      for (const double x : {walk.nis_mean, walk.nis_inside, walk.nees_mean}) tally.samples.push_back(x);
    }
    return tally;
  }

  PointResult report(const Tally& tally, const RunOptions&) const override {
    const MwdOutcomes o(tally.samples);
    const std::string at = at_confidence(s_.verdict.confidence);
    std::vector<ComparisonRow> rows = mwd_comparison_rows(s_, o), claims = mwd_claim_rows(s_, o);
    s_.annotations.apply("comparison", rows);
    s_.annotations.apply("claims", claims);
    PointResult r;
    r.tables = {mwd_detection_table(s_, o),
                comparison_table("comparison", "alarms, and consistency of the filter against theory" + at, rows,
                                 tally.trials, 0, true),
                comparison_table("claims", "what the filter is held to do" + at, claims, tally.trials, 0, true),
                mwd_alarm_curve_table(s_, o), mwd_series_table(s_)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const MwdRun run = run_well(s_, trial, SensorBias::ramp);
    return fmt::format("well {}: first alarm at station {} (SPRT), {} (filter, which names {}); -1: none\n", trial,
                       run.sprt_alarm, run.filter_alarm,
                       run.named < 0 ? "none" : kMwdSensors[static_cast<std::size_t>(run.named)]);
  }

 private:
  MwdScenario s_;
};

class MwdDriftPlan final : public PointPlan {
 public:
  explicit MwdDriftPlan(MwdScenario s) : s_(std::move(s)) {}
  std::uint64_t trials() const override { return s_.trials; }
  int block_trials() const override { return 64; }
  std::unique_ptr<StudyPoint> prepare(const RunOptions&) const override { return std::make_unique<MwdDrift>(s_); }

 private:
  MwdScenario s_;
};

}  // namespace

Experiment mwd_drift_experiment() {
  return {StudyId::mwd_drift,
          "Drift of a survey tool's own sensors: a Kalman filter on six biases against an SPRT by channel",
          "the idea of AAKR-KF-SPRT, with the reference field as the prediction",
          [](ConfigReader& config, StudySeed seed) -> std::unique_ptr<PointPlan> {
            return std::make_unique<MwdDriftPlan>(read_mwd_scenario(config, seed));
          }};
}

}  // namespace surveymc
