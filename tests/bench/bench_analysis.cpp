/// What is done once a block of trials, or once a study point.
#include "analysis/msa_prediction.h"
#include "bench_setup.h"
#include "estimate/sensitivity.h"
#include "stats/moments.h"

namespace surveymc::bench {
namespace {

/// Items: trials, of as many quantities as msa_position tallies (13) and as a control variate takes (6, twelve times).
void moments(benchmark::State& state) {
  constexpr int trials = 512;
  const auto quantities = state.range(0);
  // Spare rows as in experiments/study.cpp: without them all columns fall into the same sets of the cache.
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(trials + 8, quantities);
  time_calls(state, trials, [&] { return stats::Moments::of(x.topRows(trials)); });
}
BENCHMARK(moments)->Name("moments_of_512")->Arg(13)->Arg(6);

/// Sensitivity of MSA and covariance of its estimate. Items: stations.
void msa_covariance_of_survey(benchmark::State& state) {
  const Setup s(static_cast<int>(state.range(0)));
  const estimate::NominalTruth truth{sensor::station_fields(s.clean), {1, 1, 1}, {0, 0, 0}, s.field};
  const estimate::InputErrors errors{.magnetometer = 70};
  time_calls(state, s.survey.size(),
             [&] { return estimate::error_covariance(estimate::sensitivity({}, truth), truth.stations, errors); });
}
BENCHMARK(msa_covariance_of_survey)->Name("msa_covariance")->Arg(Setup::kThesis)->Arg(1000);

/// All that msa_position predicts before its first trial: also positions and control variates. Items: stations.
void prediction(benchmark::State& state) {
  const Setup s(static_cast<int>(state.range(0)));
  time_calls(state, s.survey.size(),
             [&] { return analysis::predict_msa(s.survey, s.field, {}, {}, s.noise, s.clean, {}); });
}
BENCHMARK(prediction)->Name("predict_msa")->Arg(Setup::kThesis)->Arg(1000);

}  // namespace
}  // namespace surveymc::bench
