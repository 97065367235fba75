#include "random/design_points.h"

#include <array>
#include <bit>
#include <cassert>

#include "random/stream.h"

namespace surveymc::random {
namespace {

// Purposes of these draws. Rare events have channels of the same numbers (rare_channels.h), but no draw of a design is
// one of a run on its seed: study and channel are one word of a draw's address (stream.h), and a design's study is 0,
// StudyId::none, which no run has. A cipher gives different addresses different numbers.
constexpr Channel kPermutation{70}, kJitter{71}, kScramble{72};

/// 32 random bits of an address.
std::uint64_t word(const Stream& stream, std::uint64_t number, Channel purpose, std::uint64_t call) {
  const double u = stream.uniforms<double>(number, purpose, call)[0];  // (word + 1/2) / 2^32, exactly
  return static_cast<std::uint64_t>(u * 0x1p32);
}

Stream stream_of_design(std::uint64_t seed) { return Stream(seed, 0); }

}  // namespace

std::uint64_t permuted(std::uint64_t i, std::uint64_t count, unsigned axis, std::uint64_t seed) {
  assert(i < count && count <= kMostDesignPoints);
  constexpr unsigned kRounds = 8;
  const Stream stream = stream_of_design(seed);
  const auto half = count <= 1 ? 1u : static_cast<unsigned>(std::bit_width(count - 1) + 1) / 2;
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  std::uint64_t x = i;
  do {
    std::uint64_t left = x >> half, right = x & mask;
    for (unsigned round = 0; round < kRounds; ++round) {
      const std::uint64_t mixed = left ^ (word(stream, right, kPermutation, axis * kRounds + round) & mask);
      left = right;
      right = mixed;
    }
    x = left << half | right;
  } while (x >= count);
  return x;
}

double latin_hypercube(std::uint64_t i, std::uint64_t count, unsigned axis, std::uint64_t seed) {
  const double u = stream_of_design(seed).uniforms<double>(i, kJitter, std::uint64_t{axis})[0];
  return (static_cast<double>(permuted(i, count, axis, seed)) + u) / static_cast<double>(count);
}

namespace {

/// A primitive polynomial as bits, highest power first, and the first `degree` direction numbers.
struct Direction {
  unsigned degree, polynomial;
  std::array<std::uint16_t, 9> first;
};

// Axes 2 to 64 of new-joe-kuo-6.21201: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional
// projections", SIAM J. Sci. Comput. 30 (2008), 2635-2654. Axis 1 has the direction number 1 throughout.
constexpr std::array<Direction, kSobolAxes - 1> kDirections{{
    {1, 3, {1}},
    {2, 7, {1, 3}},
    {3, 11, {1, 3, 1}},
    {3, 13, {1, 1, 1}},
    {4, 19, {1, 1, 3, 3}},
    {4, 25, {1, 3, 5, 13}},
    {5, 37, {1, 1, 5, 5, 17}},
    {5, 41, {1, 1, 5, 5, 5}},
    {5, 47, {1, 1, 7, 11, 19}},
    {5, 55, {1, 1, 5, 1, 1}},
    {5, 59, {1, 1, 1, 3, 11}},
    {5, 61, {1, 3, 5, 5, 31}},
    {6, 67, {1, 3, 3, 9, 7, 49}},
    {6, 91, {1, 1, 1, 15, 21, 21}},
    {6, 97, {1, 3, 1, 13, 27, 49}},
    {6, 103, {1, 1, 1, 15, 7, 5}},
    {6, 109, {1, 3, 1, 15, 13, 25}},
    {6, 115, {1, 1, 5, 5, 19, 61}},
    {7, 131, {1, 3, 7, 11, 23, 15, 103}},
    {7, 137, {1, 3, 7, 13, 13, 15, 69}},
    {7, 143, {1, 1, 3, 13, 7, 35, 63}},
    {7, 145, {1, 3, 5, 9, 1, 25, 53}},
    {7, 157, {1, 3, 1, 13, 9, 35, 107}},
    {7, 167, {1, 3, 1, 5, 27, 61, 31}},
    {7, 171, {1, 1, 5, 11, 19, 41, 61}},
    {7, 185, {1, 3, 5, 3, 3, 13, 69}},
    {7, 191, {1, 1, 7, 13, 1, 19, 1}},
    {7, 193, {1, 3, 7, 5, 13, 19, 59}},
    {7, 203, {1, 1, 3, 9, 25, 29, 41}},
    {7, 211, {1, 3, 5, 13, 23, 1, 55}},
    {7, 213, {1, 3, 7, 3, 13, 59, 17}},
    {7, 229, {1, 3, 1, 3, 5, 53, 69}},
    {7, 239, {1, 1, 5, 5, 23, 33, 13}},
    {7, 241, {1, 1, 7, 7, 1, 61, 123}},
    {7, 247, {1, 1, 7, 9, 13, 61, 49}},
    {7, 253, {1, 3, 3, 5, 3, 55, 33}},
    {8, 285, {1, 3, 1, 15, 31, 13, 49, 245}},
    {8, 299, {1, 3, 5, 15, 31, 59, 63, 97}},
    {8, 301, {1, 3, 1, 11, 11, 11, 77, 249}},
    {8, 333, {1, 3, 1, 11, 27, 43, 71, 9}},
    {8, 351, {1, 1, 7, 15, 21, 11, 81, 45}},
    {8, 355, {1, 3, 7, 3, 25, 31, 65, 79}},
    {8, 357, {1, 3, 1, 1, 19, 11, 3, 205}},
    {8, 361, {1, 1, 5, 9, 19, 21, 29, 157}},
    {8, 369, {1, 3, 7, 11, 1, 33, 89, 185}},
    {8, 391, {1, 3, 3, 3, 15, 9, 79, 71}},
    {8, 397, {1, 3, 7, 11, 15, 39, 119, 27}},
    {8, 425, {1, 1, 3, 1, 11, 31, 97, 225}},
    {8, 451, {1, 1, 1, 3, 23, 43, 57, 177}},
    {8, 463, {1, 3, 7, 7, 17, 17, 37, 71}},
    {8, 487, {1, 3, 1, 5, 27, 63, 123, 213}},
    {8, 501, {1, 1, 3, 5, 11, 43, 53, 133}},
    {9, 529, {1, 3, 5, 5, 29, 17, 47, 173, 479}},
    {9, 539, {1, 3, 3, 11, 3, 1, 109, 9, 69}},
    {9, 545, {1, 1, 1, 5, 17, 39, 23, 5, 343}},
    {9, 557, {1, 3, 1, 5, 25, 15, 31, 103, 499}},
    {9, 563, {1, 1, 1, 11, 11, 17, 63, 105, 183}},
    {9, 601, {1, 1, 5, 11, 9, 29, 97, 231, 363}},
    {9, 607, {1, 1, 5, 15, 19, 45, 41, 7, 383}},
    {9, 617, {1, 3, 7, 7, 31, 19, 83, 137, 221}},
    {9, 623, {1, 1, 1, 3, 23, 15, 111, 223, 83}},
    {9, 631, {1, 1, 5, 13, 31, 15, 55, 25, 161}},
    {9, 637, {1, 1, 3, 13, 25, 47, 39, 87, 257}},
}};

constexpr unsigned kBits = 53, kDepth = 41;  // of a coordinate; of a point's number and one more

/// v[k]: bit k of the Gray code, as bits of the coordinate.
using Column = std::array<std::uint64_t, kDepth>;

/// m_k = 2 a_1 m_(k-1) + 4 a_2 m_(k-2) + .. + 2^s m_(k-s) + m_(k-s), sums without carry (Joe and Kuo 2008, eq 2).
Column column_of(unsigned axis) {
  std::array<std::uint64_t, kDepth> m;
  m.fill(1);
  if (axis > 0) {
    const Direction& d = kDirections.at(axis - 1);
    for (unsigned k = 0; k < kDepth; ++k) {
      if (k < d.degree) {
        m[k] = d.first[k];
        continue;
      }
      m[k] = m[k - d.degree] ^ m[k - d.degree] << d.degree;
      for (unsigned j = 1; j < d.degree; ++j)
        if (d.polynomial >> (d.degree - j) & 1u) m[k] ^= m[k - j] << j;
    }
  }
  Column v;
  for (unsigned k = 0; k < kDepth; ++k) v[k] = m[k] << (kBits - 1 - k);
  return v;
}

const std::array<Column, kSobolAxes>& columns() {
  static const std::array<Column, kSobolAxes> all = [] {
    std::array<Column, kSobolAxes> c;
    for (unsigned axis = 0; axis < kSobolAxes; ++axis) c[axis] = column_of(axis);
    return c;
  }();
  return all;
}

}  // namespace

std::uint64_t sobol_bits(std::uint64_t i, unsigned axis) {
  assert(i <= kMostDesignPoints);
  const Column& v = columns().at(axis);
  std::uint64_t x = 0;
  for (std::uint64_t gray = i ^ i >> 1; gray != 0; gray &= gray - 1)
    x ^= v[static_cast<std::size_t>(std::countr_zero(gray))];
  return x;
}

double sobol(std::uint64_t i, unsigned axis, std::uint64_t seed) {
  const Stream stream = stream_of_design(seed);
  const std::uint64_t x = sobol_bits(i, axis);
  std::uint64_t y = 0;
  for (unsigned bit = 0; bit < kBits; ++bit) {
    const std::uint64_t above = x >> (kBits - bit), flip = word(stream, above, kScramble, axis * kBits + bit) >> 31;
    y = y << 1 | ((x >> (kBits - 1 - bit) & 1u) ^ flip);
  }
  return (static_cast<double>(y >> 1) + 0.5) * 0x1p-52;  // y has 53 bits: one less leaves room for the half
}

}  // namespace surveymc::random
