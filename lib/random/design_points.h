#pragma once
/// Points of random designs in the unit cube as functions of their number: no point needs the others. All draws are
/// those of the counter-based generator (stream.h) under the design's own seed.
#include <cstdint>

namespace surveymc::random {

/// Axes that sobol() has.
inline constexpr unsigned kSobolAxes = 64;
/// Points that a design can have, at most.
inline constexpr std::uint64_t kMostDesignPoints = std::uint64_t{1} << 40;

/// The number that a random permutation of 0 .. count - 1 has at `i` < count <= kMostDesignPoints. Axes have
/// independent permutations. A Feistel network of eight rounds over the next even power of two, walked along its cycle
/// until it is below `count` (Black and Rogaway, CT-RSA 2002, method 3).
std::uint64_t permuted(std::uint64_t i, std::uint64_t count, unsigned axis, std::uint64_t seed);

/// Coordinate `axis` of point `i` of a latin hypercube of `count` points, in (0, 1): one uniform draw in the stratum
/// permuted(i), so that each of the `count` strata of an axis has one point (McKay, Beckman and Conover 1979).
double latin_hypercube(std::uint64_t i, std::uint64_t count, unsigned axis, std::uint64_t seed);

/// Coordinate `axis` < kSobolAxes of point `i` <= kMostDesignPoints of the Sobol' sequence in Gray-code order, as 53
/// bits: the coordinate times 2^53. Direction numbers of Joe and Kuo (2008), new-joe-kuo-6.
std::uint64_t sobol_bits(std::uint64_t i, unsigned axis);

/// The same, scrambled (Owen 1995) and in (0, 1): each bit is flipped or not by a draw that belongs to the bits above
/// it. Any 2^k points from a multiple of 2^k on have one in each of 2^k equal intervals of every axis.
double sobol(std::uint64_t i, unsigned axis, std::uint64_t seed);

}  // namespace surveymc::random
