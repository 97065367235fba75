#pragma once
/// Lanes: several trials side by side in one vector register. Only this file knows how many there are, and which
/// instructions compute them.
///
/// A kernel is written once, as `template <class T>`, and is called with T = double (one trial: tests, replay),
/// T = Lanes (one trial per lane) or T = Dual<...> (derivatives). It has no `if` on a T: use select(). All arithmetic
/// is elementwise IEEE, fused only where fma() is written, so lane i of a Lanes result is bit for bit the double
/// result of trial i, on every instruction set.
///
/// Kernel files (`*_lanes.cpp`) are compiled twice, for x86-64-v3 (AVX2: 4 lanes) and x86-64-v4 (AVX-512: 8 lanes); the
/// program chooses when it runs (instruction_set.h). Code that depends on the width lives in an inline namespace of its
/// own, so that the linker cannot mix the two versions. Kernel files therefore use no inline function of other headers
/// but templates on T.
///
/// A portable build (SURVEYMC_PORTABLE, for other processors than x86-64) has two lanes and compiles kernel files once,
/// in the place of x86-64-v3. It uses the vectors of the compiler, and NEON for what these lack.
/// tests/simd/lane_bits.cpp compares the variants bit by bit.
#include <cmath>
#include <cstdint>

#if !defined(SURVEYMC_PORTABLE)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace surveymc::simd {

/// Trials lie in memory in groups of this many, whatever the width of a register. So the layout, and with it every sum
/// over trials, is the same on all machines.
inline constexpr int kGroup = 8;

#if defined(SURVEYMC_PORTABLE)
#define SURVEYMC_ISA isa_v3
#define SURVEYMC_LANES 2
#elif defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
#define SURVEYMC_ISA isa_v4
#define SURVEYMC_LANES 8
#else
#define SURVEYMC_ISA isa_v3
#define SURVEYMC_LANES 4
#endif

inline namespace SURVEYMC_ISA {

/// 64-bit integers beside Lanes: random words and bit patterns.
struct LaneBits {
  using Vector = std::uint64_t __attribute__((vector_size(8 * SURVEYMC_LANES)));
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

/// One truth value per lane.
struct LaneMask {
#if SURVEYMC_LANES == 8
  __mmask8 m;
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {static_cast<__mmask8>(a.m & b.m)}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {static_cast<__mmask8>(a.m | b.m)}; }
  friend LaneMask operator!(LaneMask a) { return {static_cast<__mmask8>(~a.m)}; }
#elif SURVEYMC_LANES == 2
  using Vector = std::int64_t __attribute__((vector_size(16)));
  Vector m;  // all bits of a lane set where true
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {a.m & b.m}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.m | b.m}; }
  friend LaneMask operator!(LaneMask a) { return {~a.m}; }
#else
  __m256d m;  // all bits of a lane set where true
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {_mm256_and_pd(a.m, b.m)}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {_mm256_or_pd(a.m, b.m)}; }
  friend LaneMask operator!(LaneMask a) { return {_mm256_xor_pd(a.m, _mm256_castsi256_pd(_mm256_set1_epi64x(-1)))}; }
#endif
};

/// Trials side by side, as many as a register holds.
struct Lanes {
  using Vector = double __attribute__((vector_size(8 * SURVEYMC_LANES)));
  Vector v;

  Lanes() = default;
  Lanes(Vector x) : v(x) {}             // NOLINT: a vector is its lanes
  Lanes(double x) : v(Vector{} + x) {}  // NOLINT: constants mix freely

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend Lanes operator-(Lanes a) { return -a.v; }
#if SURVEYMC_LANES == 8
  friend LaneMask operator<(Lanes a, Lanes b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ)}; }
  friend LaneMask operator<=(Lanes a, Lanes b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LE_OQ)}; }
#elif SURVEYMC_LANES == 2
  friend LaneMask operator<(Lanes a, Lanes b) { return {LaneMask::Vector(a.v < b.v)}; }
  friend LaneMask operator<=(Lanes a, Lanes b) { return {LaneMask::Vector(a.v <= b.v)}; }
#else
  friend LaneMask operator<(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
  friend LaneMask operator<=(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
#endif
  friend LaneMask operator>(Lanes a, Lanes b) { return b < a; }
};

template <class T>
inline constexpr int lane_count = 1;
template <>
inline constexpr int lane_count<Lanes> = SURVEYMC_LANES;
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

template <class T>
T load(const double* p) {
  if constexpr (lane_count<T> == 1) {
    return *p;
  } else {
    T x;
    __builtin_memcpy(&x.v, p, sizeof x.v);
    return x;
  }
}
inline void store(double* p, double x) { *p = x; }
inline void store(double* p, const Lanes& x) { __builtin_memcpy(p, &x.v, sizeof x.v); }

inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline double fms(double a, double b, double c) { return __builtin_fma(a, b, -c); }  ///< a b - c, rounded once
inline double sqrt(double x) { return __builtin_sqrt(x); }
inline double abs(double x) { return __builtin_fabs(x); }
inline double select(bool c, double a, double b) { return c ? a : b; }
inline bool any(bool c) { return c; }
inline bool all(bool c) { return c; }
#if SURVEYMC_LANES == 8
inline bool lane(const LaneMask& x, int i) { return ((x.m >> i) & 1) != 0; }
inline Lanes fma(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(_mm512_fmadd_pd(a.v, b.v, c.v)); }
inline Lanes fms(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(_mm512_fmsub_pd(a.v, b.v, c.v)); }
// maskz with all lanes: the plain intrinsics warn of uninitialised values in GCC 12's own header (GCC bug 105593)
inline Lanes sqrt(Lanes x) { return Lanes::Vector(_mm512_maskz_sqrt_pd(0xff, x.v)); }
inline Lanes select(LaneMask c, Lanes a, Lanes b) { return Lanes::Vector(_mm512_mask_blend_pd(c.m, b.v, a.v)); }
inline bool any(LaneMask c) { return c.m != 0; }
inline bool all(LaneMask c) { return c.m == 0xff; }
#elif SURVEYMC_LANES == 2
inline bool lane(const LaneMask& x, int i) { return x.m[i] != 0; }
#if defined(__aarch64__)
inline Lanes fma(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(vfmaq_f64(c.v, a.v, b.v)); }
inline Lanes sqrt(Lanes x) { return Lanes::Vector(vsqrtq_f64(x.v)); }
#else
inline Lanes fma(Lanes a, Lanes b, Lanes c) {
  return Lanes::Vector{__builtin_fma(a.v[0], b.v[0], c.v[0]), __builtin_fma(a.v[1], b.v[1], c.v[1])};
}
inline Lanes sqrt(Lanes x) { return Lanes::Vector{__builtin_sqrt(x.v[0]), __builtin_sqrt(x.v[1])}; }
#endif
inline Lanes fms(Lanes a, Lanes b, Lanes c) { return fma(a, b, -c); }
inline Lanes select(LaneMask c, Lanes a, Lanes b) { return Lanes::Vector(c.m ? a.v : b.v); }
inline bool any(LaneMask c) { return (c.m[0] | c.m[1]) != 0; }
inline bool all(LaneMask c) { return (c.m[0] & c.m[1]) != 0; }
#else
inline bool lane(const LaneMask& x, int i) { return ((_mm256_movemask_pd(x.m) >> i) & 1) != 0; }
inline Lanes fma(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(_mm256_fmadd_pd(a.v, b.v, c.v)); }
inline Lanes fms(Lanes a, Lanes b, Lanes c) { return Lanes::Vector(_mm256_fmsub_pd(a.v, b.v, c.v)); }
inline Lanes sqrt(Lanes x) { return Lanes::Vector(_mm256_sqrt_pd(x.v)); }
inline Lanes select(LaneMask c, Lanes a, Lanes b) { return Lanes::Vector(_mm256_blendv_pd(b.v, a.v, c.m)); }
inline bool any(LaneMask c) { return _mm256_movemask_pd(c.m) != 0; }
inline bool all(LaneMask c) { return _mm256_movemask_pd(c.m) == 15; }
#endif
inline Lanes abs(Lanes x) { return Lanes::Vector(LaneBits::Vector(x.v) & 0x7fffffffffffffffu); }
inline double max(double a, double b) { return a > b ? a : b; }
inline Lanes max(Lanes a, Lanes b) { return select(a > b, a, b); }

inline std::uint64_t to_bits(double x) { return __builtin_bit_cast(std::uint64_t, x); }
inline LaneBits to_bits(Lanes x) { return LaneBits::Vector(x.v); }
inline double from_bits(std::uint64_t x) { return __builtin_bit_cast(double, x); }
inline Lanes from_bits(LaneBits x) { return Lanes::Vector(x.v); }
/// Lowest bit set?
inline bool odd(std::uint64_t a) { return (a & 1) != 0; }
#if SURVEYMC_LANES == 8
inline LaneMask odd(LaneBits a) { return {_mm512_test_epi64_mask(__m512i(a.v), _mm512_set1_epi64(1))}; }
#elif SURVEYMC_LANES == 2
inline LaneMask odd(LaneBits a) { return {LaneMask::Vector((a.v & 1) != 0)}; }
#else
inline LaneMask odd(LaneBits a) { return {_mm256_castsi256_pd(__m256i(a.v << 63))}; }  // blendv looks at the sign
#endif

/// Exact double of an integer below 2^52.
inline double small_to_double(std::uint64_t x) { return from_bits(x | 0x4330000000000000u) - 0x1p52; }
inline Lanes small_to_double(LaneBits x) { return from_bits(x | 0x4330000000000000u) - 0x1p52; }

/// 64-bit product of the low 32 bits of each operand.
inline std::uint64_t multiply_low32(std::uint64_t a, std::uint64_t b) { return (a & 0xffffffffu) * (b & 0xffffffffu); }
inline LaneBits multiply_low32(LaneBits a, LaneBits b) {
#if SURVEYMC_LANES == 8
  return LaneBits::Vector(_mm512_maskz_mul_epu32(0xff, __m512i(a.v), __m512i(b.v)));
#elif SURVEYMC_LANES == 2
#if defined(__aarch64__)
  return LaneBits::Vector(vmull_u32(vmovn_u64(uint64x2_t(a.v)), vmovn_u64(uint64x2_t(b.v))));
#else
  return (a.v & 0xffffffffu) * (b.v & 0xffffffffu);
#endif
#else
  return LaneBits::Vector(_mm256_mul_epu32(__m256i(a.v), __m256i(b.v)));
#endif
}

/// a ^ b ^ c: one instruction where there is one for it.
inline std::uint64_t xor3(std::uint64_t a, std::uint64_t b, std::uint64_t c) { return a ^ b ^ c; }
inline LaneBits xor3(LaneBits a, LaneBits b, LaneBits c) {
#if SURVEYMC_LANES == 8
  return LaneBits::Vector(_mm512_ternarylogic_epi64(__m512i(a.v), __m512i(b.v), __m512i(c.v), 0x96));
#else
  return a ^ b ^ c;
#endif
}

/// first, first + 1, ...: the numbers of the trials in the lanes.
template <class T>
Bits<T> consecutive(std::uint64_t first) {
  if constexpr (lane_count<T> == 1)
    return first;
  else
#if SURVEYMC_LANES == 8
    return LaneBits(first) + LaneBits(LaneBits::Vector{0, 1, 2, 3, 4, 5, 6, 7});
#elif SURVEYMC_LANES == 2
    return LaneBits(first) + LaneBits(LaneBits::Vector{0, 1});
#else
    return LaneBits(first) + LaneBits(LaneBits::Vector{0, 1, 2, 3});
#endif
}

}  // namespace SURVEYMC_ISA
}  // namespace surveymc::simd
