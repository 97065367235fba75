#pragma once
/// Gauss-Newton and Newton for MSA, on lanes of trials. Readable model: msa_residual.h.
///
///   b = p m - q,  Bv = u.b,  h = b - Bv u,  Bh = |h|,  n = h / Bh
///   dBh/dp_i = n_i m_i,  dBh/dq_i = -n_i,  dBv/dp_i = u_i m_i,  dBv/dq_i = -u_i
/// so that with w_ij = n_i n_j + u_i u_j and e = (Bh - Bh_ref) n + (Bv - Bv_ref) u the normal equations of one station
/// are  [ w_ij m_i m_j   -w_ij m_i ]          [ e_i m_i ]
///      [     .            w_ij    ]  dx = -  [  -e_i   ].
/// Only Bh is curved: d2Bh/db2 = (1 - n n' - u u') / Bh. With rho = (Bh - Bh_ref) / Bh the exact second derivative of
/// the cost is the same matrix with w_ij = (1 - rho)(n_i n_j + u_i u_j) + rho delta_ij: Newton costs no more.
/// Fields are in units of `total`, so that all six unknowns and their columns are of order one.
#include <array>

#include "simd/solve.h"
#include "survey/frames.h"

namespace surveymc {

struct MsaOptions {
  int max_iterations = 200;      ///< evaluations of the normal equations, step halvings included
  double step_tolerance = 1e-9;  ///< converged when max_i |dp_i|, |dq_i| / total <= step_tolerance
};

/// Pointers to one group of a ReadingBlock, or to some lane of it: see there for the rows, which are kGroup apart.
struct MsaData {
  const double *magnetic, *down, *reference;
  int stations, reference_stride;
  double per_total;  ///< 1 / total field, 1/nT
};

template <class T>
struct MsaNormalEquations {
  Symmetric<T, 6> matrix;
  std::array<T, 6> gradient;  ///< half the gradient of the cost
  T cost;                     ///< sum of squared residuals, in units of total^2
};

/// At x = (p, q / total). `second_order`: 0 for the Gauss-Newton matrix J'J, 1 for Newton's. Without `WithMatrix` only
/// gradient and cost, with the same bits, for less than half the work.
template <class T, bool WithMatrix = true>
MsaNormalEquations<T> msa_normal_equations(const MsaData& d, const std::array<T, 6>& x, const T& second_order) {
  MsaNormalEquations<T> e{};
  for (T& a : e.matrix) a = T(0.0);
  for (T& a : e.gradient) a = T(0.0);
  e.cost = T(0.0);
  const T per_total(d.per_total);
  const double* ref = d.reference;
  for (int k = 0; k < d.stations; ++k, ref += d.reference_stride * kGroup) {
    std::array<T, 3> m, u, n, g;
    for (std::size_t i = 0; i < 3; ++i) {
      m[i] = load<T>(d.magnetic + (3 * static_cast<std::size_t>(k) + i) * kGroup) * per_total;
      u[i] = load<T>(d.down + (3 * static_cast<std::size_t>(k) + i) * kGroup);
      n[i] = fma(x[i], m[i], -x[3 + i]);  // b
    }
    const T bv = fma(u[0], n[0], fma(u[1], n[1], u[2] * n[2]));
    for (std::size_t i = 0; i < 3; ++i) n[i] = fma(-bv, u[i], n[i]);  // h
    const T bh = sqrt(fma(n[0], n[0], fma(n[1], n[1], n[2] * n[2])));
    const T per_bh = T(1.0) / bh;
    const T rh = fma(-load<T>(ref), per_total, bh), rv = fma(-load<T>(ref + kGroup), per_total, bv);
    e.cost = fma(rh, rh, fma(rv, rv, e.cost));
    for (std::size_t i = 0; i < 3; ++i) {
      n[i] = n[i] * per_bh;
      g[i] = fma(rh, n[i], rv * u[i]);
      e.gradient[i] = fma(g[i], m[i], e.gradient[i]);
      e.gradient[3 + i] = e.gradient[3 + i] - g[i];
    }
    if constexpr (!WithMatrix) continue;
    const T rho = second_order * rh * per_bh, keep = T(1.0) - rho;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const T first = fma(n[i], n[j], u[i] * u[j]);
        const T w = i == j ? fma(keep, first, rho) : keep * first, wmi = w * m[i], wmj = w * m[j];
        e.matrix[packed(i, j)] = fma(wmi, m[j], e.matrix[packed(i, j)]);
        e.matrix[packed(3 + i, 3 + j)] = e.matrix[packed(3 + i, 3 + j)] + w;
        e.matrix[packed(3 + i, j)] = e.matrix[packed(3 + i, j)] - wmj;  // d/dq_i d/dp_j
        if (i != j) e.matrix[packed(3 + j, i)] = e.matrix[packed(3 + j, i)] - wmi;
      }
  }
  return e;
}

template <class T>
struct MsaSolution {
  std::array<T, 6> x;  ///< p, then q / total
  T cost;              ///< at x before the last step, in units of total^2
  T iterations;        ///< evaluations of the normal equations
  T converged;         ///< 1 or 0
};

/// From unit gains and zero biases to the minimum: Gauss-Newton until the steps are small, then Newton, because the
/// residuals do not vanish and Gauss-Newton alone may oscillate for ever about a poorly determined minimum. Once a
/// Newton step is small, its matrix serves for the next steps too, as long as each is a tenth of the one before. A step
/// that raises the cost is halved until it does not; where Newton's matrix is not positive definite, Gauss-Newton steps
/// in. A lane that has finished is frozen and a lane that keeps its matrix ignores a new one, so the answer of a lane
/// does not depend on its neighbours.
template <class T>
MsaSolution<T> msa_solve(const MsaData& data, const MsaOptions& options) {
  const T zero(0.0), one(1.0);
  const T small_step(0.1);   // unknowns are of order one: from here the quadratic model is worth its second order
  const T chord_step(1e-3);  // from here Newton's matrix changes little: field over noise
  std::array<T, 6> best{one, one, one, zero, zero, zero}, step{zero, zero, zero, zero, zero, zero};
  Symmetric<T, 6> factor;
  for (T& f : factor) f = zero;
  T best_cost(1e300), iterations = zero, second_order = zero, last_largest(1e300);
  auto active = zero < one;  // in every lane
  auto converged = one < zero, keeps_matrix = one < zero;
  for (int it = 0; it < options.max_iterations && any(active); ++it) {
    std::array<T, 6> x;
    for (std::size_t i = 0; i < 6; ++i) x[i] = best[i] + step[i];
    const bool nobody_needs_a_matrix = all(keeps_matrix | (!active));
    MsaNormalEquations<T> e;
    if (nobody_needs_a_matrix) {
      e = msa_normal_equations<T, false>(data, x, second_order);
    } else {
      e = msa_normal_equations<T>(data, x, second_order);
      const Symmetric<T, 6> fresh = ldlt<T, 6>(e.matrix);
      for (std::size_t i = 0; i < factor.size(); ++i) factor[i] = select(keeps_matrix, factor[i], fresh[i]);
    }
    std::array<T, 6> minus_gradient;
    for (std::size_t i = 0; i < 6; ++i) minus_gradient[i] = -e.gradient[i];
    const std::array<T, 6> next = ldlt_solve<T, 6>(factor, minus_gradient);
    auto definite = active;
    for (std::size_t i = 0; i < 6; ++i) definite = definite & (zero < factor[packed(i, i)]);
    // Rounding may raise the cost of a step that no longer matters; such steps are below any sensible tolerance.
    const auto accept = active & (e.cost <= best_cost * T(1 + 1e-10));
    T largest = zero;
    for (std::size_t i = 0; i < 6; ++i) {
      best[i] = select(accept, x[i], best[i]);
      step[i] = select(accept, select(definite, next[i], zero), T(0.5) * step[i]);
      largest = max(largest, abs(step[i]));
    }
    best_cost = select(accept, e.cost, best_cost);
    iterations = iterations + select(active, one, zero);
    const auto newton = one <= second_order;  // the matrix in hand is Newton's, whole
    keeps_matrix = definite & accept & newton & (largest < chord_step) & (largest < T(0.1) * last_largest);
    const T more = T(2.0) * max(second_order, T(0.5));
    second_order =
        select(definite, select(largest < small_step, select(more < one, more, one), zero), T(0.5) * second_order);
    last_largest = largest;
    const auto done = active & definite & (largest <= T(options.step_tolerance));
    for (std::size_t i = 0; i < 6; ++i)  // the last step is free: take it
      best[i] = select(done & accept, best[i] + step[i], best[i]);
    converged = converged | done;
    active = active & !done;
  }
  // A gain has to be positive and finite; NaN fails every comparison.
  auto sound = converged;
  for (std::size_t i = 0; i < 3; ++i)
    sound = sound & (zero < best[i]) & (best[i] < T(1e300)) & (abs(best[3 + i]) < T(1e300));
  return {best, best_cost, iterations, select(sound, one, zero)};
}

}  // namespace surveymc
