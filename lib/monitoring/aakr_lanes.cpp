#include "monitoring/aakr_lanes.h"

#include "simd/math.h"

namespace surveymc::monitoring::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
constexpr std::size_t kParts = kGroup / lane_count<T>;  // registers that hold a group

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

/// Squared distances of the memory vectors to a query, and the smallest of them.
double squared_distances(const AakrBatch& b, const double* query, double* u2) {
  T least(1.7976931348623157e308);
  for (std::size_t i = 0; i < b.padded; i += lane_count<T>) {
    T sum(0.0);
    for (int j = 0; j < b.sensors; ++j) {
      const T d = load<T>(b.memory + static_cast<std::size_t>(j) * b.padded + i) - T(query[j]);
      sum = fma(d, d, sum);
    }
    store(u2 + i, sum);
    least = select(sum < least, sum, least);  // padding repeats a vector of the memory: it cannot be nearer
  }
  double smallest = lane(least, 0);
  for (int i = 1; i < lane_count<T>; ++i) smallest = lane(least, i) < smallest ? lane(least, i) : smallest;
  return smallest;
}

/// Weights in place of squared distances; their sum.
double weights(const AakrBatch& b, double smallest, double* u2) {
  GroupSum sum;
  for (std::size_t i = 0; i < b.padded; i += kGroup)
    for (std::size_t k = 0; k < kParts; ++k) {
      double* at = u2 + i + k * lane_count<T>;
      const T w = load<T>(b.valid + i + k * lane_count<T>) * exp((load<T>(at) - T(smallest)) * T(b.minus_half_per_h2));
      store(at, w);
      sum.part[k] = sum.part[k] + w;
    }
  return sum.total();
}

/// Weighted means of N sensors from `first`.
template <int N>
void weighted_means(const AakrBatch& b, const double* w, double weight, int first, double* out) {
  GroupSum sum[N];
  const double* x = b.memory + static_cast<std::size_t>(first) * b.padded;
  for (std::size_t i = 0; i < b.padded; i += kGroup)
    for (std::size_t k = 0; k < kParts; ++k) {
      const std::size_t at = i + k * lane_count<T>;
      const T wk = load<T>(w + at);
      for (std::size_t j = 0; j < static_cast<std::size_t>(N); ++j)
        sum[j].part[k] = fma(wk, load<T>(x + j * b.padded + at), sum[j].part[k]);
    }
  for (int j = 0; j < N; ++j) out[first + j] = sum[j].total() / weight;
}

}  // namespace

void aakr_predict(const AakrBatch& b) {
  for (int q = 0; q < b.count; ++q) {
    const double* query = b.queries + static_cast<std::size_t>(q) * static_cast<std::size_t>(b.sensors);
    double* out = b.predictions + static_cast<std::size_t>(q) * static_cast<std::size_t>(b.sensors);
    const double smallest = squared_distances(b, query, b.scratch);
    b.nearest[q] = sqrt(smallest);
    const double weight = weights(b, smallest, b.scratch);
    int j = 0;
    for (; j + 4 <= b.sensors; j += 4) weighted_means<4>(b, b.scratch, weight, j, out);
    for (; j < b.sensors; ++j) weighted_means<1>(b, b.scratch, weight, j, out);
  }
}

}  // namespace surveymc::monitoring::SURVEYMC_ISA
