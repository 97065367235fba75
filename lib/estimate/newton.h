#pragma once
/// newton_minimum finds the minimum of a sum of squares on lanes of trials: Gauss-Newton far away, Newton near by.
/// newton_root finds the root of equations that are no gradient, from a start close to the root.
#include <array>
#include <cstddef>

#include "simd/solve.h"

namespace surveymc::estimate {

using namespace simd;

struct NewtonOptions {
  int max_iterations = 200;      ///< evaluations of the normal equations, step halvings included
  double step_tolerance = 1e-9;  ///< converged when max_i |dx_i| <= step_tolerance; unknowns are of order one
};

template <class T, std::size_t N>
struct NormalEquations {
  Symmetric<T, N> matrix;     ///< J'J plus second_order times the rest of half the Hessian
  std::array<T, N> gradient;  ///< half the gradient of the cost
  T cost;                     ///< sum of squared residuals
};

template <class T, std::size_t N>
struct NewtonSolution {
  std::array<T, N> x;
  T cost;        ///< at x before the last step
  T iterations;  ///< evaluations of the normal equations
  T converged;   ///< 1 or 0
};

/// `evaluate.template operator()<WithMatrix>(x, second_order)` gives NormalEquations<T, N>; second_order is 0 for the
/// Gauss-Newton matrix and 1 for Newton's; without matrix only gradient and cost, with the same bits.
///
/// Gauss-Newton until the steps are small, then Newton, because the residuals do not vanish and Gauss-Newton alone may
/// oscillate for ever about a poorly determined minimum. Once a Newton step is small, its matrix serves for the next
/// steps too, as long as each step is a tenth of the step before. A step that raises the cost is halved until the cost
/// no longer rises. Where Newton's matrix is not positive definite (flat valleys between two modes), its second-order
/// part is halved until the matrix is positive definite. A lane that has finished is frozen and a lane that keeps its
/// matrix ignores a new one, so that the answer of a lane does not depend on the other lanes.
template <class T, std::size_t N, class Evaluate>
NewtonSolution<T, N> newton_minimum(const Evaluate& evaluate, const std::array<T, N>& start,
                                    const NewtonOptions& options) {
  const T zero(0.0), one(1.0);
  const T small_step(0.1);   // unknowns are of order one: below it the second-order terms improve the step
  const T chord_step(1e-3);  // the size of noise over field: below it Newton's matrix changes little
  std::array<T, N> best = start, step;
  for (T& s : step) s = zero;
  Symmetric<T, N> factor;
  for (T& f : factor) f = zero;
  T best_cost(1e300), iterations = zero, second_order = zero, last_largest(1e300);
  auto active = zero < one;  // in every lane
  auto converged = one < zero, keeps_matrix = one < zero;
  for (int it = 0; it < options.max_iterations && any(active); ++it) {
    std::array<T, N> x;
    for (std::size_t i = 0; i < N; ++i) x[i] = best[i] + step[i];
    const bool nobody_needs_a_matrix = all(keeps_matrix | (!active));
    NormalEquations<T, N> e;
    if (nobody_needs_a_matrix) {
      e = evaluate.template operator()<false>(x, second_order);
    } else {
      e = evaluate.template operator()<true>(x, second_order);
      const Symmetric<T, N> fresh = ldlt<T, N>(e.matrix);
      for (std::size_t i = 0; i < factor.size(); ++i) factor[i] = select(keeps_matrix, factor[i], fresh[i]);
    }
    std::array<T, N> minus_gradient;
    for (std::size_t i = 0; i < N; ++i) minus_gradient[i] = -e.gradient[i];
    const std::array<T, N> next = ldlt_solve<T, N>(factor, minus_gradient);
    auto definite = active;
    for (std::size_t i = 0; i < N; ++i) definite = definite & (zero < factor[packed(i, i)]);
    // Rounding may raise the cost of a step that no longer matters; such steps are below any sensible tolerance.
    const auto accept = active & (e.cost <= best_cost * T(1 + 1e-10));
    T largest = zero;
    for (std::size_t i = 0; i < N; ++i) {
      best[i] = select(accept, x[i], best[i]);
      step[i] = select(accept, select(definite, next[i], zero), T(0.5) * step[i]);
      largest = max(largest, abs(step[i]));
    }
    best_cost = select(accept, e.cost, best_cost);
    iterations = iterations + select(active, one, zero);
    const auto newton = one <= second_order;  // the present matrix is Newton's, with the whole second order
    keeps_matrix = definite & accept & newton & (largest < chord_step) & (largest < T(0.1) * last_largest);
    const T more = T(2.0) * max(second_order, T(0.5));
    second_order =
        select(definite, select(largest < small_step, select(more < one, more, one), zero), T(0.5) * second_order);
    last_largest = largest;
    const auto done = active & definite & (largest <= T(options.step_tolerance));
    for (std::size_t i = 0; i < N; ++i)  // the last step is free: take it
      best[i] = select(done & accept, best[i] + step[i], best[i]);
    converged = converged | done;
    active = active & !done;
  }
  return {best, best_cost, iterations, select(converged, one, zero)};
}

template <class T, std::size_t N>
struct RootEquations {
  Square<T, N> matrix;     ///< derivative of value, row i that of value[i]
  std::array<T, N> value;  ///< 0 at the root
  T cost;                  ///< carried to the solution
};

/// `evaluate.template operator()<WithMatrix>(x)` gives RootEquations<T, N>; without matrix the same values, bit by bit.
///
/// Damped Newton with the natural monotonicity test (Deuflhard 2011, Newton Methods for Nonlinear Problems, 3.3.3):
/// from x the step f dx, f = 1, 1/2, 1/4 ..., is taken if the next step by the *same* matrix is at most (1 - f / 2)
/// |dx|. As long as each step is a tenth of the step before, this next step by the old matrix is taken; else a new
/// matrix is computed at x. A lane fails where f falls below 1 / 64. As in newton_minimum the answer of a lane does not
/// depend on the other lanes.
template <class T, std::size_t N, class Evaluate>
NewtonSolution<T, N> newton_root(const Evaluate& evaluate, const std::array<T, N>& start,
                                 const NewtonOptions& options) {
  const T zero(0.0), one(1.0);
  std::array<T, N> best = start, step;
  for (T& s : step) s = zero;
  Square<T, N> factor;
  for (T& f : factor) f = zero;
  T cost = zero, iterations = zero, damping = one, last(1e300);
  auto active = zero < one, needs_matrix = zero < one;
  auto converged = one < zero;
  for (int it = 0; it < options.max_iterations && any(active); ++it) {
    std::array<T, N> x, minus_value;
    for (std::size_t i = 0; i < N; ++i) x[i] = select(needs_matrix, best[i], fma(damping, step[i], best[i]));
    RootEquations<T, N> e;
    if (any(needs_matrix & active)) {
      e = evaluate.template operator()<true>(x);
      const Square<T, N> fresh = lu<T, N>(e.matrix);
      for (std::size_t i = 0; i < factor.size(); ++i) factor[i] = select(needs_matrix, fresh[i], factor[i]);
    } else {
      e = evaluate.template operator()<false>(x);
    }
    for (std::size_t i = 0; i < N; ++i) minus_value[i] = -e.value[i];
    const std::array<T, N> next = lu_solve<T, N>(factor, minus_value);
    T largest = zero;
    for (std::size_t i = 0; i < N; ++i) largest = max(largest, abs(next[i]));
    // NaN fails both comparisons.
    const auto accept =
        active & ((needs_matrix & (largest < T(1e300))) | (largest <= fma(T(-0.5) * damping, last, last)));
    const auto done = accept & (largest <= T(options.step_tolerance));
    const auto keeps_matrix = needs_matrix | ((largest <= T(0.1) * last) & (one <= damping));
    for (std::size_t i = 0; i < N; ++i) {
      best[i] = select(accept, select(done, x[i] + next[i], x[i]), best[i]);  // the last step is free: take it
      step[i] = select(accept, next[i], step[i]);
    }
    cost = select(accept, e.cost, cost);
    last = select(accept, largest, last);
    iterations = iterations + select(active, one, zero);
    damping = select(accept, one, T(0.5) * damping);
    converged = converged | done;
    active = active & (!done) & (accept | ((!needs_matrix) & (T(1.0 / 64) <= damping)));
    needs_matrix = accept & (!keeps_matrix);
  }
  return {best, cost, iterations, select(converged, one, zero)};
}

/// Unknowns begin with three inverse gains p and three biases q: a gain has to be positive, and all finite. NaN fails
/// every comparison.
template <class T, std::size_t N>
[[gnu::always_inline]] inline auto are_sound(const std::array<T, N>& x) {
  const auto is_sound = [&](std::size_t i) { return (T(0.0) < x[i]) & (x[i] < T(1e300)) & (abs(x[3 + i]) < T(1e300)); };
  return is_sound(0) & is_sound(1) & is_sound(2);
}

}  // namespace surveymc::estimate
