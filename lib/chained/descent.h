#pragma once
/// Levenberg and Marquardt's descent with a gain ratio, for the cost J of a chain or of one of its stations.
///
///   step:     (B + lambda D) d = g                       g: minus half the gradient, B: half the Hessian or its model
///   promise:  p = 2 g.d - d.B d = g.d + lambda d.D d > 0, as B + lambda D is positive definite
///   gain:     (J(x) - J(x + d)) / p;  the step is taken if that exceeds least_gain, else lambda rises tenfold
///
/// B is Gauss-Newton's as long as its steps shrink fast, which costs nothing where the model is nearly linear. Where
/// they do not, B is half the true Hessian wherever B + lambda D is positive definite, and Gauss-Newton's elsewhere:
/// near horizontal east or west the curvature of the readings' equations is many times Gauss-Newton's, whose undamped
/// steps then run to and fro between two points for ever.
///
/// Why it ends at a stationary point, from any start (Nocedal and Wright 2006, theorem 4.5 in this notation): the set
/// {J <= J(start)} is compact (priors and links hold the chain, rotations are bounded), so on it B, D and the third
/// order of J are bounded, and there is a lambda* beyond which every step is taken. Hence lambda <= 10 lambda* always,
/// every step taken lowers J by at least least_gain |g|^2 / |B + lambda D|, and as J >= 0 the sum of all |g|^2 is
/// finite: g -> 0. Where the Hessian at the limit is positive definite, lambda -> 0 and the last steps are Newton's,
/// which converge quadratically.
#include <cmath>
#include <optional>

#include "base/units.h"
#include "chained/linearised_station.h"

namespace surveymc::chained {

template <class Point>
struct Descent {
  Point at;
  double cost = 0;
  Status status = Status::iteration_limit;
  int iterations = 0;
};

/// Problem: Point; System; cost(point); system(point): Gauss-Newton's; exact(system, point): with the true Hessian;
/// solve(system, lambda): an object with `positive` (definite), `promise` and what size2() and moved(point, .) need;
/// rounding(cost): below this a difference of two costs says nothing.
template <class Problem>
Descent<typename Problem::Point> descend(const Problem& problem, const typename Problem::Point& start,
                                         const Options& options) {
  using System = typename Problem::System;
  constexpr double kFirstDamping = 1e-2, kLeastDamping = 1e-4, kLargestDamping = 1e15, kFactor = 10;
  constexpr double kSlow = 1.0 / 16;  // squared contraction of steps above which Gauss-Newton does not serve
  const double tolerance2 = options.step_tolerance * options.step_tolerance;
  Descent<typename Problem::Point> out{start, problem.cost(start)};
  System gauss_newton = problem.system(out.at);
  std::optional<System> newton;
  bool curved = false;  // Gauss-Newton does not serve
  double damping = 0, last2 = kInfinity;
  int held = 0;  // steps in a row that J is too coarse to judge
  while (out.iterations < options.max_iterations) {
    if (!std::isfinite(out.cost)) {
      out.status = Status::not_finite;
      break;
    }
    ++out.iterations;
    if (curved && !newton) newton = problem.exact(gauss_newton, out.at);
    auto step = problem.solve(curved ? *newton : gauss_newton, damping);
    const bool by_newton = curved && step.positive;
    if (curved && !by_newton) step = problem.solve(gauss_newton, damping);
    const double size2 = problem.size2(step);
    const bool finite = step.positive && std::isfinite(size2) && std::isfinite(step.promise);
    if (finite && damping == 0 && size2 <= tolerance2 && step.promise <= options.gradient_tolerance * (1 + out.cost)) {
      out.at = problem.moved(out.at, step);
      out.cost = problem.cost(out.at);
      out.status = curved && !by_newton ? Status::saddle : Status::converged;
      break;
    }
    if (!options.damped) {
      if (!finite) {
        out.status = Status::not_finite;
        break;
      }
      out.at = problem.moved(out.at, step);
      out.cost = problem.cost(out.at);
      gauss_newton = problem.system(out.at);
      continue;
    }
    const bool coarse = finite && step.promise <= problem.rounding(out.cost);
    bool taken = false;
    double gain = 0;
    if (finite) {
      const auto next = problem.moved(out.at, step);
      const double cost = problem.cost(next);
      gain = (out.cost - cost) / step.promise;
      // So near the minimum that costs differ by rounding only: the model is as good as exact, its step is an answer.
      held = coarse ? held + 1 : 0;
      taken = coarse ? cost <= out.cost + problem.rounding(out.cost) : gain > options.least_gain;
      if (taken) {
        out.at = next;
        out.cost = cost;
      }
    }
    if (taken) {
      const bool slow = damping == 0 && size2 > kSlow * last2;
      last2 = damping == 0 ? size2 : kInfinity;
      if (coarse || gain > 0.75)
        damping = damping > kLeastDamping ? damping / kFactor : 0;
      else if (gain < 0.25)
        damping *= 2;
      curved = curved || slow || (!coarse && gain < 0.25);
      gauss_newton = problem.system(out.at);
      newton.reset();
    } else if (!curved && finite) {
      curved = true;  // the same damping again, by the true Hessian
    } else {
      damping = std::max(kFactor * damping, kFirstDamping);
      if (damping > kLargestDamping) {
        out.status = finite ? Status::no_descent : Status::not_finite;
        break;
      }
    }
  }
  return out;
}

}  // namespace surveymc::chained
