#pragma once
/// MSA from a known neighbourhood: all trials start at one point with one inverse matrix and need gradients only.
///
/// Noise is a thousandth of the field, so the matrix of a trial is nearly that of the readings without noise. These
/// have their minimum at x0, and A is the inverse of the matrix there. The chord iteration  x <- x - A gradient(x)
/// gains two to three digits a step. It ends at the trial's own minimum, because the gradient is exact. Where a step is
/// not below a tenth of the step before (two modes, flat valleys), msa_solve takes the trial and does not use x0;
/// msa_valley.h has a better start for these.
#include <algorithm>

#include "estimate/msa_kernel.h"

namespace surveymc::estimate {

using namespace simd;

/// The minimum of readings without noise, and the inverse of Newton's matrix there (row by row), both for the unknowns
/// p, q / total.
struct MsaExpansion {
  std::array<double, 6> x;
  std::array<double, 36> inverse;
};

/// The first steps take the gradient by series; after them 1e-7 of the way remains, and none of them may end the
/// search.
constexpr int kMsaSeriesSteps = 2;

template <class T>
struct MsaGradient {
  std::array<T, 6> gradient;  ///< half the gradient of the cost
  T cost;                     ///< sum of squared residuals, in units of total^2
};

/// As msa_normal_equations without matrix, to rounding: with h = b - Bv u, the horizontal part of b,
///   Bh^2 = |b|^2 - Bv^2,  g = (Bh - Bh_ref) h / Bh + (Bv - Bv_ref) u
/// takes fewer operations than the base (u, n, e), which only the matrix needs. (Near the poles the difference of
/// squares loses (B / Bh)^2 units in the last place: two digits at dip 84.)
///
/// With `Series`, Bh_ref / Bh is its third-order series in tau = (Bh / Bh_ref)^2 - 1, wrong by 0.27 tau^4. The series
/// needs no root and no division; it gives no cost. It is good for all steps but the last. All stations must share one
/// reference.
template <class T, bool Series = false>
[[gnu::always_inline]] inline MsaGradient<T> msa_gradient(const MsaData& d, const std::array<T, 6>& x) {
  // In nT from station to station; the scale goes to q and to the sums.
  const T total(1.0 / d.per_total);
  const std::array<T, 3> p{x[0], x[1], x[2]}, q{x[3] * total, x[4] * total, x[5] * total};
  MsaGradient<T> out;
  for (T& a : out.gradient) a = T(0.0);
  out.cost = T(0.0);
  const double *magnetic = d.magnetic, *down = d.down, *reference = d.reference;
  const T bh_ref0 = load<T>(reference), per_bh_ref2 = T(1.0) / (bh_ref0 * bh_ref0);
  for (int k = 0; k < d.stations; ++k) {
    std::array<T, 3> m, u, b;
    for (std::size_t i = 0; i < 3; ++i) {
      m[i] = load<T>(magnetic + i * kGroup);
      u[i] = load<T>(down + i * kGroup);
      b[i] = fms(p[i], m[i], q[i]);
    }
    const T bv = fma(u[0], b[0], fma(u[1], b[1], u[2] * b[2]));
    const T bh2 = fms(b[0], b[0], fms(bv, bv, fma(b[1], b[1], b[2] * b[2])));
    const T rv = bv - load<T>(reference + kGroup);
    T along_b;  // (Bh - Bh_ref) / Bh
    if constexpr (Series) {
      const T tau = fms(bh2, per_bh_ref2, T(1.0));
      along_b = tau * fma(tau, fma(tau, T(0.3125), T(-0.375)), T(0.5));
    } else {
      const T bh = sqrt(bh2), per_bh = bh * (T(1.0) / bh2);  // root and quotient need not wait for each other
      const T rh = bh - load<T>(reference);
      out.cost = fma(rh, rh, fma(rv, rv, out.cost));
      along_b = rh * per_bh;
    }
    const T along_u = fma(-along_b, bv, rv);
    for (std::size_t i = 0; i < 3; ++i) {
      const T g = fma(along_b, b[i], along_u * u[i]);
      out.gradient[i] = fma(g, m[i], out.gradient[i]);
      out.gradient[3 + i] = out.gradient[3 + i] - g;
    }
    magnetic += 3 * kGroup;
    down += 3 * kGroup;
    reference += d.reference_stride * kGroup;
  }
  const T per_total(d.per_total), per_total2(d.per_total * d.per_total);
  for (std::size_t i = 0; i < 3; ++i) {
    out.gradient[i] = out.gradient[i] * per_total2;
    out.gradient[3 + i] = out.gradient[3 + i] * per_total;
  }
  out.cost = out.cost * per_total2;
  return out;
}

/// x <- x - step(gradient at x), from s.x, in the lanes `active`, until a step is within the tolerance. A lane stops
/// where a step is not below `contraction` times the step before. Counts evaluations; true in lanes that have
/// converged. A lane that has finished is frozen, so that its answer does not depend on the other lanes.
template <class T, class Active, class Step>
[[gnu::always_inline]] inline Active chord_steps(const MsaData& data, int most_steps, double contraction,
                                                 double step_tolerance, Active active, const Step& step_of,
                                                 MsaSolution<T>& s) {
  const T zero(0.0), one(1.0), tolerance(step_tolerance);
  auto converged = one < zero;
  T bound(contraction);  // of the first step: unknowns are of order one
  for (int it = 0; it < most_steps && any(active); ++it) {
    const bool series = it < kMsaSeriesSteps && data.reference_stride == 0;
    const MsaGradient<T> e = series ? msa_gradient<T, true>(data, s.x) : msa_gradient<T>(data, s.x);
    const std::array<T, 6> step = step_of(e);
    const auto larger = [&](std::size_t i) { return max(abs(step[i]), abs(step[i + 1])); };
    const T largest = max(max(larger(0), larger(2)), larger(4));
    s.iterations = s.iterations + select(active, one, zero);
    s.cost = select(active, e.cost, s.cost);
    active = active & (largest <= max(bound, tolerance));  // NaN fails it
    for (std::size_t i = 0; i < 6; ++i) s.x[i] = select(active, s.x[i] - step[i], s.x[i]);
    const auto done = active & (largest <= (series ? T(-1.0) : tolerance));
    converged = converged | done;
    active = active & !done;
    bound = T(contraction) * largest;
  }
  return converged;
}

/// From the expansion point. `converged` is 0 in lanes where the steps do not contract: msa_solve solves these.
template <class T>
MsaSolution<T> msa_solve_near(const MsaData& data, const MsaExpansion& start, const NewtonOptions& options) {
  constexpr int kMaxSteps = 8;  // beyond these the long way is shorter
  const T zero(0.0), one(1.0);
  MsaSolution<T> s;
  for (std::size_t i = 0; i < 6; ++i) s.x[i] = T(start.x[i]);
  s.cost = s.iterations = zero;
  const auto step_of = [&](const MsaGradient<T>& e) __attribute__((always_inline)) {
    std::array<T, 6> step;
    for (std::size_t i = 0; i < 6; ++i) {
      const double* a = start.inverse.data() + 6 * i;
      step[i] = T(a[0]) * e.gradient[0];
      for (std::size_t j = 1; j < 6; ++j) step[i] = fma(T(a[j]), e.gradient[j], step[i]);
    }
    return step;
  };
  const auto converged = chord_steps(data, std::min(kMaxSteps, options.max_iterations), 0.1, options.step_tolerance,
                                     zero < one, step_of, s);
  s.converged = select(converged & are_sound(s.x), one, zero);
  return s;
}

/// Solves from the expansion point or, where this does not lead to a minimum, from unit gains and zero biases (the long
/// way). `start` may be null. Lanes that take the long way have the bits of msa_solve; their evaluations on the short
/// way are counted too. The estimator does the same, but collects the trials that take the long way.
template <class T>
MsaSolution<T> msa_solve(const MsaData& data, const MsaExpansion* start, const NewtonOptions& options) {
  if (!start) return msa_solve<T>(data, options);
  MsaSolution<T> s = msa_solve_near<T>(data, *start, options);
  const auto near = T(0.0) < s.converged;
  if (all(near)) return s;
  const MsaSolution<T> whole = msa_solve<T>(data, options);
  for (std::size_t i = 0; i < 6; ++i) s.x[i] = select(near, s.x[i], whole.x[i]);
  s.cost = select(near, s.cost, whole.cost);
  s.iterations = select(near, s.iterations, s.iterations + whole.iterations);
  s.converged = select(near, s.converged, whole.converged);
  return s;
}

}  // namespace surveymc::estimate
