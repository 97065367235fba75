/// Multi-station analysis: parts of the solver, the solver, whole trials, and the same minimum by NLopt.
#include "bench_setup.h"

namespace surveymc::bench {
namespace {

/// What a solve sums once. Items: stations of one trial.
void sums(benchmark::State& state, simd::InstructionSet set) {
  const Setup s;
  survey::LaneArray out(1, 6);
  time_calls(state, simd::kGroup * s.survey.size(), [&] { kernels(set).msa_sums(s.msa_data(), out.row(0, 0)); });
}
const bool sums_registered = on_both("msa_reading_sums", sums);

/// One evaluation of the normal equations; the readings stay in the first-level cache, as in a solve.
/// Items: stations of one trial.
template <bool WithMatrix>
void evaluate(benchmark::State& state, simd::InstructionSet set) {
  const Setup s;
  const double x[7] = {1.001, 0.999, 1.002, 1e-4, -2e-4, 1e-3, 1};
  survey::LaneArray once(1, 6), out(1, 28);
  kernels(set).msa_sums(s.msa_data(), once.row(0, 0));
  time_calls(state, simd::kGroup * s.survey.size(),
             [&] { kernels(set).msa_evaluate(s.msa_data(), once.row(0, 0), x, WithMatrix, out.row(0, 0)); });
}
const bool matrix_registered = on_both("msa_evaluation_with_matrix", evaluate<true>);
const bool gradient_registered = on_both("msa_evaluation_gradient_only", evaluate<false>);

/// One gradient of the chord iteration. Items: stations of one trial.
template <bool Series>
void gradient(benchmark::State& state, simd::InstructionSet set) {
  const Setup s;
  const double x[6] = {1.001, 0.999, 1.002, 1e-4, -2e-4, 1e-3};
  survey::LaneArray out(1, 7);
  time_calls(state, simd::kGroup * s.survey.size(),
             [&] { kernels(set).msa_gradient(s.msa_data(), x, Series, out.row(0, 0)); });
}
const bool exact_registered = on_both("msa_gradient_exact", gradient<false>);
const bool series_registered = on_both("msa_gradient_by_series", gradient<true>);

/// What a solve in the valley sums once. Items: stations of one trial.
void valley_sums(benchmark::State& state, simd::InstructionSet set) {
  const Setup s;
  const auto valley = *estimate::msa_valley(sensor::station_fields(s.clean), s.clean.magnetic_T, s.field);
  survey::LaneArray out(1, estimate::MsaValley::kSums);
  time_calls(state, simd::kGroup * s.survey.size(),
             [&] { kernels(set).msa_valley_sums(s.msa_data(), valley, out.row(0, 0)); });
}
const bool valley_sums_registered = on_both("msa_valley_sums", valley_sums);

/// Factor and solution of six equations, one waiting for the other. Items: trials.
void step(benchmark::State& state, simd::InstructionSet set) {
  const Setup s;
  const double x[7] = {1, 1, 1, 0, 0, 0, 0};
  constexpr int count = 100;
  survey::LaneArray once(1, 6), equations(1, 28), out(1, 6);
  kernels(set).msa_sums(s.msa_data(), once.row(0, 0));
  kernels(set).msa_evaluate(s.msa_data(), once.row(0, 0), x, true, equations.row(0, 0));
  time_calls(state, count * ceilings(set).lanes,
             [&] { kernels(set).msa_step(equations.row(0, 0), count, out.row(0, 0)); });
}
const bool step_registered = on_both("msa_factor_and_solve", step);

/// Counters `evaluations` of a trial, and `executed` by its register: as many as the slowest lane needs.
void count_evaluations(benchmark::State& state, const Setup& s, simd::InstructionSet set) {
  double evaluations = 0, executed = 0;
  const int lanes = ceilings(set).lanes;
  for (int first = 0; first < s.trials; first += lanes) {
    double slowest = 0;
    for (int t = first; t < first + lanes; ++t) {
      evaluations += s.estimates.iterations.value(t, 0) / s.trials;
      slowest = std::max(slowest, s.estimates.iterations.value(t, 0));
    }
    executed += slowest * lanes / s.trials;
  }
  state.counters["evaluations"] = evaluations;
  state.counters["executed"] = executed;
}

/// From the expansion point, or from unit gains. Items: trials.
template <bool WithExpansion>
void estimate(benchmark::State& state, simd::InstructionSet set) {
  Setup s;
  time_calls(state, s.trials, [&] { kernels(set).msa_solve(s.msa_batch(WithExpansion)); });
  count_evaluations(state, s, set);
}
const bool estimate_registered = on_both("msa_estimate", estimate<true>);
const bool from_unit_registered = on_both("msa_estimate_from_unit_gains", estimate<false>);

/// Thesis tests 1 and 2 as a study solves them (msa_valley.h): with the published noise, or a tenth of it. With a tenth
/// chord steps do (of test 1 nearly always): the ratio of the two is what the noise costs. Items: trials.
void thesis_trial(benchmark::State& state, int number, double noise_scale, bool with_noise) {
  Setup s = Setup::of_test(number, noise_scale);
  const std::vector<survey::StationFields> truth = sensor::station_fields(s.clean);
  const estimate::NewtonOptions& o = s.options;
  const auto estimator = noise_scale < 1 ? estimate::make_msa(o, s.field, truth, s.clean.magnetic_T)
                                         : estimate::make_msa_in_valley(o, s.field, truth, s.clean.magnetic_T);
  std::uint64_t first = 0;
  time_calls(state, s.trials, [&] {
    if (with_noise) sensor::simulate_readings(s.clean, s.field, s.noise, random::Stream(1, 1), first, s.readings);
    estimator->solve(s.readings, s.estimates);
    first += static_cast<std::uint64_t>(s.trials);
  });
}
BENCHMARK_CAPTURE(thesis_trial, test1_estimate, 1, 1.0, false);
BENCHMARK_CAPTURE(thesis_trial, test1_estimate_short_way, 1, 0.1, false);
BENCHMARK_CAPTURE(thesis_trial, test2_estimate, 2, 1.0, false);
BENCHMARK_CAPTURE(thesis_trial, test2_estimate_short_way, 2, 0.1, false);
BENCHMARK_CAPTURE(thesis_trial, test1_whole, 1, 1.0, true);
BENCHMARK_CAPTURE(thesis_trial, test1_whole_short_way, 1, 0.1, true);
BENCHMARK_CAPTURE(thesis_trial, test2_whole, 2, 1.0, true);
BENCHMARK_CAPTURE(thesis_trial, test2_whole_short_way, 2, 0.1, true);

/// Two steps of the short way, which are too few for any trial; all go on, to two of Newton's evaluations or, without
/// `Near`, begin with these. Items: trials.
template <bool Near>
void trials_that_go_on(benchmark::State& state) {
  Setup s;
  const estimate::NewtonOptions too_few{.max_iterations = 2, .step_tolerance = 1e-12};
  const std::vector<survey::Vec3<double>> none;
  const auto estimator =
      estimate::make_msa(too_few, s.field, sensor::station_fields(s.clean), Near ? s.clean.magnetic_T : none);
  time_calls(state, s.trials, [&] { estimator->solve(s.readings, s.estimates); });
}
BENCHMARK_TEMPLATE(trials_that_go_on, true)->Name("msa_trials_that_go_on");
BENCHMARK_TEMPLATE(trials_that_go_on, false)->Name("msa_trials_that_begin");

/// Noise, estimate, and with `WithPosition` the position after it. Items: trials.
template <bool WithPosition>
void whole_trial(benchmark::State& state, simd::InstructionSet set) {
  Setup s;
  std::uint64_t first = 0;
  time_calls(state, s.trials, [&] {
    kernels(set).simulate(s.simulate_batch(first));
    kernels(set).msa_solve(s.msa_batch());
    if (WithPosition) kernels(set).corrected_positions(s.position_batch());
    first += static_cast<std::uint64_t>(s.trials);
  });
}
const bool trial_registered = on_both("whole_trial", whole_trial<false>);
const bool trial_with_position_registered = on_both("whole_trial_with_position", whole_trial<true>);

/// Noise and estimate against the number of stations. Items: stations of one trial.
void station_scaling(benchmark::State& state, simd::InstructionSet set) {
  Setup s(static_cast<int>(state.range(0)));
  std::uint64_t first = 0;
  time_calls(state, s.trials * s.survey.size(), [&] {
    kernels(set).simulate(s.simulate_batch(first));
    kernels(set).msa_solve(s.msa_batch());
    first += static_cast<std::uint64_t>(s.trials);
  });
  count_evaluations(state, s, set);
}
const bool scaling_registered = on_both("station_scaling", station_scaling, {25, Setup::kThesis, 200, 1000});

/// The other estimators, by the best instruction set there is; the noise is what they assume. Items: trials.
void estimate_by(benchmark::State& state, const char* name) {
  Setup s;
  const estimate::InputErrors assumed{.magnetometer = s.noise.magnetometer, .total = 107, .dip = 0.16 * kDegree};
  const auto estimator =
      estimate::make_estimator({.name = name, .assumed = assumed}, s.field, sensor::station_fields(s.clean));
  time_calls(state, s.trials, [&] { estimator->solve(s.readings, s.estimates); });
}
BENCHMARK_CAPTURE(estimate_by, msa, "msa");
BENCHMARK_CAPTURE(estimate_by, msa_weighted, "msa_weighted");
BENCHMARK_CAPTURE(estimate_by, msa_joint, "msa_joint");
BENCHMARK_CAPTURE(estimate_by, wls, "wls");
BENCHMARK_CAPTURE(estimate_by, wls_consider, "wls_consider");

/// Items: trials. Ends at 1e-9 or better: NLopt's tolerances are fixed in field_fit_nlopt.cpp.
void estimate_nlopt(benchmark::State& state, const char* solver) {
  Setup s;
  const auto estimator = estimate::make_estimator({.solver = solver}, s.field);
  time_calls(state, s.trials, [&] { estimator->solve(s.readings, s.estimates); });
}
BENCHMARK_CAPTURE(estimate_nlopt, lbfgs, "nlopt_lbfgs");
BENCHMARK_CAPTURE(estimate_nlopt, bobyqa, "nlopt_bobyqa");
BENCHMARK_CAPTURE(estimate_nlopt, neldermead, "nlopt_neldermead");

}  // namespace
}  // namespace surveymc::bench
