/// Loops that do one thing as fast as the machine can. hide() and use() are empty instructions: the compiler may not
/// look through them, so nothing is computed beforehand or left out.
#include "bench_kernels.h"

namespace surveymc::bench::SURVEYMC_ISA {
namespace {

using T = simd::Lanes;
constexpr int kPerRound = Ceilings::kPerRound;

template <class V>
void hide(V& x) {
  asm volatile("" : "+x"(x.v));
}
template <class V>
void use(const V& x) {
  asm volatile("" : : "x"(x.v));
}

/// In each round: a[i] = a[i] / 2 + 1 for Chains registers, and one addition for each of the first `Additions`.
template <int Chains, int Additions>
void fused_in_chains(int count) {
  T a[Chains], half(0.5), one(1.0), x(1.2345678);
  hide(half);
  hide(one);
#pragma GCC unroll 24
  for (int i = 0; i < Chains; ++i) hide(a[i] = one);
  for (int n = 0; n < count; ++n)
#pragma GCC unroll 24
    for (int i = 0; i < Chains; ++i) {
      a[i] = simd::fma(a[i], half, one);
      if (i < Additions) {
        hide(x);
        use(x + one);
      }
    }
#pragma GCC unroll 24
  for (int i = 0; i < Chains; ++i) use(a[i]);
}

void fused_multiply_add(int count) { fused_in_chains<kPerRound / 2, 0>(2 * count); }
void fused_and_add(int count) { fused_in_chains<kPerRound / 2, kPerRound / 2>(count); }

void divide(int count) {
  T x(1.2345678), one(1.0);
  for (int n = 0; n < count; ++n)
#pragma GCC unroll 24
    for (int i = 0; i < kPerRound; ++i) {
      hide(x);
      use(one / x);
    }
}

void square_root(int count) {
  T x(1.2345678);
  for (int n = 0; n < count; ++n)
#pragma GCC unroll 24
    for (int i = 0; i < kPerRound; ++i) {
      hide(x);
      use(simd::sqrt(x));
    }
}

void multiply_integers(int count) {
  simd::LaneBits x(0x12345678), y(0xD2511F53);
  for (int n = 0; n < count; ++n)
#pragma GCC unroll 24
    for (int i = 0; i < kPerRound; ++i) {
      hide(x);
      use(simd::multiply_low32(x, y));
    }
}

void load_all(const double* p, std::size_t n) {
  constexpr std::size_t step = simd::lane_count<T>;
  for (std::size_t k = 0; k < n; k += 8 * step)
#pragma GCC unroll 8
    for (std::size_t i = 0; i < 8; ++i) use(simd::load<T>(p + k + i * step));
}

void triad(double* a, const double* b, const double* c, std::size_t n) {
  for (std::size_t k = 0; k < n; k += simd::lane_count<T>)
    simd::store(a + k, simd::fma(T(0.5), simd::load<T>(c + k), simd::load<T>(b + k)));
}

}  // namespace

const Ceilings ceilings{simd::lane_count<T>, fused_multiply_add, fused_and_add, divide,
                        square_root,         multiply_integers,  load_all,      triad};

}  // namespace surveymc::bench::SURVEYMC_ISA
