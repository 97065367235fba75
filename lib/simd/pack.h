#pragma once
/// Several registers worked on in turn. One long chain of operations leaves the processor waiting for results; N chains
/// side by side, operation by operation, fill these gaps. Elementwise like Lanes: element i of a Pack has bit for bit
/// the result of a kernel called with element i alone.
#include <concepts>

#include "simd/lanes.h"

namespace surveymc::simd {

/// Of numbers (T = double, Lanes) or of their bits (T = std::uint64_t, LaneBits): the operators are those of T.
template <class T, std::size_t N>
struct Pack {
  T v[N];

  Pack() = default;
  template <std::convertible_to<T> S>
  Pack(const S& x) : Pack(each([&](std::size_t) -> T { return x; })) {}  // NOLINT: constants mix freely

  /// f(0), f(1), ... as the elements of a Pack.
  template <class F>
  [[gnu::always_inline]] static Pack each(const F& f) {
    Pack r;
#pragma GCC unroll 16
    for (std::size_t i = 0; i < N; ++i) r.v[i] = f(i);
    return r;
  }

  // clang-format off
  friend Pack operator+(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] + b.v[i]; }); }
  friend Pack operator-(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] - b.v[i]; }); }
  friend Pack operator*(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] * b.v[i]; }); }
  friend Pack operator/(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] / b.v[i]; }); }
  friend Pack operator&(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] & b.v[i]; }); }
  friend Pack operator|(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] | b.v[i]; }); }
  friend Pack operator^(const Pack& a, const Pack& b) { return each([&](std::size_t i) { return a.v[i] ^ b.v[i]; }); }
  friend Pack operator<<(const Pack& a, int n) { return each([&](std::size_t i) { return a.v[i] << n; }); }
  friend Pack operator>>(const Pack& a, int n) { return each([&](std::size_t i) { return a.v[i] >> n; }); }
  // clang-format on
};

template <class T, std::size_t N>
struct BitsOf<Pack<T, N>> {
  using type = Pack<Bits<T>, N>;
};

template <class T, std::size_t N>
Pack<T, N> fma(const Pack<T, N>& a, const Pack<T, N>& b, const Pack<T, N>& c) {
  return Pack<T, N>::each([&](std::size_t i) { return fma(a.v[i], b.v[i], c.v[i]); });
}
template <class T, std::size_t N>
Pack<T, N> sqrt(const Pack<T, N>& a) {
  return Pack<T, N>::each([&](std::size_t i) { return sqrt(a.v[i]); });
}
template <class T, std::size_t N>
Pack<T, N> abs(const Pack<T, N>& a) {
  return Pack<T, N>::each([&](std::size_t i) { return abs(a.v[i]); });
}
template <class T, std::size_t N>
Pack<Bits<T>, N> to_bits(const Pack<T, N>& a) {
  return Pack<Bits<T>, N>::each([&](std::size_t i) { return to_bits(a.v[i]); });
}
template <class B, std::size_t N>
auto from_bits(const Pack<B, N>& a) {
  return Pack<decltype(from_bits(a.v[0])), N>::each([&](std::size_t i) { return from_bits(a.v[i]); });
}
template <class B, std::size_t N>
auto small_to_double(const Pack<B, N>& a) {
  return Pack<decltype(small_to_double(a.v[0])), N>::each([&](std::size_t i) { return small_to_double(a.v[i]); });
}
template <class B, std::size_t N>
Pack<B, N> multiply_low32(const Pack<B, N>& a, const Pack<B, N>& b) {
  return Pack<B, N>::each([&](std::size_t i) { return multiply_low32(a.v[i], b.v[i]); });
}
template <class B, std::size_t N>
Pack<B, N> xor3(const Pack<B, N>& a, const Pack<B, N>& b, const Pack<B, N>& c) {
  return Pack<B, N>::each([&](std::size_t i) { return xor3(a.v[i], b.v[i], c.v[i]); });
}

}  // namespace surveymc::simd
