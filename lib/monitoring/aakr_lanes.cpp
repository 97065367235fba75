#include "monitoring/aakr_lanes.h"

// Vectors stand in the order of their projections on one direction. A projection differs by no more than the distance:
// only a window of tiles around that of the query can hold a vector within the cutoff. Weights are relative to the
// least distance in the query's own tile, an upper bound of the least of all; it cancels in the quotient as that one
// does. So every vector is looked at once, but for those of that tile.

namespace surveymc::monitoring::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
constexpr std::size_t kParts = kGroup / lane_count<T>;  // registers that hold a group
constexpr double kLargest = 1.7976931348623157e308;

/// A sum kept for each place in a group: it does not depend on the width of a register.
struct GroupSum {
  T part[kParts];
  GroupSum() {
    for (T& p : part) p = T(0.0);
  }
  /// In one order for all widths.
  double total() const {
    double s[kGroup];
    for (std::size_t i = 0; i < kParts; ++i) store(s + i * lane_count<T>, part[i]);
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }
};

/// The vectors of a tile are worked on in registers, some at a time: the steps of one wait for each other. No fewer
/// than the parts of a group, which are summed apart.
constexpr std::size_t kRegisters = kParts > 2 ? kParts : 2;
constexpr std::size_t kStep = kRegisters * lane_count<T>;
struct Registers {
  T x[kRegisters];
};

/// A query in all lanes: its first N sensors here, the others where they are.
template <std::size_t N>
struct Query {
  T x[N];
  const double* all;
  explicit Query(const double* query) : all(query) {
    for (std::size_t j = 0; j < N; ++j) x[j] = T(query[j]);
  }
};

/// sum - (x - query)^2 for one sensor of kStep vectors.
[[gnu::always_inline]] inline void subtract_square(const double* x, const T& query, Registers& sum) {
  for (std::size_t i = 0; i < kRegisters; ++i) {
    const T d = load<T>(x + i * lane_count<T>) - query;
    sum.x[i] = fma(-d, d, sum.x[i]);
  }
}

/// from - u^2 of kStep vectors, u their distances to a query.
template <std::size_t N>
[[gnu::always_inline]] inline Registers less_squares(const AakrBatch& b, const Query<N>& query, std::size_t first,
                                                     const T& from) {
  Registers sum;
  for (T& x : sum.x) x = from;
  for (std::size_t j = 0; j < N; ++j) subtract_square(b.memory + j * b.padded + first, query.x[j], sum);
  for (std::size_t j = N; j < static_cast<std::size_t>(b.sensors); ++j)
    subtract_square(b.memory + j * b.padded + first, T(query.all[j]), sum);
  return sum;
}

/// Tiles first to end - 1.
struct Window {
  std::size_t first, end;
};

/// The least squared distance of the vectors of some tiles.
template <std::size_t N>
double smallest_in(const AakrBatch& b, const Query<N>& query, Window w) {
  Registers most;
  for (T& x : most.x) x = T(-kLargest);
  for (std::size_t at = w.first * kTile; at < w.end * kTile; at += kStep) {
    const Registers u = less_squares(b, query, at, T(0.0));
    for (std::size_t i = 0; i < kRegisters; ++i) most.x[i] = select(u.x[i] > most.x[i], u.x[i], most.x[i]);
  }
  double smallest = kLargest;
  for (const T& x : most.x)
    for (int i = 0; i < lane_count<T>; ++i) smallest = -lane(x, i) < smallest ? -lane(x, i) : smallest;
  return smallest;
}

/// The last tile whose first projection is not above that of the query, or the first.
std::size_t own_tile(const AakrBatch& b, double projection) {
  std::size_t not_above = 0;
  for (std::size_t t = 0; t < b.tiles; ++t) not_above += b.low[t] <= projection ? 1 : 0;
  return not_above > 0 ? not_above - 1 : 0;
}

/// Tiles with a projection within `radius` of the query's, and its own.
Window window_around(const AakrBatch& b, std::size_t own, double projection, double radius) {
  const double low = projection - radius, high = projection + radius;
  std::size_t below = 0, not_above = 0;  // projections rise
  for (std::size_t t = 0; t < b.tiles; ++t) {
    below += b.high[t] < low ? 1 : 0;
    not_above += b.low[t] <= high ? 1 : 0;
  }
  return {below < own ? below : own, not_above > own ? not_above : own + 1};
}

/// p f + c
[[gnu::always_inline]] inline void horner(Registers& p, const Registers& f, double c) {
  for (std::size_t i = 0; i < kRegisters; ++i) p.x[i] = fma(f.x[i], p.x[i], T(c));
}

/// 2^x for x <= 1000, to 8e-14 of its value; 0 below -1000. Polynomial of least largest error for |f| <= 1/2.
[[gnu::always_inline]] inline Registers powers_of_two(const Registers& x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer that stands in the low bits
  Registers shifted, f, p;
  for (std::size_t i = 0; i < kRegisters; ++i) {
    shifted.x[i] = x.x[i] + T(kRound);
    f.x[i] = x.x[i] - (shifted.x[i] - T(kRound));
    p.x[i] = T(9.168109430389961e-08);
  }
  horner(p, f, 1.325518283609116e-06);
  horner(p, f, 1.5258493118260403e-05);
  horner(p, f, 0.0001540345603644215);
  horner(p, f, 0.0013333547331364395);
  horner(p, f, 0.009618129159172479);
  horner(p, f, 0.05550410873971288);
  horner(p, f, 0.24022650695813708);
  horner(p, f, 0.6931471805585505);
  horner(p, f, 1.0);
  for (std::size_t i = 0; i < kRegisters; ++i)
    p.x[i] = select(x.x[i] < T(-1000.0), T(0.0), from_bits(to_bits(p.x[i]) + (to_bits(shifted.x[i]) << 52)));
  return p;
}

/// The means of the first N sensors, weighted; the sum of the weights, which stay in b.weights if there are more
/// sensors.
template <std::size_t N>
double weigh(const AakrBatch& b, const Query<N>& query, Window window, double shift, double* out) {
  GroupSum weight, sum[N];
  const T from(shift);
  const bool is_kept = b.sensors > static_cast<int>(N);
  for (std::size_t at = window.first * kTile; at < window.end * kTile; at += kStep) {
    const Registers w = powers_of_two(less_squares(b, query, at, from));
    for (std::size_t i = 0; i < kRegisters; ++i) weight.part[i % kParts] = weight.part[i % kParts] + w.x[i];
    for (std::size_t j = 0; j < N; ++j)
      for (std::size_t i = 0; i < kRegisters; ++i) {
        const T x = load<T>(b.memory + j * b.padded + at + i * lane_count<T>);
        sum[j].part[i % kParts] = fma(w.x[i], x, sum[j].part[i % kParts]);
      }
    if (!is_kept) continue;
    for (std::size_t i = 0; i < kRegisters; ++i) store(b.weights + at + i * lane_count<T>, w.x[i]);
  }
  const double total = weight.total();
  for (std::size_t j = 0; j < N; ++j) out[j] = sum[j].total() / (total * b.scale);
  return total;
}

/// The mean of one more sensor, with these weights.
double weighted_mean(const AakrBatch& b, Window window, double weight, int sensor) {
  GroupSum sum;
  const double* x = b.memory + static_cast<std::size_t>(sensor) * b.padded;
  for (std::size_t at = window.first * kTile; at < window.end * kTile; at += kGroup)
    for (std::size_t k = 0; k < kParts; ++k)
      sum.part[k] = fma(load<T>(b.weights + at + k * lane_count<T>), load<T>(x + at + k * lane_count<T>), sum.part[k]);
  return sum.total() / (weight * b.scale);
}

/// N: the number of sensors, or 4 if there are more.
template <std::size_t N>
void predict_one(const AakrBatch& b, const double* query_z, double* out, double* nearest) {
  double projection = 0;
  for (int j = 0; j < b.sensors; ++j) {
    b.scaled[j] = b.scale * query_z[j];
    projection = fma(b.direction[j], b.scaled[j], projection);
  }
  const Query<N> query(b.scaled);
  const std::size_t own = own_tile(b, projection);
  double shift = smallest_in(b, query, {own, own + 1});
  const double slack = 1 + 1e-9;  // of the distance: the rounding of the query's projection
  const Window window = window_around(b, own, projection, sqrt(shift + b.cutoff) * slack + b.rounding);
  constexpr double kMost = 500;  // log2 of a weight: far from the memory, or with a tiny h, it would not be finite
  if (!(shift < kMost)) shift = smallest_in(b, query, window);
  const double weight = weigh(b, query, window, shift, out);
  for (int j = static_cast<int>(N); j < b.sensors; ++j) out[j] = weighted_mean(b, window, weight, j);
  if (nearest) *nearest = sqrt(smallest_in(b, query, window)) / b.scale;
}

template <std::size_t N>
void predict_all(const AakrBatch& b) {
  for (int q = 0; q < b.count; ++q) {
    const std::size_t at = static_cast<std::size_t>(q) * static_cast<std::size_t>(b.sensors);
    predict_one<N>(b, b.queries + at, b.predictions + at, b.nearest ? b.nearest + q : nullptr);
  }
}

}  // namespace

void aakr_predict(const AakrBatch& b) {
  switch (b.sensors) {
    case 1:
      return predict_all<1>(b);
    case 2:
      return predict_all<2>(b);
    case 3:
      return predict_all<3>(b);
    default:
      return predict_all<4>(b);
  }
}

}  // namespace surveymc::monitoring::SURVEYMC_ISA
