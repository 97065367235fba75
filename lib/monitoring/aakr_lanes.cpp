#include "monitoring/aakr_lanes.h"

// Vectors stand in the order of their projections on one direction. A projection differs by no more than the distance:
// only a window of tiles around that of the query can hold a vector within the cutoff. Weights are relative to the
// least distance in the query's own tile, an upper bound of the least of all; it cancels in the quotient as that one
// does. So every vector is looked at once.

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

double least_lane(const T& x) {
  double least = lane(x, 0);
  for (int i = 1; i < lane_count<T>; ++i) least = lane(x, i) < least ? lane(x, i) : least;
  return least;
}

/// The vectors of a tile are worked on in registers, four at a time.
constexpr std::size_t kRegisters = 4;
constexpr std::size_t kStep = kRegisters * lane_count<T>;
struct Registers {
  T x[kRegisters];
};

/// Squared distances of kStep vectors to a query; `least` becomes the smallest of each lane so far.
Registers squared_distances(const AakrBatch& b, const double* query, std::size_t first, Registers& least) {
  Registers sum;
  for (T& x : sum.x) x = T(0.0);
  const double* x = b.memory + first;
  for (int j = 0; j < b.sensors; ++j, x += b.padded)
    for (std::size_t i = 0; i < kRegisters; ++i) {
      const T d = load<T>(x + i * lane_count<T>) - T(query[j]);
      sum.x[i] = fma(d, d, sum.x[i]);
    }
  for (std::size_t i = 0; i < kRegisters; ++i) least.x[i] = select(sum.x[i] < least.x[i], sum.x[i], least.x[i]);
  return sum;
}

double smallest_of(const Registers& least) {
  double smallest = least_lane(least.x[0]);
  for (const T& x : least.x) smallest = least_lane(x) < smallest ? least_lane(x) : smallest;
  return smallest;
}

/// Tiles first to end - 1.
struct Window {
  std::size_t first, end;
};

/// The least squared distance of the vectors of some tiles.
double smallest_in(const AakrBatch& b, const double* query, Window w) {
  Registers least;
  for (T& x : least.x) x = T(kLargest);
  for (std::size_t at = w.first * kTile; at < w.end * kTile; at += kStep) squared_distances(b, query, at, least);
  return smallest_of(least);
}

/// The tile before which all projections are smaller than that of the query, but the first if it is the smallest.
std::size_t own_tile(const AakrBatch& b, double projection) {
  std::size_t first = 0, end = b.tiles;
  while (end - first > 1) {
    const std::size_t middle = first + (end - first) / 2;
    if (b.low[middle] <= projection)
      first = middle;
    else
      end = middle;
  }
  return first;
}

/// Tiles with a projection within `radius` of the query's, from its own on to both sides.
Window window_around(const AakrBatch& b, std::size_t own, double projection, double radius) {
  Window w{own, own + 1};
  while (w.first > 0 && b.high[w.first - 1] >= projection - radius) --w.first;
  while (w.end < b.tiles && b.low[w.end] <= projection + radius) ++w.end;
  return w;
}

/// 2^x for x <= 1000, to 4e-16 of its value; 0 below -1000. Polynomial of least largest error for |f| <= 1/2.
T power_of_two(const T& x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer that stands in the low bits
  const T shifted = x + T(kRound);
  const T f = x - (shifted - T(kRound)), f2 = f * f;
  T even(7.072585949269223e-09), odd(1.0208690299958306e-07);
  constexpr double kEven[] = {1.321544258792169e-06, 0.0001540353044173605, 0.009618129107606888, 0.24022650695910097,
                              1.0};
  constexpr double kOdd[] = {1.5252657260200837e-05, 0.0013333558230164974, 0.05550410866444772, 0.69314718055995};
  for (const double c : kEven) even = fma(f2, even, T(c));
  for (const double c : kOdd) odd = fma(f2, odd, T(c));
  return select(x < T(-1000.0), T(0.0), from_bits(to_bits(fma(f, odd, even)) + (to_bits(shifted) << 52)));
}

/// The means of the first N sensors, weighted; the sum of the weights, which stay in b.weights if there are more
/// sensors. `smallest`: the least squared distance.
template <std::size_t N>
double weigh(const AakrBatch& b, const double* query, Window window, double shift, double& smallest, double* out) {
  GroupSum weight, sum[N];
  Registers least;
  for (T& x : least.x) x = T(kLargest);
  const T from(shift), per(b.per_square);
  const bool is_kept = b.sensors > static_cast<int>(N);
  for (std::size_t at = window.first * kTile; at < window.end * kTile; at += kStep) {
    Registers w = squared_distances(b, query, at, least);
    for (T& x : w.x) x = power_of_two((x - from) * per);
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
  for (std::size_t j = 0; j < N; ++j) out[j] = sum[j].total() / total;
  smallest = smallest_of(least);
  return total;
}

/// The mean of one more sensor, with these weights.
double weighted_mean(const AakrBatch& b, Window window, double weight, int sensor) {
  GroupSum sum;
  const double* x = b.memory + static_cast<std::size_t>(sensor) * b.padded;
  for (std::size_t at = window.first * kTile; at < window.end * kTile; at += kGroup)
    for (std::size_t k = 0; k < kParts; ++k)
      sum.part[k] = fma(load<T>(b.weights + at + k * lane_count<T>), load<T>(x + at + k * lane_count<T>), sum.part[k]);
  return sum.total() / weight;
}

void predict_one(const AakrBatch& b, const double* query, double* out, double* nearest) {
  double projection = 0;
  for (int j = 0; j < b.sensors; ++j) projection = fma(b.direction[j], query[j], projection);
  const std::size_t own = own_tile(b, projection);
  double shift = smallest_in(b, query, {own, own + 1});
  const double slack = 1 + 1e-9;  // of the distance: the rounding of the query's projection
  const Window window = window_around(b, own, projection, sqrt(shift + b.cutoff) * slack + b.rounding);
  constexpr double kMost = 500;  // log2 of a weight: far from the memory, or with a tiny h, it would not be finite
  if (!(shift * -b.per_square < kMost)) shift = smallest_in(b, query, window);
  double smallest = 0;
  int j = b.sensors >= 4 ? 4 : b.sensors;
  const double weight = j == 4   ? weigh<4>(b, query, window, shift, smallest, out)
                        : j == 3 ? weigh<3>(b, query, window, shift, smallest, out)
                        : j == 2 ? weigh<2>(b, query, window, shift, smallest, out)
                                 : weigh<1>(b, query, window, shift, smallest, out);
  for (; j < b.sensors; ++j) out[j] = weighted_mean(b, window, weight, j);
  *nearest = sqrt(smallest);
}

}  // namespace

void aakr_predict(const AakrBatch& b) {
  for (int q = 0; q < b.count; ++q) {
    const std::size_t at = static_cast<std::size_t>(q) * static_cast<std::size_t>(b.sensors);
    predict_one(b, b.queries + at, b.predictions + at, b.nearest + q);
  }
}

}  // namespace surveymc::monitoring::SURVEYMC_ISA
