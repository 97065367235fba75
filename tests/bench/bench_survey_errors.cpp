/// Position covariances of a surveyed well by the 35 terms of the ISCWSA model Rev 5.10.
#include "bench_setup.h"
#include "config/error_model_file.h"
#include "propagate/iscwsa_covariance.h"
#include "survey/minimum_curvature.h"

namespace surveymc::bench {
namespace {

propagate::ErrorModel rev5() {
  for (const config::InputText& m : config::shipped_error_models())
    if (m.path == "iscwsa_mwd_rev5.10")
      return config::read_error_model(
          config::Config::from_text("experiment = 'b'\nseed = 1\nmodel = 'm'\n", "bench", {}, {{"m", m.text}})
              .reader(0)
              .toml("model"));
  return {};
}

/// Items: stations. With range(1) also by source.
void covariances(benchmark::State& state) {
  const survey::Survey survey = synthetic_survey(static_cast<int>(state.range(0)));
  const std::vector<double> tvd = survey::true_vertical_depths(survey);
  const std::vector<propagate::ToolRun> legs{{1, rev5()}};
  survey::ReferenceField field;
  field.total = 50000;
  field.dip = 72 * kDegree;
  for (auto _ : state)
    benchmark::DoNotOptimize(propagate::position_covariances(survey, tvd, legs, field, state.range(1) != 0));
  count_items(state, survey.size());
}
BENCHMARK(covariances)
    ->Name("iscwsa_covariance")
    ->ArgNames({"stations", "by_source"})
    ->ArgsProduct({{100, 1000, 10000, 100000}, {0}})
    ->Args({1000, 1})
    ->Args({10000, 1});

}  // namespace
}  // namespace surveymc::bench
