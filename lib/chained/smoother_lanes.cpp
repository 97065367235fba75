#include "chained/smoother_lanes.h"

#include "chained/smoother_kernel.h"
#include "chained/station_rows.h"

namespace surveymc::chained::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

void solve_lanes(const LaneBatch& b, std::size_t group, std::size_t lane) {
  const double* readings = b.readings + group * b.readings_stride + lane;
  double* stations = b.stations + group * b.stations_stride + lane;
  double* outcome = b.outcome + group * b.outcome_stride + lane;
  const auto store_station = [&](int k, const StationPoint<T>& at, const StationCovariance<T>& c) {
    store_station_rows<T>(stations, k, at, c);
  };
  const Outcome<T> out =
      b.filter ? filter_lanes<T>(b.model, readings, store_station)
               : smooth_lanes<T>(b.model, readings, reinterpret_cast<StationMemory<T>*>(b.scratch), store_station);
  store(outcome, out.converged);
  store(outcome + kGroup, out.iterations);
  store(outcome + 2 * kGroup, out.cost);
}

}  // namespace

void solve_lane_batch(const LaneBatch& b) {
  static_assert(sizeof(StationMemory<T>) <= kScratch * sizeof(double));
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>)
      solve_lanes(b, group, lane);
}

}  // namespace surveymc::chained::SURVEYMC_ISA
