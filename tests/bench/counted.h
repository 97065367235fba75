#pragma once
/// A scalar for kernels that counts what is done with it: the operations of a kernel, from its own text.
#include "simd/lanes.h"
#include "simd/math.h"
#include "simd/singles.h"

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
    return ++operations.integer_multiply, CountedBits(surveymc::simd::multiply_low32(a.v, b.v));
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
    return ++operations.fma, Counted(surveymc::simd::fma(a.v, b.v, c.v));
  }
  friend Counted fms(Counted a, Counted b, Counted c) { return fma(a, b, -c); }
  friend Counted sqrt(Counted a) { return ++operations.root, Counted(surveymc::simd::sqrt(a.v)); }
  friend Counted abs(Counted a) { return ++operations.integer, Counted(surveymc::simd::abs(a.v)); }
  friend Counted max(Counted a, Counted b) { return select(a > b, a, b); }
  friend bool operator<(Counted a, Counted b) { return ++operations.compare, a.v < b.v; }
  friend bool operator<=(Counted a, Counted b) { return ++operations.compare, a.v <= b.v; }
  friend bool operator>(Counted a, Counted b) { return ++operations.compare, a.v > b.v; }
  friend Counted select(bool c, Counted a, Counted b) { return ++operations.compare, c ? a : b; }
  friend CountedBits to_bits(Counted a) { return surveymc::simd::to_bits(a.v); }
};
inline Counted from_bits(CountedBits a) { return surveymc::simd::from_bits(a.v); }
inline Counted small_to_double(CountedBits a) {
  return ++operations.integer, ++operations.add, Counted(surveymc::simd::small_to_double(a.v));
}

/// Two singles in the place of one double, and their words: an operation on both counts once, as it takes one
/// instruction.
struct CountedWords {
  simd::Words32<2> v;
  CountedWords(simd::Words32<2> x) : v(x) {}  // NOLINT: a vector is its elements
  CountedWords(std::uint32_t x) : v(x) {}     // NOLINT: constants mix freely

  static CountedWords counted(simd::Words32<2> x) { return ++operations.integer, CountedWords(x); }
  friend CountedWords operator+(CountedWords a, CountedWords b) { return counted(a.v + b.v); }
  friend CountedWords operator&(CountedWords a, CountedWords b) { return counted(a.v & b.v); }
  friend CountedWords operator^(CountedWords a, CountedWords b) { return counted(a.v ^ b.v); }
  friend CountedWords operator<<(CountedWords a, int n) { return counted(a.v << n); }
  friend CountedWords operator>>(CountedWords a, int n) { return counted(a.v >> n); }
};

struct CountedSingles {
  simd::Singles<2> v;
  CountedSingles(simd::Singles<2> x) : v(x) {}  // NOLINT: a vector is its elements
  CountedSingles(float x) : v(x) {}             // NOLINT: constants mix freely

  friend CountedSingles operator+(CountedSingles a, CountedSingles b) { return ++operations.add, a.v + b.v; }
  friend CountedSingles operator-(CountedSingles a, CountedSingles b) { return ++operations.add, a.v - b.v; }
  friend CountedSingles operator*(CountedSingles a, CountedSingles b) { return ++operations.multiply, a.v * b.v; }
  friend CountedSingles fma(CountedSingles a, CountedSingles b, CountedSingles c) {
    return ++operations.fma, surveymc::simd::fma(a.v, b.v, c.v);
  }
  friend CountedSingles sqrt(CountedSingles a) { return ++operations.root, surveymc::simd::sqrt(a.v); }
  friend CountedSingles select_from(CountedWords a, std::uint32_t bound, CountedSingles x, CountedSingles y) {
    return operations.compare += 2, surveymc::simd::select_from(a.v, bound, x.v, y.v);
  }
  friend CountedWords to_words(CountedSingles a) { return surveymc::simd::to_words(a.v); }
};
inline CountedSingles from_words(CountedWords a) { return surveymc::simd::from_words(a.v); }
inline CountedSingles nearest_single(CountedWords a) {
  return ++operations.integer, surveymc::simd::nearest_single(a.v);
}
inline CountedWords join(CountedBits a, CountedBits b) {
  return operations.integer += 3, CountedWords(surveymc::simd::join(a.v, b.v));
}
inline Counted lower(CountedSingles a) { return operations.integer += 2, Counted(surveymc::simd::lower(a.v)); }
inline Counted upper(CountedSingles a) { return operations.integer += 2, Counted(surveymc::simd::upper(a.v)); }

}  // namespace surveymc::bench

template <>
struct surveymc::simd::SinglesOf<surveymc::bench::Counted> {
  using type = bench::CountedSingles;
  using words = bench::CountedWords;
};
template <>
struct surveymc::simd::BitsOf<surveymc::bench::Counted> {
  using type = bench::CountedBits;
};
