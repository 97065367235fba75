/// Position covariances of a surveyed well by error models, the formulas of these models, and wells drawn from them.
#include "bench_setup.h"
#include "error_model/model_graph.h"
#include "propagate/drawn_well.h"
#include "propagate/tool_covariance.h"
#include "proximity/pair_scan.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

namespace surveymc::bench {
namespace {

using test::shipped;

/// Items: stations. With range(1) also by source.
void covariances(benchmark::State& state, const char* model) {
  const survey::Survey survey = synthetic_survey(static_cast<int>(state.range(0)));
  const std::vector<double> tvd = survey::true_vertical_depths(survey);
  const std::vector<propagate::ToolRun> runs{{1, shipped(model)}};
  const survey::ReferenceField field = test::field_of(50000, 72);
  const propagate::SourceDetail detail =
      state.range(1) != 0 ? propagate::SourceDetail::all : propagate::SourceDetail::none;
  time_calls(state, survey.size(),
             [&] { return propagate::tool_covariances(survey, tvd, runs, field, 60 * kDegree, detail); });
}
BENCHMARK_CAPTURE(covariances, iscwsa, "iscwsa_mwd_rev5.10")
    ->Name("iscwsa_covariance")
    ->ArgNames({"stations", "by_source"})
    ->ArgsProduct({{100, 1000, 10000, 100000}, {0}})
    ->Args({1000, 1})
    ->Args({10000, 1});
BENCHMARK_CAPTURE(covariances, axial, "MWD+SRGM+AX")->ArgNames({"stations", "by_source"})->Args({10000, 0});
BENCHMARK_CAPTURE(covariances, gyro, "GYRO-NS-CT")->ArgNames({"stations", "by_source"})->Args({10000, 0});

/// The formulas of a model at 10,000 stations, without the sums. Items: stations.
void formulas(benchmark::State& state, const char* name) {
  const config::SharedModel model = shipped(name);
  const error_model::ModelGraph g = error_model::model_graph(model->terms);
  error_model::Evaluation e(g.graph, error_model::surroundings_of(model->parameters, 72 * kDegree, 50000, 9.8, 1));
  for (std::size_t i = 0; i < error_model::Evaluation::kBlock; ++i)
    error_model::set_station(
        e, i, {.inclination = 0.005 * static_cast<double>(i + 1), .azimuth = 1 + 0.01 * static_cast<double>(i)});
  constexpr int kStations = 10000;
  time_calls(state, kStations, [&] {
    for (int done = 0; done < kStations; done += static_cast<int>(error_model::Evaluation::kBlock)) {
      e.run(error_model::Evaluation::kBlock);
      benchmark::DoNotOptimize(e.output(g.graph.nodes().size() - 1));
    }
  });
}
BENCHMARK_CAPTURE(formulas, iscwsa, "iscwsa_mwd_rev5.10");
BENCHMARK_CAPTURE(formulas, axial, "MWD+SRGM+AX");

constexpr int kDrawnStations = 100;

/// Wells of 100 stations with all 35 sources of Rev 5.10, from draws to positions. Items: wells.
template <bool WithControl>
void drawn_wells(benchmark::State& state, simd::InstructionSet set) {
  const survey::Survey survey = synthetic_survey(kDrawnStations);
  const survey::ReferenceField field = test::field_of(50000, 72);
  const propagate::WellErrors errors = propagate::well_errors(
      survey, survey::true_vertical_depths(survey), {{1, shipped("iscwsa_mwd_rev5.10")}}, field, 60 * kDegree);
  const propagate::DrawnWell well =
      propagate::drawn_well(errors, {{kDrawnStations - 1, 1}}, propagate::draw_places(errors), WithControl);
  constexpr int kGroups = 8;
  survey::LaneArray out(kGroups, well.rows()), scratch = well.make_scratch();
  const random::Stream stream(1, 1);
  std::uint64_t first = 0;
  time_calls(state, kGroups * simd::kGroup, [&] {
    const auto batch = well.batch(first, false, kGroups, out, scratch);
    set == simd::InstructionSet::v4 ? propagate::isa_v4::draw_wells(batch, stream)
                                    : propagate::isa_v3::draw_wells(batch, stream);
    first += kGroups * simd::kGroup;
  });
  state.counters["draws"] = static_cast<double>(errors.draws.size());
}
const bool drawn_registered = on_both("drawn_well", drawn_wells<false>);
const bool controlled_well_registered = on_both("drawn_well_with_control_variate", drawn_wells<true>);

/// The normals of such a well alone. Items: wells.
void drawn_well_normals(benchmark::State& state, simd::InstructionSet set) {
  constexpr std::uint32_t calls =
      180;  // 28 constants and 7 draws of each of 99 stations are 721 normals; the kernel takes tens
  const random::Stream stream(1, 1);
  survey::LaneArray out(1, 4 * calls);
  time_calls(state, simd::kGroup, [&] { kernels(set).normals(stream, calls, out.row(0, 0)); });
}
const bool well_normals_registered = on_both("drawn_well_normals", drawn_well_normals);

/// An offset well held against a reference: path, errors, closest points from the stations of both, and all columns of
/// the table clearance in two formulations. Items: pairs of wells. `least`: least values between stations as well.
void clearance_pairs(benchmark::State& state) {
  const int stations = static_cast<int>(state.range(0));
  const bool with_least = state.range(1) != 0;
  survey::Survey reference = synthetic_survey(stations), offset = reference;
  for (survey::Station& s : offset.stations) s.azimuth += 10 * kDegree;
  const std::vector<double> tvd = survey::true_vertical_depths(reference);
  const std::vector<propagate::ToolRun> runs{{1, shipped("MWD+SRGM")}};
  const survey::ReferenceField field = test::field_of(50000, 70);
  const auto errors_of = [&](const survey::Survey& s) {
    return std::make_shared<const proximity::PositionErrors>(
        proximity::position_errors(s, tvd, runs, field, 1, proximity::Interpolation::covariance));
  };
  const proximity::WellPath reference_path = proximity::well_path(reference, {0, 0, 0});
  const auto reference_errors = errors_of(reference);
  time_calls(state, 1, [&] {
    const proximity::WellPath offset_path = proximity::well_path(offset, {0, 30, 0});
    const auto offset_errors = errors_of(offset);
    const proximity::PairGeometry g{&reference_path, &offset_path, &reference, {}, 0.7, 0};
    std::vector<proximity::PairErrors> formulations;
    for (const proximity::Sharing sharing : {proximity::Sharing::none, proximity::Sharing::geomagnetic}) {
      proximity::PairErrors e{"", reference_errors, offset_errors, {}, true};
      e.common.sources = proximity::shared_sources(sharing, {}, *reference_errors, *offset_errors);
      e.is_independent = e.common.sources.empty();
      formulations.push_back(std::move(e));
    }
    for (const proximity::ScanDirection direction :
         {proximity::ScanDirection::reference, proximity::ScanDirection::offset}) {
      const auto pairs = proximity::scan(g, direction, 0, 1);
      const auto samples = with_least ? proximity::least_samples(g, direction) : pairs;
      for (const proximity::PairErrors& e : formulations) {
        for (const proximity::PairPoints& p : pairs) benchmark::DoNotOptimize(proximity::clearance_of(g, e, p, true));
        if (with_least) benchmark::DoNotOptimize(proximity::least_clearance(g, e, direction, pairs, samples));
      }
    }
  });
}
BENCHMARK(clearance_pairs)->ArgNames({"stations", "least"})->Args({100, 0})->Args({100, 1})->Args({1000, 0});

/// All shipped models, read from their text.
void load_models(benchmark::State& state) {
  time_calls(state, static_cast<std::int64_t>(config::shipped_models().size()), [] {
    for (const config::ShippedModel& m : config::shipped_models())
      benchmark::DoNotOptimize(config::load_shipped_model(m));
  });
}
BENCHMARK(load_models)->Iterations(1);  // the program keeps what it has parsed

}  // namespace
}  // namespace surveymc::bench
