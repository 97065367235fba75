#pragma once
/// Where the results of a station stand in a batch: rows kStationRows k + ...
#include "chained/smoother_kernel.h"

namespace surveymc::chained {

using namespace simd;
using simd::store;

enum StationRow { kRowNorth = 0, kRowDown = 3, kRowChain = 6, kRowCovariance = 15, kStationRows = 15 + 78 };

/// Doubles that StationMemory<Lanes> needs at most.
inline constexpr std::size_t kScratch = 8 * 108;

template <class T>
void store_station_rows(double* rows, int station, const StationPoint<T>& at, const StationCovariance<T>& c) {
  double* row = rows + static_cast<std::size_t>(kStationRows) * static_cast<std::size_t>(station) * kGroup;
  const auto put = [&](const T& x) {
    store(row, x);
    row += kGroup;
  };
  for (const survey::Vec3<T>* v : {&at.frame.n, &at.frame.d}) {
    put(v->x);
    put(v->y);
    put(v->z);
  }
  for (const T& x : at.c) put(x);
  for (const T& x : c) put(x);
}

}  // namespace surveymc::chained
