#pragma once
/// Single precision: two numbers in the place of one double. Random normals use it, because they need no more precision
/// and take only 0.6 of the time (docs/performance.md). Arithmetic is elementwise IEEE like that of Lanes, so
/// element i has the same bits on every instruction set and in a Pack.
#include "simd/lanes.h"
#include "simd/pack.h"

namespace surveymc::simd {
inline namespace SURVEYMC_ISA {

/// Vectors of N elements of 32 bits.
template <int N>
struct Vectors32;
template <>
struct Vectors32<2> {
  using Float = float __attribute__((vector_size(8)));
  using Unsigned = std::uint32_t __attribute__((vector_size(8)));
  using Signed = std::int32_t __attribute__((vector_size(8)));
};
template <>
struct Vectors32<2 * SURVEYMC_LANES> {
  using Float = float __attribute__((vector_size(8 * SURVEYMC_LANES)));
  using Unsigned = std::uint32_t __attribute__((vector_size(8 * SURVEYMC_LANES)));
  using Signed = std::int32_t __attribute__((vector_size(8 * SURVEYMC_LANES)));
};

/// 32-bit words, N side by side.
template <int N>
struct Words32 {
  using Vector = typename Vectors32<N>::Unsigned;
  Vector v;

  Words32() = default;
  Words32(Vector x) : v(x) {}                    // NOLINT: a vector is its elements
  Words32(std::uint32_t x) : v(Vector{} + x) {}  // NOLINT: constants mix freely

  friend Words32 operator+(Words32 a, Words32 b) { return a.v + b.v; }
  friend Words32 operator&(Words32 a, Words32 b) { return a.v & b.v; }
  friend Words32 operator|(Words32 a, Words32 b) { return a.v | b.v; }
  friend Words32 operator^(Words32 a, Words32 b) { return a.v ^ b.v; }
  friend Words32 operator<<(Words32 a, int n) { return a.v << n; }
  friend Words32 operator>>(Words32 a, int n) { return a.v >> n; }
};

/// Single-precision numbers, N side by side.
template <int N>
struct Singles {
  using Vector = typename Vectors32<N>::Float;
  Vector v;

  Singles() = default;
  Singles(Vector x) : v(x) {}            // NOLINT: a vector is its elements
  Singles(float x) : v(Vector{} + x) {}  // NOLINT: constants mix freely

  friend Singles operator+(Singles a, Singles b) { return a.v + b.v; }
  friend Singles operator-(Singles a, Singles b) { return a.v - b.v; }
  friend Singles operator*(Singles a, Singles b) { return a.v * b.v; }
  friend Singles operator-(Singles a) { return -a.v; }
};

/// The singles, and the 32-bit words, that lie in the place of T.
template <class T>
struct SinglesOf {
  using type = Singles<2 * lane_count<T>>;
  using words = Words32<2 * lane_count<T>>;
};

template <int N>
Singles<N> fma(Singles<N> a, Singles<N> b, Singles<N> c) {
#if SURVEYMC_LANES == 8
  if constexpr (N == 16) return typename Singles<N>::Vector(_mm512_fmadd_ps(a.v, b.v, c.v));
#elif SURVEYMC_LANES == 2
#if defined(__aarch64__)
  if constexpr (N == 4) return typename Singles<N>::Vector(vfmaq_f32(c.v, a.v, b.v));
#endif
#else
  if constexpr (N == 8) return typename Singles<N>::Vector(_mm256_fmadd_ps(a.v, b.v, c.v));
#endif
  for (int i = 0; i < N; ++i) c.v[i] = __builtin_fmaf(a.v[i], b.v[i], c.v[i]);
  return c;
}
template <int N>
Singles<N> sqrt(Singles<N> a) {
#if SURVEYMC_LANES == 8
  if constexpr (N == 16) return typename Singles<N>::Vector(_mm512_maskz_sqrt_ps(0xffff, a.v));
#elif SURVEYMC_LANES == 2
#if defined(__aarch64__)
  if constexpr (N == 4) return typename Singles<N>::Vector(vsqrtq_f32(a.v));
#endif
#else
  if constexpr (N == 8) return typename Singles<N>::Vector(_mm256_sqrt_ps(a.v));
#endif
  for (int i = 0; i < N; ++i) a.v[i] = __builtin_sqrtf(a.v[i]);
  return a;
}
template <int N>
Words32<N> to_words(Singles<N> a) {
  return typename Words32<N>::Vector(a.v);
}
template <int N>
Singles<N> from_words(Words32<N> a) {
  return typename Singles<N>::Vector(a.v);
}
/// Nearest single to a word below 2^31.
template <int N>
Singles<N> nearest_single(Words32<N> a) {
  using Signed = typename Vectors32<N>::Signed;
  return __builtin_convertvector(Signed(a.v), typename Singles<N>::Vector);
}
/// a >= bound ? x : y, for a below 2^31.
template <int N>
Singles<N> select_from(Words32<N> a, std::uint32_t bound, Singles<N> x, Singles<N> y) {
  using Signed = typename Vectors32<N>::Signed;
  return Signed(a.v) >= Signed(Words32<N>(bound).v) ? x.v : y.v;
}

/// The low halves of a and b, a's below b's.
inline Words32<2> join(std::uint64_t a, std::uint64_t b) {
  return __builtin_bit_cast(Words32<2>::Vector, (a & 0xffffffffu) | (b << 32));
}
inline Words32<2 * SURVEYMC_LANES> join(LaneBits a, LaneBits b) {
  return Words32<2 * SURVEYMC_LANES>::Vector(((a & 0xffffffffu) | (b << 32)).v);
}

/// The lower, and the upper, of the two singles in each place.
inline double lower(Singles<2> a) { return static_cast<double>(a.v[0]); }
inline double upper(Singles<2> a) { return static_cast<double>(a.v[1]); }
#if SURVEYMC_LANES == 8
inline Lanes lower(Singles<16> a) {
  const __m256i low = _mm512_maskz_cvtepi64_epi32(0xff, __m512i(a.v));
  return Lanes::Vector(_mm512_maskz_cvtps_pd(0xff, __m256(low)));
}
inline Lanes upper(Singles<16> a) { return lower(Singles<16>::Vector(LaneBits::Vector(a.v) >> 32)); }
#elif SURVEYMC_LANES == 2
inline Lanes lower(Singles<4> a) { return Lanes::Vector{a.v[0], a.v[2]}; }
inline Lanes upper(Singles<4> a) { return Lanes::Vector{a.v[1], a.v[3]}; }
#else
inline Lanes lower(Singles<8> a) {
  const __m256i even = _mm256_permutevar8x32_epi32(__m256i(a.v), _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
  return Lanes::Vector(_mm256_cvtps_pd(_mm256_castps256_ps128(__m256(even))));
}
inline Lanes upper(Singles<8> a) {
  const __m256i odd = _mm256_permutevar8x32_epi32(__m256i(a.v), _mm256_setr_epi32(1, 3, 5, 7, 1, 3, 5, 7));
  return Lanes::Vector(_mm256_cvtps_pd(_mm256_castps256_ps128(__m256(odd))));
}
#endif

}  // namespace SURVEYMC_ISA

template <class T, std::size_t N>
struct SinglesOf<Pack<T, N>> {
  using type = Pack<typename SinglesOf<T>::type, N>;
  using words = Pack<typename SinglesOf<T>::words, N>;
};

// --- the same functions for each element of a Pack ---

template <class W, std::size_t N>
auto from_words(const Pack<W, N>& a) {
  return Pack<decltype(from_words(a.v[0])), N>::each([&](std::size_t i) { return from_words(a.v[i]); });
}
template <class S, std::size_t N>
auto to_words(const Pack<S, N>& a) {
  return Pack<decltype(to_words(a.v[0])), N>::each([&](std::size_t i) { return to_words(a.v[i]); });
}
template <class W, std::size_t N>
auto nearest_single(const Pack<W, N>& a) {
  return Pack<decltype(nearest_single(a.v[0])), N>::each([&](std::size_t i) { return nearest_single(a.v[i]); });
}
template <class W, class S, std::size_t N>
Pack<S, N> select_from(const Pack<W, N>& a, std::uint32_t bound, const Pack<S, N>& x, const Pack<S, N>& y) {
  return Pack<S, N>::each([&](std::size_t i) { return select_from(a.v[i], bound, x.v[i], y.v[i]); });
}
template <class B, std::size_t N>
auto join(const Pack<B, N>& a, const Pack<B, N>& b) {
  return Pack<decltype(join(a.v[0], b.v[0])), N>::each([&](std::size_t i) { return join(a.v[i], b.v[i]); });
}
template <class S, std::size_t N>
auto lower(const Pack<S, N>& a) {
  return Pack<decltype(lower(a.v[0])), N>::each([&](std::size_t i) { return lower(a.v[i]); });
}
template <class S, std::size_t N>
auto upper(const Pack<S, N>& a) {
  return Pack<decltype(upper(a.v[0])), N>::each([&](std::size_t i) { return upper(a.v[i]); });
}

// --- elementary functions ---

/// -ln u for u in (0, 1], also given u - 1: near 1 the logarithm depends on u - 1, most of whose digits u has lost.
/// Relative error below 2e-7.
template <class W, class S>
[[gnu::always_inline]] inline S minus_log(const S& u, const S& u_less_1) {
  // u = 2^e (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)): adding the gap from sqrt(1/2) to 1 carries at sqrt(2)
  constexpr std::uint32_t kOne = 0x3f800000u, kRootHalf = 0x3f3504f3u;
  const W shifted = to_words(u) + W(kOne - kRootHalf);
  const S e = nearest_single(shifted >> 23) - S(127.0f);
  const S mantissa = from_words((shifted & W(0x007fffffu)) + W(kRootHalf));
  const S f = select_from(shifted, kOne, u_less_1, mantissa - S(1.0f));
  // (f - f^2/2 - ln(1 + f)) / f^3: minimax for the relative error of the logarithm, 6e-9
  S p = S(0.0763977617f);
  p = fma(f, p, S(-0.127649978f));
  p = fma(f, p, S(0.131596386f));
  p = fma(f, p, S(-0.142011553f));
  p = fma(f, p, S(0.166233554f));
  p = fma(f, p, S(-0.200012594f));
  p = fma(f, p, S(0.250008225f));
  p = fma(f, p, S(-0.333333313f));
  return fma(e, S(-0.693147182f), fma(f * f, fma(f, p, S(0.5f)), S(0.0f) - f));
}

/// {sin x, cos x} for |x| <= pi/4. Errors below 1e-7.
template <class S>
[[gnu::always_inline]] inline std::pair<S, S> sincos_single(const S& x) {
  // Minimax, 4e-9 and 7e-11
  const S z = x * x;
  const S s = fma(z, fma(z, S(-0.000195171998f), S(0.00833217055f)), S(-0.166666552f));
  const S c = fma(z, fma(z, S(2.44234429e-05f), S(-0.00138872128f)), S(0.0416666418f));
  return {fma(x * z, s, x), fma(z * z, c, fma(z, S(-0.5f), S(1.0f)))};
}

}  // namespace surveymc::simd
