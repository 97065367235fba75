#pragma once
/// MSA where the noise is large for the geometry: from the minimum of the trial's own valley.
///
/// In thesis tests 1 and 2 gain and bias along the hole are determined so poorly that along them Newton's matrix
/// differs from trial to trial by a good part of itself, and the chord iteration of msa_chord.h does not contract.
/// Nearly all of that lies along the two weakest directions. With x = x0 + L y, where x0 is the minimum of the expected
/// readings and L L' the inverse of Newton's matrix there, and y = (w, z), w the two weak unknowns and z the four
/// others, half the cost of a trial is, but for a constant and terms that matter less,
///   g'w + h'z + w'(1 + D) w / 2 + z'z / 2 + z't(w, w) / 2 + T(w, w, w) / 6 + Q(w, w, w, w) / 24.
/// t, T and Q are those of the expected readings. g, h and D are the trial's own and, to first order, linear in its
/// readings: nine sums. Its minimum over z, at z = -h - t(w, w) / 2, is a quartic of two unknowns,
///   g'w + w'(1 + D - h.t) w / 2 + T(w, w, w) / 6 + (Q - 3 t.t)(w, w, w, w) / 24,
/// to whose minimum Newton takes a few steps without any reading. With S its matrix there and R = L_w - L_z t(w, .)
/// the inverse of the trial's matrix is  A = L_z L_z' + R S^-1 R'.  Chord steps  x <- x - A gradient(x)  end at the
/// trial's own minimum, because the gradient is exact. Source: derived here; tests/estimate/test_msa_valley.cpp holds
/// each part against msa_kernel.h.
#include <vector>

#include "estimate/msa_chord.h"

namespace surveymc::estimate {

/// Made by msa_valley (msa.h). Unknowns p, q / total.
struct MsaValley {
  static constexpr std::size_t kSums = 9;  ///< g (2), h (4), and D - h.t: 00, 01, 11

  std::array<double, 6> x;                 ///< x0
  std::array<double, 36> to_x;             ///< L row by row, weak columns first
  std::array<double, 36> across;           ///< L_z L_z'
  std::array<std::array<double, 3>, 4> t;  ///< of each z: 00, 01, 11
  std::array<double, 4> cubic;             ///< T: 000, 001, 011, 111
  std::array<double, 5> quartic;           ///< Q - 3 t.t, symmetric: 0000, 0001, 0011, 0111, 1111

  /// The sums are constants + coefficients . readings, kSums coefficients for each row of a ReadingBlock. Down
  /// directions without noise need not be looked at; the reference of a run has the sum over its stations.
  std::array<double, kSums> constant, constant_down;
  std::vector<double> magnetic, down, reference, reference_of_run;
};

/// Start of a trial, and the part R S^-1 R' of its inverse matrix.
template <class T>
struct MsaValleyStart {
  std::array<T, 6> x, first, second;  ///< first first' per_first + second second' per_second
  T per_first, per_second;
  T convex;  ///< 1, or 0 where the quartic is not convex on the way: nothing else is then of use
};

/// Adds coefficients . rows.
template <class T, std::size_t N>
[[gnu::always_inline]] inline void add_products(const double* rows, const double* coefficients, int count,
                                                std::array<T, N>& sums) {
  for (int r = 0; r < count; ++r) {
    const T value = load<T>(rows + static_cast<std::size_t>(r) * kGroup);
    for (std::size_t i = 0; i < N; ++i) sums[i] = fma(T(coefficients[i]), value, sums[i]);
    coefficients += N;
  }
}

/// The nine sums of a trial. `noisy_down`: whether down directions differ from trial to trial.
template <class T>
[[gnu::always_inline]] inline std::array<T, MsaValley::kSums> msa_valley_sums(const MsaData& data, bool noisy_down,
                                                                              const MsaValley& v) {
  std::array<T, MsaValley::kSums> s;
  for (std::size_t i = 0; i < s.size(); ++i) s[i] = T(noisy_down ? v.constant[i] + v.constant_down[i] : v.constant[i]);
  add_products(data.magnetic, v.magnetic.data(), 3 * data.stations, s);
  if (noisy_down) add_products(data.down, v.down.data(), 3 * data.stations, s);
  const bool of_run = data.reference_stride == 0;
  add_products(data.reference, (of_run ? v.reference_of_run : v.reference).data(), of_run ? 2 : 2 * data.stations, s);
  return s;
}

/// Two Newton steps to the minimum of the quartic.
template <class T>
[[gnu::always_inline]] inline MsaValleyStart<T> msa_valley_start(const std::array<T, MsaValley::kSums>& s,
                                                                 const MsaValley& v) {
  constexpr int kSteps = 2;  // a third overshoots in rare trials (non-convex: 2.5 % instead of 0.3 %) and gains little
  const T zero(0.0), one(1.0), half(0.5), flat(0.05);  // of the expected matrix, which is 1
  MsaValleyStart<T> out;
  std::array<T, 2> w{zero, zero};
  auto convex = zero < one;
  T lower;  // S = [1 0; lower 1] diag(1 / per_first, 1 / per_second) [1 lower; 0 1]
  for (int it = 0; it <= kSteps; ++it) {
    const T w00 = w[0] * w[0], w01 = w[0] * (w[1] + w[1]), w11 = w[1] * w[1];
    std::array<T, 3> matrix, secant;  // second derivative at w; the gradient there is g + secant w
    for (std::size_t i = 0; i < 3; ++i) {
      const T third = fma(T(v.cubic[i]), w[0], T(v.cubic[i + 1]) * w[1]);
      const T fourth = fma(T(v.quartic[i]), w00, fma(T(v.quartic[i + 1]), w01, T(v.quartic[i + 2]) * w11));
      const T own = s[6 + i] + (i == 1 ? zero : one);
      matrix[i] = fma(half, fourth, third + own);
      secant[i] = fma(T(1.0 / 6), fourth, fma(half, third, own));
    }
    out.per_first = one / matrix[0];
    lower = matrix[1] * out.per_first;
    const T rest = fma(-lower, matrix[1], matrix[2]);
    out.per_second = one / rest;
    convex = convex & (flat < matrix[0]) & (flat < rest);  // NaN fails it
    if (it == kSteps) break;
    const T g0 = fma(secant[0], w[0], fma(secant[1], w[1], s[0]));
    const T g1 = fma(secant[1], w[0], fma(secant[2], w[1], s[1]));
    const T step = fma(-lower, g0, g1) * out.per_second;
    w[1] = w[1] - step;
    w[0] = fma(lower, step, fma(-g0, out.per_first, w[0]));
  }
  std::array<T, 4> t0, t1, z;  // t(w, .) and z
  for (std::size_t j = 0; j < 4; ++j) {
    t0[j] = fma(T(v.t[j][0]), w[0], T(v.t[j][1]) * w[1]);
    t1[j] = fma(T(v.t[j][1]), w[0], T(v.t[j][2]) * w[1]);
    z[j] = -fma(half, fma(t0[j], w[0], t1[j] * w[1]), s[2 + j]);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const double* l = v.to_x.data() + 6 * i;
    out.x[i] = fma(T(l[0]), w[0], fma(T(l[1]), w[1], T(v.x[i])));
    out.first[i] = T(l[0]);
    out.second[i] = T(l[1]);
    for (std::size_t j = 0; j < 4; ++j) {
      out.x[i] = fma(T(l[2 + j]), z[j], out.x[i]);
      out.first[i] = fma(T(-l[2 + j]), t0[j], out.first[i]);
      out.second[i] = fma(T(-l[2 + j]), t1[j], out.second[i]);
    }
    out.second[i] = fma(-lower, out.first[i], out.second[i]);
  }
  out.convex = select(convex, one, zero);
  return out;
}

/// From the valley's minimum to that of the trial. `converged` is 0 where the valley is not convex or a step is more
/// than half of the step before: Newton's method goes on from x (msa_solve_from), which is unit gains in the former
/// case. The sums count as an evaluation.
template <class T>
MsaSolution<T> msa_solve_in_valley(const MsaData& data, bool noisy_down, const MsaValley& v,
                                   const NewtonOptions& options) {
  constexpr int kMaxSteps = 10;  // beyond these the long way is shorter
  const T zero(0.0), one(1.0), half(0.5);
  const MsaValleyStart<T> start = msa_valley_start<T>(msa_valley_sums<T>(data, noisy_down, v), v);
  MsaSolution<T> s;
  s.x = start.x;
  s.cost = zero;
  s.iterations = one;
  std::array<T, 6> last, last_gradient;
  for (std::size_t i = 0; i < 6; ++i) last[i] = last_gradient[i] = zero;
  const auto step_of = [&](const MsaGradient<T>& e) __attribute__((always_inline)) {
    T along_first = start.first[0] * e.gradient[0], along_second = start.second[0] * e.gradient[0];
    for (std::size_t j = 1; j < 6; ++j) {
      along_first = fma(start.first[j], e.gradient[j], along_first);
      along_second = fma(start.second[j], e.gradient[j], along_second);
    }
    along_first = along_first * start.per_first;
    along_second = along_second * start.per_second;
    // Where the derivative along the step before is not 0 but a ratio of what it was, the step fell short by it.
    T before = zero, now = zero;
    for (std::size_t i = 0; i < 6; ++i) {
      before = fma(last[i], last_gradient[i], before);
      now = fma(last[i], e.gradient[i], now);
    }
    const T ratio = select(abs(now) < half * abs(before), now / before, zero), stretch = one / (one - ratio);
    std::array<T, 6> step;
    for (std::size_t i = 0; i < 6; ++i) {
      const double* a = v.across.data() + 6 * i;
      step[i] = fma(start.first[i], along_first, start.second[i] * along_second);
      for (std::size_t j = 0; j < 6; ++j) step[i] = fma(T(a[j]), e.gradient[j], step[i]);
      step[i] = step[i] * stretch;
      last[i] = step[i];
      last_gradient[i] = e.gradient[i];
    }
    return step;
  };
  const auto is_convex = zero < start.convex;
  const auto converged = chord_steps(data, std::min(kMaxSteps, options.max_iterations - 1), 0.5, options.step_tolerance,
                                     is_convex, step_of, s);
  const auto sound = is_convex & are_sound(s.x);
  for (std::size_t i = 0; i < 6; ++i) s.x[i] = select(sound, s.x[i], i < 3 ? one : zero);
  s.converged = select(sound & converged, one, zero);
  return s;
}

}  // namespace surveymc::estimate
