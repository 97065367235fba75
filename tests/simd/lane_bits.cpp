/// The bits of every function of lib/simd, and of random normals, in the lanes of this build: lane_bits prints one hash
/// of each, and ends with 1 where a lane has other bits than the same numbers alone. Built for each variant of the
/// lanes, and by scripts/cross_lanes.sh for other processors: all must print the same.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "random/stream.h"
#include "simd/lanes.h"
#include "simd/math.h"
#include "simd/pack.h"
#include "simd/root.h"
#include "simd/singles.h"
#include "simd/solve.h"

namespace {

using namespace surveymc;
using namespace surveymc::simd;

constexpr std::uint64_t kArguments = 100'000;
using Four = Pack<Lanes, 2>;

bool g_failed = false;

/// Numbers of all magnitudes, both signs, zeros, numbers below the normal ones, infinities.
double argument(std::uint64_t i, std::uint64_t salt) {
  std::uint64_t x = (i + 1) * 0x9e3779b97f4a7c15u + salt * 0xbf58476d1ce4e5b9u;
  x ^= x >> 29;
  x *= 0x94d049bb133111ebu;
  x ^= x >> 32;
  if (i % 97 == 0) return i % 194 == 0 ? 0.0 : -0.0;
  if (i % 101 == 0) return from_bits(x & 0x800fffffffffffffu);
  if (i % 1009 == 0) return from_bits(0x7ff0000000000000u | (x & 0x8000000000000000u));
  return from_bits((x & 0x800fffffffffffffu) | ((0x3c0u + (x >> 53) % 0x80u) << 52));
}

/// In [low, high].
double within(std::uint64_t i, std::uint64_t salt, double low, double high) {
  const double u = static_cast<double>(((i + 1) * 0x9e3779b97f4a7c15u + salt) >> 11) * 0x1p-53;
  return __builtin_fma(u, high - low, low);
}

/// All NaNs are one: which of them an operation gives is the processor's.
std::uint64_t bits_of(double x) { return x != x ? 0x7ff8000000000000u : to_bits(x); }

/// All x in [1, 4) whose root is within 2^-45 of a last place from the middle of two numbers, up to the least distance
/// there is, with those beside them: x 2^106 = m^2 + j for an odd m of 54 bits and a small j.
std::vector<double> hard_roots() {
  std::vector<double> all;
  for (std::int64_t j = -2047; j <= 2047; ++j) {
    const auto square = -static_cast<std::uint64_t>(j);  // of m, modulo a power of 2
    if ((square & 7) != 1) continue;
    for (const int bits : {54, 55}) {  // x is a multiple of 2^-52 below 2, of 2^-51 above
      std::uint64_t root = 1;
      for (int k = 3; k < bits; ++k)
        if (((root * root - square) >> k & 1) != 0) root += std::uint64_t{1} << (k - 1);
      const std::uint64_t period = std::uint64_t{1} << bits, turn = period / 2;
      for (const std::uint64_t m : {root, period - root, root + turn, period - root + turn}) {
        const std::uint64_t wrapped = m & (period - 1);
        if (wrapped >> 53 != 1) continue;
        __extension__ using Wide = unsigned __int128;
        const Wide x = static_cast<Wide>(wrapped) * wrapped + static_cast<Wide>(static_cast<__int128>(j));
        const auto digits = static_cast<std::uint64_t>(x >> bits);
        if (static_cast<Wide>(digits) << bits == x && digits >> 52 == 1)
          all.push_back(static_cast<double>(digits) * (bits == 54 ? 0x1p-52 : 0x1p-51));
      }
    }
  }
  return all;
}

/// f(k arguments) in lanes and alone; prints a hash of the values.
template <std::size_t k, class Fill, class F>
void compare(const char* name, const Fill& fill, const F& f) {
  constexpr auto n = static_cast<std::uint64_t>(lane_count<Lanes>);
  std::uint64_t hash = 14695981039346656037u;
  for (std::uint64_t first = 0; first < kArguments; first += n) {
    std::array<std::array<double, SURVEYMC_LANES>, k> in;
    std::array<Lanes, k> lanes;
    for (std::uint64_t a = 0; a < k; ++a) {
      for (std::uint64_t i = 0; i < n; ++i) in[a][i] = fill(first + i, a);
      lanes[a] = load<Lanes>(in[a].data());
    }
    const Lanes together = f(lanes);
    for (std::uint64_t i = 0; i < n; ++i) {
      std::array<double, k> alone;
      for (std::uint64_t a = 0; a < k; ++a) alone[a] = in[a][i];
      const double one = f(alone);
      if (bits_of(one) != bits_of(lane(together, static_cast<int>(i)))) {
        std::fprintf(stderr, "%s: lane %d of arguments %llu has other bits\n", name, static_cast<int>(i),
                     static_cast<unsigned long long>(first));
        g_failed = true;
        return;
      }
      hash = (hash ^ bits_of(one)) * 1099511628211u;
      hash ^= hash >> 31;
    }
  }
  std::printf("%-14s %016llx\n", name, static_cast<unsigned long long>(hash));
}

/// random::Stream::normals and uniforms: lanes, packs of lanes, and single trials.
void compare_draws() {
  const random::Stream stream(20260701, 7);
  constexpr auto n = static_cast<std::uint64_t>(lane_count<Lanes>);
  std::uint64_t hash = 14695981039346656037u;
  for (std::uint64_t first = 0; first < 20'000; first += 2 * n) {
    Bits<Four> trials;
    trials.v[0] = consecutive<Lanes>(first);
    trials.v[1] = consecutive<Lanes>(first + n);
    const auto channel = random::Channel::magnetometer_noise;
    const auto packed = stream.normals<Four>(trials, channel, Bits<Four>(first % 13));
    const auto uniform = stream.uniforms<Four>(trials, channel, Bits<Four>(first % 13));
    for (std::uint64_t i = 0; i < 2 * n; ++i) {
      const auto alone = stream.normals<double>(first + i, channel, first % 13);
      const auto alone_uniform = stream.uniforms<double>(first + i, channel, first % 13);
      for (std::size_t j = 0; j < 4; ++j) {
        const int at = static_cast<int>(i % n);
        if (to_bits(alone[j]) != to_bits(lane(packed[j].v[i / n], at)) ||
            to_bits(alone_uniform[j]) != to_bits(lane(uniform[j].v[i / n], at))) {
          std::fprintf(stderr, "draws: trial %llu has other bits\n", static_cast<unsigned long long>(first + i));
          g_failed = true;
          return;
        }
        // first % 13 depends on the number of lanes: the hash is of draws that do not
        const double x = stream.normals<double>(first + i, channel, 3)[j];
        hash = (hash ^ to_bits(x) ^ (to_bits(stream.uniforms<double>(first + i, channel, 5)[j]) << 1)) * 1099511628211u;
        hash ^= hash >> 31;
      }
    }
  }
  std::printf("%-14s %016llx\n", "draws", static_cast<unsigned long long>(hash));
}

}  // namespace

int main() {
  const auto any_number = [](std::uint64_t i, std::uint64_t a) { return argument(i, a); };
  const auto range = [](double low, double high) {
    return [=](std::uint64_t i, std::uint64_t a) { return within(i, a, low, high); };
  };
  compare<2>("sum", any_number, [](const auto& x) { return x[0] + x[1]; });
  compare<2>("quotient", any_number, [](const auto& x) { return (x[0] - x[1]) / x[1] * x[0]; });
  compare<3>("fma", any_number, [](const auto& x) { return simd::fma(x[0], x[1], x[2]); });
  compare<3>("fms", any_number, [](const auto& x) { return simd::fms(x[0], x[1], x[2]); });
  compare<1>("sqrt", any_number, [](const auto& x) { return simd::sqrt(simd::abs(x[0])); });
  const std::vector<double> hard = hard_roots();
  if (hard.size() < 500) {
    std::fprintf(stderr, "only %zu hard roots\n", hard.size());
    return 1;
  }
  const auto root = [](const auto& x) { return sqrt_by_products(x[0]); };
  compare<1>(
      "hard roots",
      [&](std::uint64_t i, std::uint64_t) {
        return std::ldexp(hard[i % hard.size()], 2 * static_cast<int>(i / hard.size() % 900) - 900);
      },
      root);
  compare<1>(
      "roots",
      [](std::uint64_t i, std::uint64_t a) {
        return from_bits((to_bits(argument(i, a)) & 0x000fffffffffffffu) | ((0x3ffu - 900 + i * 13 % 1900) << 52));
      },
      root);
  compare<3>("select", any_number, [](const auto& x) {
    return select(x[0] < x[1], select(x[2] <= x[1], x[0], -x[1]), simd::max(x[1], x[2]));
  });
  compare<3>("masks", any_number, [](const auto& x) {
    const auto c = ((x[0] > x[1]) & (x[1] < x[2])) | !(x[0] <= x[2]);
    return select(c, x[0], x[2]);
  });
  compare<2>("words", any_number, [](const auto& x) {
    const auto a = to_bits(x[0]), b = to_bits(x[1]);
    const auto c = multiply_low32(a, b) + (a << 7) - (b >> 9), d = xor3(a, b, c) | (a & b);
    return select(odd(c ^ d), small_to_double((c ^ d) >> 13), small_to_double(d >> 14));
  });
  compare<1>("log", range(0x1p-1000, 50.0), [](const auto& x) { return simd::log(x[0]); });
  compare<1>("exp", range(-800.0, 700.0), [](const auto& x) { return simd::exp(x[0]); });
  compare<1>("sin", range(-9e4, 9e4), [](const auto& x) { return sincos(x[0]).first; });
  compare<1>("cos", range(-9e4, 9e4), [](const auto& x) { return sincos(x[0]).second; });
  compare<1>("asin", range(0.0, 0.25), [](const auto& x) { return asin_ratio(x[0]); });
  compare<9>("ldlt", range(0.1, 0.9), [](const auto& x) {
    using T = std::decay_t<decltype(x[0])>;
    Symmetric<T, 3> a{x[0] + 2.0, x[1], x[2] + 2.0, x[3], x[4], x[5] + 3.0};
    const auto y = ldlt_solve<T, 3>(ldlt<T, 3>(a), {x[6], x[7], x[8]});
    const auto z =
        lu_solve<T, 3>(lu<T, 3>({x[0] + 2.0, x[1], x[2], x[3], x[4] + 2.0, x[5], x[6], x[7], x[8] + 3.0}), y);
    return simd::fma(y[0], y[1], y[2]) + z[0] * z[1] - z[2];
  });
  compare_draws();
  return g_failed ? 1 : 0;
}
