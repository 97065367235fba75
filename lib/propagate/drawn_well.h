#pragma once
/// Wells drawn from their error models: trials in lanes, all errors through depth, direction and minimum curvature.
///
///   const WellErrors errors = well_errors(survey, tvd, runs, field, latitude);
///   const DrawnWell well = drawn_well(errors, {point_at(survey, md)}, draw_places(errors), true);
///   survey::LaneArray out(groups, well.rows());
///   well.draw(stream, first_trial, false, groups, out);      // out.value(trial, 3 point + axis)
#include <cstdint>
#include <vector>

#include "propagate/drawn_well_lanes.h"
#include "propagate/mixed_errors.h"
#include "propagate/well_errors.h"
#include "random/stream.h"
#include "survey/readings.h"

namespace surveymc::propagate {

/// The places of the draws of a well alone: number i of those of several stations at index i of Channel::error_source,
/// number i of the others at index i of Channel::station_error. `first_source` and `first_station` are added to the
/// indices (multiples of four keep draws side by side): for further wells of a trial.
std::vector<DrawPlace> draw_places(const WellErrors& errors, std::uint32_t first_source = 0,
                                   std::uint32_t first_station = 0);

class DrawnWell {
 public:
  /// Rows of an output: 3 i + {N, E, V}, in metres: point i less its true position; with control, further
  /// 3 (points + i) + {N, E, V}: the same to first order.
  int rows() const { return static_cast<int>(points_.size()) * (derivatives_.empty() ? 3 : 6); }
  /// Trials first_trial .. first_trial + 8 groups - 1; first_trial is a multiple of kGroup. Antithetic trials: 2 j and
  /// 2 j + 1 have the draws of the stream's trial j, the second with the opposite sign (random/draw_address.h). Time is
  /// linear in draws and stations; the bits of a trial do not depend on `groups`.
  /// `made`: the draws whose place has the channel kGivenDraws, a row each, in whole fours of rows; signs of antithetic
  /// trials are theirs.
  void draw(const random::Stream& stream, std::uint64_t first_trial, bool antithetic, int groups,
            survey::LaneArray& out, const survey::LaneArray* made = nullptr) const;

  /// The stream's calls of a trial, in the order of make and use.
  const std::vector<DrawCall>& calls() const { return calls_; }
  std::size_t stations() const { return stations_; }
  /// The whole path from given normals: the four of calls()[i] are rows rows[i] .. rows[i] + 3 of `z`. `out`:
  /// kPathRows stations() rows. Positions are relative to the first station. Row slot_rows[i] of
  /// `z` is the normal of the V of slots()[i].
  void draw_path(const survey::LaneArray& z, const std::vector<std::uint32_t>& rows,
                 const std::vector<std::uint32_t>& slot_rows, int groups, survey::LaneArray& out) const;
  const std::vector<random::MixingSlot>& slots() const { return slots_; }

  /// Number of normals that a trial draws, including those that only fill a call.
  std::size_t normals() const { return 4 * calls_.size(); }

  /// Arguments of the kernel (for benchmarks).
  /// `mixing`: rows of draw_mixing() of the well's slots; null where it has none.
  DrawnWellBatch batch(std::uint64_t first_trial, bool antithetic, int groups, survey::LaneArray& out,
                       survey::LaneArray& scratch, const survey::LaneArray* mixing = nullptr) const;
  survey::LaneArray make_scratch() const;

 private:
  friend DrawnWell drawn_well(const WellErrors&, const std::vector<WellPoint>&, const std::vector<DrawPlace>&, bool,
                              const WellMixing&);
  DrawnWell() = default;
  void make_items(const WellErrors& errors, const std::vector<DrawPlace>& places, const WellMixing& mixing);
  void make_points(const WellErrors& errors, bool with_control);

  std::vector<WellPoint> points_;
  std::size_t stations_ = 0;
  std::vector<LegGeometry> legs_;
  std::vector<WeightedRow> items_, combined_items_;
  std::vector<std::uint32_t> item_ends_, combined_ends_;
  std::vector<DrawCall> calls_;
  std::size_t lasting_calls_ = 0, most_rows_ = 0;
  std::vector<DrawnStretch> stretches_;
  std::vector<MixedRow> mixed_;
  std::size_t lasting_mixed_ = 0;
  std::vector<random::MixingSlot> slots_;  ///< those that the rows use
  std::vector<DrawnPoint> drawn_points_;
  std::vector<double> truth_, derivatives_;
};

/// `points`: in the order of their stations. `places`: one a draw of `errors`. `with_control`: also the first-order
/// effect (FirstOrder::minimum_curvature) of the same draws. Draws that have no effect at or before the last point are
/// not made. Only numbers of `errors` are kept. `mixing`: which draws are not normal; the control is of the same draws.
DrawnWell drawn_well(const WellErrors& errors, const std::vector<WellPoint>& points,
                     const std::vector<DrawPlace>& places, bool with_control, const WellMixing& mixing = {});

/// One trial from given draws (standard normal, one for each draw of `errors`): the readable definition, which
/// quadrature uses, too. N, E, V of every point less its true position, m: 3 a point.
std::vector<double> drawn_positions(const WellErrors& errors, const std::vector<WellPoint>& points,
                                    const std::vector<double>& draws);

}  // namespace surveymc::propagate
