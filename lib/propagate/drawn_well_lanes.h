#pragma once
/// The kernel behind DrawnWell, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "propagate/drawn_leg.h"
#include "random/stream.h"
#include "simd/instruction_set.h"

namespace surveymc::propagate {

/// `weight` times a row of draws.
struct WeightedRow {
  std::uint32_t row = 0;
  double weight = 0;
};

/// In place of a channel: draws that the caller has made, `index` being their row.
inline constexpr random::Channel kGivenDraws{0xffff};

/// A call of the stream: indices 4 call .. 4 call + 3 of the channel, for four rows.
struct DrawCall {
  random::Channel channel{};
  std::uint32_t call = 0;
};

/// Sums of a station over its draws.
enum DrawnSum { kDepth, kInclination, kAzimuth, kTilt, kCourseNorth, kCourseEast, kCourseDown, kDrawnSums };

/// A row of draws that is not normal, and the slot of its V (random/mixing_draws.h).
struct MixedRow {
  std::uint32_t row = 0, slot = 0;
};

/// Stations first .. end - 1, whose draws of one station are made together: the calls first_call .. end_call - 1, of
/// which the rows first_mixed .. end_mixed - 1 are not normal.
struct DrawnStretch {
  std::size_t first = 0, end = 0;
  std::size_t first_call = 0, end_call = 0;
  std::size_t first_mixed = 0, end_mixed = 0;
};

/// A point at `share` of the leg that ends at `station`; `derivatives`: of its leg to there, as DrawnWellBatch has
/// them.
struct DrawnPoint {
  std::size_t station = 0;
  double share = 1;
  double derivatives[24] = {};
};

/// Raw view of a well and of a batch of trials; rows are kGroup doubles apart.
struct DrawnWellBatch {
  const LegGeometry* legs;  ///< one a station; that of station 0 is not read
  std::size_t stations;     ///< up to the last point
  const WeightedRow* items;
  const std::uint32_t*
      item_ends;  ///< kDrawnSums stations + 1: those of sum q of station k end at [kDrawnSums k + q + 1]
  const DrawCall* calls;
  std::size_t lasting_calls;           ///< the first calls: of draws of several stations, whose rows stay
  const WeightedRow* combined_items;   ///< rows that are sums of those
  const std::uint32_t* combined_ends;  ///< combined + 1
  std::size_t combined;
  const MixedRow* mixed;
  std::size_t lasting_mixed;  ///< the first ones: of draws of several stations
  const double* mixing;       ///< rows 2 slot and 2 slot + 1: a draw becomes the first times it and the second
  std::size_t mixing_stride;
  const DrawnStretch* stretches;
  std::size_t stretch_count;
  double* rows;  ///< scratch, aligned to 64 bytes: 2 kGroup doubles for each row of draws that is there at one time
  const DrawnPoint* points;  ///< in the order of their stations
  std::size_t point_count;
  const double* truth;        ///< 3 points: N, E, V in metres from the first station
  const double* derivatives;  ///< 24 a leg: by (dD, dI, dA, tau) of the station before, then of its own, N E V each;
                              ///< null: no control
  std::uint64_t first_trial;
  bool antithetic;
  std::size_t groups;
  double*
      positions;  ///< rows 3 point + axis: position less the true one; then 3 (points + point) + axis: to first order
  std::size_t positions_stride;
  /// Given normals instead of the stream's: the four rows of call i begin at row given_rows[i]; null: drawn.
  const double* given;
  std::size_t given_stride;
  const std::uint32_t* given_rows;
  const double* made;  ///< rows of kGivenDraws; null where there are none
  std::size_t made_stride;
  double* path;  ///< if not null: rows kPathRows k of station k
  std::size_t path_stride;
};

/// Of a station of a drawn path: its place from the first station (N, E, V), the tangent there, and the length of the
/// leg that ends there; m.
inline constexpr std::size_t kPathRows = 7;

SURVEYMC_KERNEL(void draw_wells(const DrawnWellBatch& batch, const random::Stream& stream));

}  // namespace surveymc::propagate
