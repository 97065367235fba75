#pragma once
/// Levenberg and Marquardt's descent with a gain ratio to the least sum of squares J, for one problem (T: double) or
/// several side by side (T: Lanes).
///
///   step:     (B + lambda D) d = g                       g: minus half the gradient, B: half the Hessian or its model
///   promise:  p = 2 g.d - d.B d = g.d + lambda d.D d > 0, as B + lambda D is positive definite
///   gain:     (J(x) - J(x + d)) / p;  the step is taken if the gain exceeds least_gain, else lambda rises tenfold
///
/// B is Gauss-Newton's matrix as long as its steps shrink fast, which is cheap where the model is nearly linear. Where
/// the steps do not shrink fast, B is half the true Hessian wherever B + lambda D is then positive definite, and
/// Gauss-Newton's matrix elsewhere. The reason: near horizontal east or west the curvature of the readings' equations
/// is many times that of Gauss-Newton's matrix, whose undamped steps then jump between two points for ever.
///
/// Why the descent ends at a stationary point, from any start (Nocedal and Wright 2006, theorem 4.5 in this notation):
/// the set {J <= J(start)} is compact (what is observed with an error holds its unknowns, rotations are bounded), so on
/// it B, D and the third order of J are bounded, and there is a lambda* beyond which every step is taken. Hence lambda
/// <= 10 lambda* always, every step taken lowers J by at least least_gain |g|^2 / |B + lambda D|, and as J >= 0 the sum
/// of all |g|^2 is finite: g -> 0. Where the Hessian at the limit is positive definite, lambda -> 0 and the last steps
/// are Newton's, which converge quadratically.
#include <array>
#include <cstddef>

#include "base/units.h"
#include "simd/lanes.h"

namespace surveymc::stats {

/// How a descent ended. Only a `converged` one gives a minimum.
enum class DescentStatus {
  converged,
  iteration_limit,  ///< the options' max_iterations
  no_descent,       ///< no damping makes the cost fall
  saddle,           ///< the gradient is zero, but the cost falls in some direction
  not_finite        ///< readings or steps that are not numbers
};
inline constexpr std::size_t kDescentStatuses = 5;
inline constexpr std::array<const char*, kDescentStatuses> kDescentStatusNames{"converged", "iteration_limit",
                                                                               "no_descent", "saddle", "not_finite"};

struct DescentOptions {
  int max_iterations = 200;  ///< steps tried, rejected ones included
  /// Converged when the undamped step d, of gradient g and quadratic model B (halves), satisfies both
  ///   size of d <= step_tolerance              (as the problem measures it)
  ///   g.B^-1 g <= gradient_tolerance (1 + J)   (the fall of J that the model still predicts)
  double step_tolerance = 1e-9;
  double gradient_tolerance = 1e-10;
  /// A step is taken when J falls by more than this part of the fall that the quadratic model predicts.
  double least_gain = 1e-4;
  bool damped = true;  ///< false: plain Gauss-Newton, every step taken, which may not converge
};

/// How a descent ended, in numbers of the lanes' type.
template <class T>
struct DescentEnd {
  T cost;
  T iterations;  ///< steps tried, rejected ones included
  T status;      ///< the number of a DescentStatus
};

/// A problem's report on the step that it has solved for.
template <class T, class Mask>
struct DescentStep {
  Mask positive;  ///< B + lambda D is positive definite
  T promise;
  T size2;  ///< squared length, in units of the tolerance's
};

template <class T>
auto is_finite(const T& x) {
  using simd::abs;
  return abs(x) < T(kInfinity);
}

/// A Problem has a Scalar and holds a present point. cost(): J there. solve(curved, damping): solves for a step from
/// it, by the true Hessian where `curved`, and gives a DescentStep. try_step(): J after that step. take(where): goes
/// there. rounding(cost): a difference of two costs below it is only rounding. A lane that has ended keeps its point.
template <class Problem>
DescentEnd<typename Problem::Scalar> descend(Problem& problem, const DescentOptions& options) {
  using namespace simd;
  using Status = DescentStatus;
  using T = typename Problem::Scalar;
  constexpr double kFirstDamping = 1e-2, kLeastDamping = 1e-4, kLargestDamping = 1e15, kFactor = 10;
  constexpr double kSlow = 1.0 / 16;  // squared contraction of steps above which Gauss-Newton is given up
  const T zero(0.0), one(1.0), tolerance2(options.step_tolerance * options.step_tolerance);
  const auto number_of = [](Status s) { return T(static_cast<double>(s)); };
  DescentEnd<T> out{problem.cost(), zero, number_of(Status::iteration_limit)};
  auto active = zero < one, curved = one < zero;  // curved: Gauss-Newton is given up
  T damping = zero, last2(kInfinity);
  const auto end = [&](const auto& where, const T& status) {
    out.status = select(where, status, out.status);
    active = active & (!where);
  };
  for (int tried = 0; tried < options.max_iterations; ++tried) {
    end(active & (!is_finite(out.cost)), number_of(Status::not_finite));
    if (!any(active)) break;
    out.iterations = out.iterations + select(active, one, zero);
    auto step = problem.solve(curved, damping);
    const auto by_newton = curved & step.positive;
    if (any(active & curved & (!step.positive))) step = problem.solve(by_newton, damping);
    const auto finite = step.positive & is_finite(step.size2) & is_finite(step.promise);
    const auto undamped = damping <= zero;
    const auto arrived = active & finite & undamped & (step.size2 <= tolerance2) &
                         (step.promise <= T(options.gradient_tolerance) * (one + out.cost));
    const T cost = problem.try_step();
    // So near the minimum costs differ by rounding only. The model is as good as exact there, so its step is taken.
    const T rounding = problem.rounding(out.cost), gain = (out.cost - cost) / step.promise;
    const auto coarse = finite & (step.promise <= rounding);
    const auto lower = (coarse & (cost <= out.cost + rounding)) | ((!coarse) & (T(options.least_gain) < gain));
    const auto good = options.damped ? finite & lower : finite;
    const auto taken = active & (arrived | good);
    problem.take(taken);
    out.cost = select(taken, cost, out.cost);
    end(arrived, select(curved & (!by_newton), number_of(Status::saddle), number_of(Status::converged)));
    if (!options.damped) {
      end(active & (!finite), number_of(Status::not_finite));
      continue;
    }
    const auto went = active & good, rejected = active & (!good), poor = (!coarse) & (gain < T(0.25));
    const auto slow = undamped & (T(kSlow) * last2 < step.size2);
    const T less = select(T(kLeastDamping) < damping, damping / T(kFactor), zero);
    const T more = max(T(kFactor) * damping, T(kFirstDamping));
    // A step of Gauss-Newton that is refused is tried with the same damping by the true Hessian first.
    const auto raised = rejected & (curved | (!finite));
    damping = select(went & (coarse | (T(0.75) < gain)), less,
                     select(went & poor, T(2.0) * damping, select(raised, more, damping)));
    last2 = select(went, select(undamped, step.size2, T(kInfinity)), last2);
    curved = curved | (went & (slow | poor)) | (rejected & finite);
    end(raised & (T(kLargestDamping) < damping),
        select(finite, number_of(Status::no_descent), number_of(Status::not_finite)));
  }
  return out;
}

}  // namespace surveymc::stats
