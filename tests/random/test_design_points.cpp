/// Designs of sweeps: permutations, latin hypercubes and scrambled Sobol' points by their number.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <boost/random/sobol.hpp>
#include <catch2/catch.hpp>

#include "random/design_points.h"
#include "random/rare_channels.h"
#include "random/study_id.h"

using namespace surveymc::random;

TEST_CASE("A keyed permutation has every number once, and another key another order") {
  for (const std::uint64_t n : {1u, 2u, 3u, 5u, 16u, 17u, 1000u, 4097u}) {
    std::vector<bool> seen(n);
    for (std::uint64_t i = 0; i < n; ++i) seen.at(permuted(i, n, 3, 9)) = true;
    CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
  }
  int same_seed = 0, same_axis = 0;  // of 1000 places one is the same by chance
  for (std::uint64_t i = 0; i < 1000; ++i) {
    same_seed += permuted(i, 1000, 0, 1) == permuted(i, 1000, 0, 2);
    same_axis += permuted(i, 1000, 0, 1) == permuted(i, 1000, 1, 1);
  }
  CHECK(same_seed < 8);
  CHECK(same_axis < 8);
  CHECK(permuted((std::uint64_t{1} << 40) - 1, std::uint64_t{1} << 40, 0, 1) < (std::uint64_t{1} << 40));
}

TEST_CASE("All orders of four are as frequent as each other") {
  constexpr int kSeeds = 4800, kOrders = 24;
  std::vector<int> count(256);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    std::uint64_t order = 0;
    for (std::uint64_t i = 0; i < 4; ++i) order = order << 2 | permuted(i, 4, 0, seed);
    ++count[order];
  }
  double chi_squared = 0;
  for (const int n : count)
    if (n > 0) chi_squared += (n - kSeeds / kOrders) * (n - kSeeds / kOrders) / double(kSeeds / kOrders);
  CHECK(256 - std::count(count.begin(), count.end(), 0) == kOrders);
  CHECK(chi_squared < 23 + 5 * std::sqrt(2 * 23.0));  // 23 degrees of freedom, 5 standard deviations
}

TEST_CASE("A latin hypercube has one point in every stratum of every axis") {
  constexpr std::uint64_t kPoints = 1000;
  for (unsigned axis = 0; axis < 3; ++axis) {
    std::vector<bool> seen(kPoints);
    double sum = 0, product = 0;
    for (std::uint64_t i = 0; i < kPoints; ++i) {
      const double u = latin_hypercube(i, kPoints, axis, 5), v = latin_hypercube(i, kPoints, axis + 1, 5);
      REQUIRE((u > 0 && u < 1));
      seen[static_cast<std::size_t>(u * kPoints)] = true;
      sum += u;
      product += (u - 0.5) * (v - 0.5);
    }
    CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
    CHECK(std::abs(sum / kPoints - 0.5) < 5 / std::sqrt(12.0) / kPoints / std::sqrt(1.0 * kPoints));
    CHECK(std::abs(12 * product / kPoints) < 5 / std::sqrt(1.0 * kPoints));  // axes are independent
  }
}

TEST_CASE("Sobol' points are those of Joe and Kuo's direction numbers") {
  boost::random::sobol other(kSobolAxes);  // 64 bits of every coordinate, from point 1 on
  for (std::uint64_t i = 1; i < 3000; ++i)
    for (unsigned axis = 0; axis < kSobolAxes; ++axis) REQUIRE(sobol_bits(i, axis) == other() >> 11);
  CHECK(sobol_bits(0, 7) == 0);
  // Far points: a jump is the same as the way there.
  boost::random::sobol far(kSobolAxes);
  far.seed(123456789);
  for (unsigned axis = 0; axis < kSobolAxes; ++axis) REQUIRE(sobol_bits(123456790, axis) == far() >> 11);
}

TEST_CASE("Scrambling keeps the equidistribution of a Sobol' sequence") {
  constexpr std::uint64_t kPoints = 256;
  for (unsigned axis = 0; axis < kSobolAxes; ++axis) {
    for (const std::uint64_t first : {std::uint64_t{0}, 3 * kPoints}) {
      std::vector<bool> seen(kPoints);
      for (std::uint64_t i = first; i < first + kPoints; ++i) {
        const double u = sobol(i, axis, 11);
        REQUIRE((u > 0 && u < 1));
        seen[static_cast<std::size_t>(u * kPoints)] = true;
      }
      CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
    }
  }
  // (0, m, 2)-net of the first two axes: every box of area 2^-8 has one point, whatever its shape
  for (unsigned k = 0; k <= 8; ++k) {
    std::set<std::pair<int, int>> boxes;
    for (std::uint64_t i = 0; i < kPoints; ++i)
      boxes.emplace(std::floor(std::ldexp(sobol(i, 0, 4), static_cast<int>(k))),
                    std::floor(std::ldexp(sobol(i, 1, 4), static_cast<int>(8 - k))));
    CHECK(boxes.size() == kPoints);
  }
  CHECK(sobol(5, 1, 11) != sobol(5, 1, 12));
}

TEST_CASE("Every scrambled point is uniform over the seeds") {
  constexpr int kSeeds = 4000;
  for (const std::uint64_t i : {0u, 1u, 77u}) {
    double sum = 0, squares = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const double u = sobol(i, 2, seed);
      sum += u;
      squares += u * u;
    }
    CHECK(std::abs(sum / kSeeds - 0.5) < 5 / std::sqrt(12.0 * kSeeds));
    CHECK(std::abs(squares / kSeeds - 1.0 / 3) < 5 * std::sqrt(4.0 / 45 / kSeeds));
  }
}

TEST_CASE("A design shares no number with a run on its seed, though rare events have channels of the same numbers") {
  constexpr std::uint64_t kSeed = 11;
  for (unsigned axis = 0; axis < 4; ++axis) {
    const double u = latin_hypercube(0, 1, axis, kSeed);  // of one point: its draw alone
    const auto drawn = [&](std::uint32_t study) {
      return Stream(kSeed, study).uniforms<double>(0, kRareChoice, std::uint64_t{axis})[0];
    };
    CHECK(u == drawn(static_cast<std::uint32_t>(StudyId::none)));
    for (std::uint32_t study = 1; study < 65536; ++study)
      if (!name_of(StudyId{study}).empty()) CHECK(u != drawn(study));
  }
}
