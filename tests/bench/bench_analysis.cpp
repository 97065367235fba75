/// What is done once a block of trials, or once a study point.
#include "analysis/msa_chain.h"
#include "analysis/msa_prediction.h"
#include "bench_setup.h"
#include "estimate/sensitivity.h"
#include "orders/profile.h"
#include "orders/second.h"
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

/// Positions beyond first order, with a reference that is wrong once a run. Items: one prediction.
void orders_of(benchmark::State& state, bool second, bool profile) {
  const Setup s(static_cast<int>(state.range(0)));
  sensor::NoiseModel noise = s.noise;
  noise.reference = sensor::ReferenceNoise::per_run;
  noise.reference_total = 107;
  noise.reference_dip = 0.16 * kDegree;
  const analysis::MsaChain chain({s.survey, s.field, s.clean, noise, {}}, {});
  orders::ExpansionParts parts;
  parts.squares = second || profile;
  time_calls(state, 1, [&] {
    const orders::Centre centre = orders::centre_of(chain, parts);
    if (profile) return orders::moments_of(orders::profile(chain, centre).mixture);
    return second ? orders::second_order(chain, centre) : orders::first_order(centre);
  });
}
BENCHMARK_CAPTURE(orders_of, first, false, false)->Arg(Setup::kThesis);
BENCHMARK_CAPTURE(orders_of, second, true, false)->Arg(Setup::kThesis);
BENCHMARK_CAPTURE(orders_of, profile, false, true)->Arg(Setup::kThesis);

}  // namespace
}  // namespace surveymc::bench
