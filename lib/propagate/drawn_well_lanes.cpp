#include "propagate/drawn_well_lanes.h"

#include <algorithm>

#include "random/draw_address.h"
#include "simd/pack.h"

namespace surveymc::propagate::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
using survey::Vec3;

// Calls side by side, as simulate_readings has them.
constexpr std::size_t kCalls = lane_count<T> == 8 ? 5 : 2;
using Calls = Pack<T, kCalls>;
constexpr std::size_t kLanes = lane_count<T>;

/// P registers of trials side by side: one chain of sums leaves the processor waiting.
template <std::size_t P>
struct Trials {
  Bits<T> trial[P];
  Bits<T> sign;
  const double *given[P], *made[P], *mixing[P];
  double* path[P];
};

/// Calls first .. end - 1 into rows from `row` on.
template <std::size_t P>
void make_draws(const DrawnWellBatch& b, const random::Stream& stream, const Trials<P>& trials, std::size_t first,
                std::size_t end, double* row) {
  constexpr std::size_t kStride = P * kLanes;
  if (b.given != nullptr) {
    for (; first < end; ++first, row += 4 * kStride)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t p = 0; p < P; ++p)
          store(row + i * kStride + p * kLanes, load<T>(trials.given[p] + (b.given_rows[first] + i) * kGroup));
    return;
  }
  while (first < end) {
    const random::Channel channel = b.calls[first].channel;
    if (channel == kGivenDraws) {
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t p = 0; p < P; ++p)
          store(row + i * kStride + p * kLanes, load<T>(trials.made[p] + (4 * b.calls[first].call + i) * kGroup));
      ++first;
      row += 4 * kStride;
      continue;
    }
    // As many of one channel as there are side by side; the last one again where there are fewer.
    std::size_t count = 1;
    while (count < kCalls && first + count < end && b.calls[first + count].channel == channel) ++count;
    const auto calls = Bits<Calls>::each(
        [&](std::size_t j) { return Bits<T>(std::uint64_t{b.calls[first + (j < count ? j : count - 1)].call}); });
    for (std::size_t p = 0; p < P; ++p) {
      const auto z = stream.normals<Calls>(trials.trial[p], channel, calls);
      for (std::size_t j = 0; j < count; ++j)
        for (std::size_t i = 0; i < 4; ++i)
          store(row + (4 * j + i) * kStride + p * kLanes, from_bits(to_bits(z[i].v[j]) ^ trials.sign));
    }
    first += count;
    row += 4 * count * kStride;
  }
}

/// Rows that are not normal: mixed[first .. end - 1].
template <std::size_t P>
void mix_draws(const DrawnWellBatch& b, const Trials<P>& trials, std::size_t first, std::size_t end, double* rows) {
  constexpr std::size_t kStride = P * kLanes;
  for (; first < end; ++first)
    for (std::size_t p = 0; p < P; ++p) {
      double* at = rows + b.mixed[first].row * kStride + p * kLanes;
      const double* v = trials.mixing[p] + 2 * b.mixed[first].slot * kGroup;
      store(at, fma(load<T>(v), load<T>(at), load<T>(v + kGroup)));
    }
}

template <std::size_t P>
[[gnu::always_inline]] inline void weighted_sum(const WeightedRow* from, const WeightedRow* end, const double* rows,
                                                T (&out)[P]) {
  constexpr std::size_t kStride = P * kLanes;
  T odd[P];
  for (std::size_t p = 0; p < P; ++p) out[p] = odd[p] = T(0.0);
  for (; from + 1 < end; from += 2) {
    const double *x = rows + from[0].row * kStride, *y = rows + from[1].row * kStride;
    const T v(from[0].weight), w(from[1].weight);
    for (std::size_t p = 0; p < P; ++p) {
      out[p] = fma(v, load<T>(x + p * kLanes), out[p]);
      odd[p] = fma(w, load<T>(y + p * kLanes), odd[p]);
    }
  }
  if (from < end) {
    const T v(from->weight);
    for (std::size_t p = 0; p < P; ++p) out[p] = fma(v, load<T>(rows + from->row * kStride + p * kLanes), out[p]);
  }
  for (std::size_t p = 0; p < P; ++p) out[p] = out[p] + odd[p];
}

/// One trial's well at the station at hand.
struct Path {
  DrawnErrors<T> errors;
  Vec3<T> tangent, position, linear;
};

[[gnu::always_inline]] inline void add_derivative(const double* d, const DrawnErrors<T>& e, Vec3<T>& r) {
  const T* x[4] = {&e.depth, &e.inclination, &e.azimuth, &e.tilt};
  for (std::size_t i = 0; i < 4; ++i) {
    r.x = fma(T(d[3 * i]), *x[i], r.x);
    r.y = fma(T(d[3 * i + 1]), *x[i], r.y);
    r.z = fma(T(d[3 * i + 2]), *x[i], r.z);
  }
}

[[gnu::always_inline]] inline Vec3<T> add_scaled(double share, const Vec3<T>& a, const Vec3<T>& b) {
  const T s(share);
  return {fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}

void store3(double* row, const Vec3<T>& r) {
  store(row, r.x);
  store(row + kGroup, r.y);
  store(row + 2 * kGroup, r.z);
}

void store_station(double* row, const Vec3<T>& position, const Vec3<T>& tangent, const T& length) {
  store3(row, position);
  store3(row + 3 * kGroup, tangent);
  store(row + 6 * kGroup, length);
}

template <std::size_t P>
void draw_group(const DrawnWellBatch& b, const random::Stream& stream, const Trials<P>& trials,
                double* const (&out)[P]) {
  constexpr std::size_t kStride = P * kLanes;
  double* rows = b.rows;
  make_draws<P>(b, stream, trials, 0, b.lasting_calls, rows);
  mix_draws<P>(b, trials, 0, b.lasting_mixed, rows);
  double* combined = rows + 4 * b.lasting_calls * kStride;
  for (std::size_t c = 0; c < b.combined; ++c, combined += kStride) {
    T sum[P];
    weighted_sum<P>(b.combined_items + b.combined_ends[c], b.combined_items + b.combined_ends[c + 1], rows, sum);
    for (std::size_t p = 0; p < P; ++p) store(combined + p * kLanes, sum[p]);
  }
  Path path[P];
  const T zero(0.0);
  const Vec3<T> origin{zero, zero, zero};
  for (Path& x : path) {
    x.errors = {zero, zero, zero, zero};
    x.position = x.linear = origin;
    x.tangent = drawn_tangent(b.legs[1].from, x.errors);
  }
  for (std::size_t p = 0; p < P && b.path != nullptr; ++p) store_station(trials.path[p], origin, path[p].tangent, zero);
  std::size_t point = 0;
  for (std::size_t s = 0; s < b.stretch_count; ++s) {
    const DrawnStretch& stretch = b.stretches[s];
    make_draws<P>(b, stream, trials, stretch.first_call, stretch.end_call, combined);
    mix_draws<P>(b, trials, stretch.first_mixed, stretch.end_mixed, rows);
    for (std::size_t k = stretch.first; k < stretch.end; ++k) {
      const std::uint32_t* ends = b.item_ends + kDrawnSums * k;
      T sums[kDrawnSums][P];
      for (std::size_t q = 0; q < kDrawnSums; ++q)
        weighted_sum<P>(b.items + ends[q], b.items + ends[q + 1], rows, sums[q]);
      const auto has = [&](std::size_t q) { return ends[q] != ends[q + 1]; };
      const DrawnAngles angles{has(kInclination), has(kAzimuth), has(kTilt)};
      const LegGeometry& leg = b.legs[k];
      for (std::size_t p = 0; p < P; ++p) {
        Path& x = path[p];
        const DrawnErrors<T> at{sums[kDepth][p], sums[kInclination][p], sums[kAzimuth][p], sums[kTilt][p]};
        const Vec3<T> course{sums[kCourseNorth][p], sums[kCourseEast][p], sums[kCourseDown][p]};
        const Vec3<T> tangent = drawn_tangent(leg.to, at, angles);
        for (std::size_t i = point; i < b.point_count && b.points[i].station == k; ++i) {
          const DrawnPoint& here = b.points[i];
          const Vec3<T> r =
              x.position + add_scaled(here.share, course,
                                      drawn_leg_between(leg, x.errors.depth, at.depth, x.tangent, tangent, here.share));
          const double* truth = b.truth + 3 * i;
          store3(out[p] + 3 * i * kGroup, r - Vec3<T>{T(truth[0]), T(truth[1]), T(truth[2])});
          if (b.derivatives == nullptr) continue;
          Vec3<T> linear = add_scaled(here.share, course, x.linear);
          add_derivative(here.derivatives, x.errors, linear);
          add_derivative(here.derivatives + 12, at, linear);
          store3(out[p] + 3 * (b.point_count + i) * kGroup, linear);
        }
        x.position = x.position + (course + drawn_leg_between(leg, x.errors.depth, at.depth, x.tangent, tangent, 1));
        if (b.derivatives != nullptr) {
          x.linear = x.linear + course;
          add_derivative(b.derivatives + 24 * k, x.errors, x.linear);
          add_derivative(b.derivatives + 24 * k + 12, at, x.linear);
        }
        if (b.path != nullptr)
          store_station(trials.path[p] + kPathRows * k * kGroup, x.position, tangent,
                        T(leg.length) + (at.depth - x.errors.depth));
        x.errors = at;
        x.tangent = tangent;
      }
      while (point < b.point_count && b.points[point].station == k) ++point;
    }
  }
}

/// P registers from lane `lane` of group `group` on.
template <std::size_t P>
void draw_registers(const DrawnWellBatch& b, const random::Stream& stream, std::size_t group) {
  Trials<P> trials;
  double* out[P];
  for (std::size_t p = 0; p < P; ++p) {
    const std::size_t first = p * kLanes;  // from the group's first trial
    const std::size_t g = group + first / kGroup, lane = first % kGroup;
    const auto from = random::draw_address<T>(consecutive<T>(b.first_trial + g * kGroup + lane), b.antithetic);
    trials.trial[p] = from.trial;
    trials.sign = from.sign;
    trials.given[p] = b.given == nullptr ? nullptr : b.given + g * b.given_stride + lane;
    trials.made[p] = b.made == nullptr ? nullptr : b.made + g * b.made_stride + lane;
    trials.mixing[p] = b.mixing == nullptr ? nullptr : b.mixing + g * b.mixing_stride + lane;
    trials.path[p] = b.path == nullptr ? nullptr : b.path + g * b.path_stride + lane;
    out[p] = b.positions + g * b.positions_stride + lane;
  }
  draw_group<P>(b, stream, trials, out);
}

}  // namespace

void draw_wells(const DrawnWellBatch& b, const random::Stream& stream) {
  // Two registers: one group of AVX2, two of AVX-512; four of two lanes, which are one group.
  constexpr std::size_t kRegisters = std::max<std::size_t>(2, kGroup / kLanes), kGroups = kRegisters * kLanes / kGroup;
  static_assert(kGroups > 0);
  std::size_t g = 0;
  for (; g + kGroups <= b.groups; g += kGroups) draw_registers<kRegisters>(b, stream, g);
  if constexpr (kGroups == 2)
    if (g < b.groups) draw_registers<1>(b, stream, g);
}

}  // namespace surveymc::propagate::SURVEYMC_ISA
