#pragma once
/// A scalar for kernels that counts what is done with it: the operations of a kernel, from its own text.
#include "simd/lanes.h"
#include "simd/math.h"

namespace surveymc::bench {

/// Elementary operations so far. Signs that are turned are not counted: they are free in a fused operation.
struct Operations {
  double add = 0, multiply = 0, fma = 0, divide = 0, root = 0, compare = 0, integer = 0, integer_multiply = 0;
};
inline Operations operations;

struct CountedBits {
  std::uint64_t v = 0;
  CountedBits() = default;
  CountedBits(std::uint64_t x) : v(x) {}  // NOLINT: constants mix freely

  static CountedBits counted(std::uint64_t x) { return ++operations.integer, CountedBits(x); }
  friend CountedBits operator+(CountedBits a, CountedBits b) { return counted(a.v + b.v); }
  friend CountedBits operator-(CountedBits a, CountedBits b) { return counted(a.v - b.v); }
  friend CountedBits operator&(CountedBits a, CountedBits b) { return counted(a.v & b.v); }
  friend CountedBits operator|(CountedBits a, CountedBits b) { return counted(a.v | b.v); }
  friend CountedBits operator^(CountedBits a, CountedBits b) { return counted(a.v ^ b.v); }
  friend CountedBits operator<<(CountedBits a, int n) { return counted(a.v << n); }
  friend CountedBits operator>>(CountedBits a, int n) { return counted(a.v >> n); }
  friend bool odd(CountedBits a) { return ++operations.compare, (a.v & 1) != 0; }
  friend CountedBits xor3(CountedBits a, CountedBits b, CountedBits c) { return a ^ b ^ c; }
  friend CountedBits multiply_low32(CountedBits a, CountedBits b) {
    return ++operations.integer_multiply, CountedBits(surveymc::multiply_low32(a.v, b.v));
  }
};

struct Counted {
  double v = 0;
  Counted() = default;
  Counted(double x) : v(x) {}  // NOLINT: constants mix freely

  friend Counted operator+(Counted a, Counted b) { return ++operations.add, Counted(a.v + b.v); }
  friend Counted operator-(Counted a, Counted b) { return ++operations.add, Counted(a.v - b.v); }
  friend Counted operator*(Counted a, Counted b) { return ++operations.multiply, Counted(a.v * b.v); }
  friend Counted operator/(Counted a, Counted b) { return ++operations.divide, Counted(a.v / b.v); }
  friend Counted operator-(Counted a) { return Counted(-a.v); }
  friend Counted fma(Counted a, Counted b, Counted c) {
    return ++operations.fma, Counted(surveymc::fma(a.v, b.v, c.v));
  }
  friend Counted fms(Counted a, Counted b, Counted c) { return fma(a, b, -c); }
  friend Counted sqrt(Counted a) { return ++operations.root, Counted(surveymc::sqrt(a.v)); }
  friend Counted abs(Counted a) { return ++operations.integer, Counted(surveymc::abs(a.v)); }
  friend Counted max(Counted a, Counted b) { return select(a > b, a, b); }
  friend bool operator<(Counted a, Counted b) { return ++operations.compare, a.v < b.v; }
  friend bool operator<=(Counted a, Counted b) { return ++operations.compare, a.v <= b.v; }
  friend bool operator>(Counted a, Counted b) { return ++operations.compare, a.v > b.v; }
  friend Counted select(bool c, Counted a, Counted b) { return ++operations.compare, c ? a : b; }
  friend CountedBits to_bits(Counted a) { return surveymc::to_bits(a.v); }
};
inline Counted from_bits(CountedBits a) { return surveymc::from_bits(a.v); }
inline Counted small_to_double(CountedBits a) {
  return ++operations.integer, ++operations.add, Counted(surveymc::small_to_double(a.v));
}

}  // namespace surveymc::bench

template <>
struct surveymc::BitsOf<surveymc::bench::Counted> {
  using type = bench::CountedBits;
};
