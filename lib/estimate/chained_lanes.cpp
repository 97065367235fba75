#include "estimate/chained_lanes.h"

#include "estimate/chained_rows.h"
#include "estimate/chained_solve.h"

namespace surveymc::SURVEYMC_ISA {
namespace {

using T = Lanes;

void solve_lanes(const ChainedLaneBatch& b, std::size_t group, std::size_t lane) {
  const double* readings = b.readings + group * b.readings_stride + lane;
  double* stations = b.stations + group * b.stations_stride + lane;
  double* outcome = b.outcome + group * b.outcome_stride + lane;
  const auto store_station = [&](int k, const ChainedStation<T>& at, const StationCovariance<T>& c) {
    store_station_rows<T>(stations, k, at, c);
  };
  const ChainedOutcome<T> out =
      b.filter ? chained_filter<T>(b.model, readings, store_station)
               : chained_smooth<T>(b.model, readings, reinterpret_cast<ChainedMemory<T>*>(b.scratch), store_station);
  store(outcome, out.converged);
  store(outcome + kGroup, out.iterations);
  store(outcome + 2 * kGroup, out.cost);
}

}  // namespace

void chained_batch(const ChainedLaneBatch& b) {
  static_assert(sizeof(ChainedMemory<T>) <= kChainedScratch * sizeof(double));
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>)
      solve_lanes(b, group, lane);
}

}  // namespace surveymc::SURVEYMC_ISA
