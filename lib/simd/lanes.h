#pragma once
/// The one place that knows how trials are put side by side.
///
/// A kernel is written once, as `template <class T>`, and is called with T = double (one trial: tests, replay),
/// T = Lanes (one trial per lane) or T = Dual<...> (derivatives). It has no `if` on a T: use select(). All arithmetic
/// is elementwise IEEE, fused only where fma() is written, so lane i of a Lanes result is bit for bit the double
/// result of trial i.
#include <cmath>
#include <cstdint>

#include <immintrin.h>

namespace surveymc {

/// Trials lie in memory in groups of this many, whatever the width of a register: the layout, and with it every sum
/// over trials, is the same on all machines.
inline constexpr int kGroup = 8;

/// 64-bit integers beside Lanes: random words and bit patterns.
struct LaneBits {
  using Vector = std::uint64_t __attribute__((vector_size(32)));
  Vector v;

  LaneBits() = default;
  LaneBits(Vector x) : v(x) {}                    // NOLINT: a vector is its lanes
  LaneBits(std::uint64_t x) : v(Vector{} + x) {}  // NOLINT: constants mix freely

  friend LaneBits operator+(LaneBits a, LaneBits b) { return a.v + b.v; }
  friend LaneBits operator-(LaneBits a, LaneBits b) { return a.v - b.v; }
  friend LaneBits operator&(LaneBits a, LaneBits b) { return a.v & b.v; }
  friend LaneBits operator|(LaneBits a, LaneBits b) { return a.v | b.v; }
  friend LaneBits operator^(LaneBits a, LaneBits b) { return a.v ^ b.v; }
  friend LaneBits operator<<(LaneBits a, int n) { return a.v << n; }
  friend LaneBits operator>>(LaneBits a, int n) { return a.v >> n; }
};

/// One truth value per lane, all bits set where true.
struct LaneMask {
  using Vector = std::int64_t __attribute__((vector_size(32)));
  Vector v;

  friend LaneMask operator&(LaneMask a, LaneMask b) { return {a.v & b.v}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.v | b.v}; }
  friend LaneMask operator!(LaneMask a) { return {~a.v}; }
};

/// Four trials side by side (AVX2).
struct Lanes {
  using Vector = double __attribute__((vector_size(32)));
  Vector v;

  Lanes() = default;
  Lanes(Vector x) : v(x) {}             // NOLINT: a vector is its lanes
  Lanes(double x) : v(Vector{} + x) {}  // NOLINT: constants mix freely

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend Lanes operator-(Lanes a) { return -a.v; }
  friend LaneMask operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
  friend LaneMask operator<=(Lanes a, Lanes b) { return {a.v <= b.v}; }
  friend LaneMask operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
};

template <class T>
inline constexpr int lane_count = 1;
template <>
inline constexpr int lane_count<Lanes> = 4;
static_assert(kGroup % lane_count<Lanes> == 0);

/// The integer companion of T.
template <class T>
struct BitsOf;
template <>
struct BitsOf<double> {
  using type = std::uint64_t;
};
template <>
struct BitsOf<Lanes> {
  using type = LaneBits;
};
template <class T>
using Bits = typename BitsOf<T>::type;

// --- the vocabulary of kernels: scalar version, then lanes ---

inline double lane(double x, int) { return x; }
inline double lane(const Lanes& x, int i) { return x.v[i]; }
inline bool lane(bool x, int) { return x; }
inline bool lane(const LaneMask& x, int i) { return x.v[i] != 0; }

template <class T>
T load(const double* p) {
  if constexpr (lane_count<T> == 1)
    return *p;
  else
    return T(typename T::Vector(_mm256_loadu_pd(p)));
}
inline void store(double* p, double x) { *p = x; }
inline void store(double* p, const Lanes& x) { _mm256_storeu_pd(p, x.v); }

inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline Lanes fma(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(_mm256_fmadd_pd(a.v, b.v, c.v)); }
inline double sqrt(double x) { return __builtin_sqrt(x); }
inline Lanes sqrt(Lanes x) { return Lanes::Vector(_mm256_sqrt_pd(x.v)); }
inline double abs(double x) { return __builtin_fabs(x); }
inline Lanes abs(Lanes x) { return Lanes::Vector(_mm256_andnot_pd(_mm256_set1_pd(-0.0), x.v)); }

inline double select(bool c, double a, double b) { return c ? a : b; }
inline Lanes select(LaneMask c, Lanes a, Lanes b) { return c.v ? a.v : b.v; }
inline double max(double a, double b) { return a > b ? a : b; }
inline Lanes max(Lanes a, Lanes b) { return select(a > b, a, b); }
inline bool any(bool c) { return c; }
inline bool any(LaneMask c) { return _mm256_movemask_pd(_mm256_castsi256_pd(__m256i(c.v))) != 0; }
inline bool all(bool c) { return c; }
inline bool all(LaneMask c) { return _mm256_movemask_pd(_mm256_castsi256_pd(__m256i(c.v))) == 15; }

inline std::uint64_t to_bits(double x) { return __builtin_bit_cast(std::uint64_t, x); }
inline LaneBits to_bits(Lanes x) { return LaneBits::Vector(x.v); }
inline double from_bits(std::uint64_t x) { return __builtin_bit_cast(double, x); }
inline Lanes from_bits(LaneBits x) { return Lanes::Vector(x.v); }
inline bool equal(std::uint64_t a, std::uint64_t b) { return a == b; }
inline LaneMask equal(LaneBits a, LaneBits b) { return {a.v == b.v}; }

/// Exact double of an integer below 2^52.
inline double small_to_double(std::uint64_t x) { return from_bits(x | 0x4330000000000000u) - 0x1p52; }
inline Lanes small_to_double(LaneBits x) { return from_bits(x | 0x4330000000000000u) - 0x1p52; }

/// 64-bit product of the low 32 bits of each operand.
inline std::uint64_t multiply_low32(std::uint64_t a, std::uint64_t b) { return (a & 0xffffffffu) * (b & 0xffffffffu); }
inline LaneBits multiply_low32(LaneBits a, LaneBits b) {
  return LaneBits::Vector(_mm256_mul_epu32(__m256i(a.v), __m256i(b.v)));
}

/// first, first + 1, ...: the numbers of the trials in the lanes.
template <class T>
Bits<T> consecutive(std::uint64_t first) {
  if constexpr (lane_count<T> == 1)
    return first;
  else
    return LaneBits(first) + LaneBits(LaneBits::Vector{0, 1, 2, 3});
}

}  // namespace surveymc
