#pragma once
/// Robust fit of the parameters of a tool to the stations of a run: least squares with a weight for each station, which
/// is found from the length of the station's residual, again and again (IRLS). For one trial or for lanes of trials.
///
///   minimise  sum_k w_k |r_k(x)|^2 + sum_a P_a x_a^2,   w_k = weight(|r_k| / s)   (loss.h)
/// Start: the least-squares fit, or of `lmeds` the fit to few stations for which the median of |r_k|^2 over all
/// stations is least, of many random subsets (P. Rousseeuw, J. Amer. Stat. Assoc. 79, 1984: least median of squares),
/// then twice the fit to the half of the stations that it is nearest to, if that has a smaller median (Rousseeuw and
/// K. Van Driessen, Data Min. Knowl. Disc. 12, 2006: concentration): a subset is small, and its own noise is large.
/// All these fits are of residuals linearised at the start. Loss tukey has no breakdown point from a least-squares
/// start: what holds the fit has weight one there. A lane that has finished is frozen: its answer does not depend on
/// the other lanes.
#include <algorithm>
#include <cstddef>

#include "multistation/fit_kernel.h"
#include "multistation/loss.h"
#include "multistation/sorted.h"

namespace surveymc::multistation {

/// Which scale the residuals have.
enum class RobustScale {
  reweighted,  ///< the median of the residuals, anew before each reweighting
  start,       ///< of the start's residuals, from then on
  a_priori     ///< 1: residuals are in units of their standard deviation
};
enum class RobustStart { least_squares, lmeds };

struct RobustOptions {
  Loss loss = Loss::cauchy;
  RobustScale scale = RobustScale::reweighted;
  RobustStart start = RobustStart::least_squares;
  int reweightings = 200;     ///< at most; l1 takes some 50 where a fifth of the stations is wrong
  int newton_steps = 10;      ///< of the least-squares fit, at most
  double tolerance = 1e-4;    ///< ends when every step is below this part of `unit`
  double smallest_scale = 0;  ///< s is at least this: where all residuals vanish
};

struct RobustShape {
  int stations = 0, components = 0, parameters = 0;  ///< parameters: a multiple of three, at most kUnknowns
};

/// What all trials of a fit share. Parameters are near 0 and have any unit.
struct RobustProblem {
  RobustShape shape;
  const double* unit = nullptr;               ///< of each parameter: its size that matters
  const double* prior_information = nullptr;  ///< P_a, 1 / variance, in the units of the residuals; 0: no prior
  double scale_of_median = 1;                 ///< loss.h
  const int* subsets = nullptr;               ///< stations of each, one subset after the other; of lmeds
  int subset_count = 0, subset_size = 0;      ///< count: a multiple of kTogether
  /// Of the least-squares fit, a row of kGroup lanes a station; null: 1. Loss least_squares keeps them.
  const double* given_weights = nullptr;
  /// Of each three parameters, whether they move the first component of a station; null: all do.
  const bool* moves_first = nullptr;
};

/// Subsets whose residuals are found together: the derivatives are read once.
inline constexpr int kTogether = 4;
/// Of the start lmeds.
inline constexpr int kConcentrations = 2;
/// A least-squares start needs no more than this part of `unit`.
inline constexpr double kStartTolerance = 0.01;
/// Within this part of `unit` the model is taken as linear: its derivatives change by some 5e-5.
inline constexpr double kLinear = 0.03;

/// Memory of one fit, in values of T: arrays one after the other.
template <class T>
struct RobustMemory {
  T *residual, *jacobian;                                     ///< (k components + i), times parameters + a
  T* weight;                                                  ///< a station
  T *matrix, *gradient, *x, *step, *best, *sorted, *squares;  ///< step, sorted: kTogether of them
  static constexpr std::size_t size(const RobustShape& s) {
    const auto k = static_cast<std::size_t>(s.stations), c = static_cast<std::size_t>(s.components),
               p = static_cast<std::size_t>(s.parameters);
    return k * c * (1 + p) + (2 + kTogether) * k + p * (p + 1) / 2 + (3 + kTogether) * p;
  }
  RobustMemory(T* memory, const RobustShape& s) {
    const auto k = static_cast<std::size_t>(s.stations), c = static_cast<std::size_t>(s.components),
               p = static_cast<std::size_t>(s.parameters);
    const auto next = [&memory](std::size_t n) {
      T* at = memory;
      memory += n;
      return at;
    };
    residual = next(k * c);
    jacobian = next(k * c * p);
    weight = next(k);
    sorted = next(kTogether * k);
    squares = next(k);
    matrix = next(p * (p + 1) / 2);
    gradient = next(p);
    x = next(p);
    step = next(kTogether * p);
    best = next(p);
  }
};

/// What is found beside x and the weights, which are in the memory.
template <class T>
struct RobustOutcome {
  T scale;         ///< s
  T reweightings;  ///< that were made
  T converged;     ///< 1; 0 where the stations do not determine the parameters, or steps remain large
};

template <class T, int C>
struct Reweighting {
  const RobustProblem& problem;
  const RobustOptions& options;
  RobustMemory<T> m;
  int stations, parameters;

  Reweighting(const RobustProblem& p, const RobustOptions& o, T* memory)
      : problem(p), options(o), m(memory, p.shape), stations(p.shape.stations), parameters(p.shape.parameters) {}

  /// The first component that moves by the three parameters 3 a, ...
  int first_of(int a) const { return C == kResiduals && problem.moves_first && !problem.moves_first[a] ? 1 : 0; }

  /// Normal equations at m.x of the stations that `station(0)`, ... name, `count` of them, with their weights or with
  /// weight one. Block by block of three parameters, whose nine sums stay in registers.
  template <bool Weighted, class Station>
  void make_equations(int count, const Station& station) {
    const int kinds = parameters / 3;
    for (int a = 0; a < kinds; ++a)
      for (int b = 0; b <= a; ++b) {
        T sum[9], g[3];
        for (T& v : sum) v = T(0.0);
        for (T& v : g) v = T(0.0);
        const int first = std::max(first_of(a), first_of(b));
        for (int n = 0; n < count; ++n) {
          const int k = station(n);
          const T* rows = m.jacobian + static_cast<std::ptrdiff_t>(k) * C * parameters;
          const T* residual = m.residual + static_cast<std::ptrdiff_t>(k) * C;
          for (int i = first; i < C; ++i) {
            const T *of_a = rows + i * parameters + 3 * a, *of_b = rows + i * parameters + 3 * b;
#pragma GCC unroll 3
            for (int u = 0; u < 3; ++u) {
              const T w = Weighted ? m.weight[k] * of_a[u] : of_a[u];
#pragma GCC unroll 3
              for (int v = 0; v < 3; ++v) sum[3 * u + v] = fma(w, of_b[v], sum[3 * u + v]);
              if (a == b) g[u] = fma(w, residual[i], g[u]);
            }
          }
        }
        for (int u = 0; u < 3; ++u) {
          const auto i = static_cast<std::size_t>(3 * a + u);
          for (int v = 0; v < 3 && 3 * b + v <= 3 * a + u; ++v)
            m.matrix[packed(i, static_cast<std::size_t>(3 * b + v))] = sum[3 * u + v];
          if (a == b) m.gradient[i] = g[u];
        }
      }
    for (int i = 0; i < parameters; ++i) {
      const T information(problem.prior_information ? problem.prior_information[i] : 0.0);
      T& diagonal = m.matrix[packed(static_cast<std::size_t>(i), static_cast<std::size_t>(i))];
      diagonal = diagonal + information;
      m.gradient[i] = fma(information, m.x[i], m.gradient[i]);
    }
  }

  /// step = -matrix^-1 gradient; not finite where the matrix is singular.
  void solve_equations(T* step) {
    const auto n = static_cast<std::size_t>(parameters);
    factorise(n, m.matrix);
    for (std::size_t i = 0; i < n; ++i) step[i] = -m.gradient[i];
    solve_factorised(n, m.matrix, step);
  }

  /// The step is finite and its matrix positive definite.
  auto sound(const T* step) const {
    auto good = T(0.0) < T(1.0);
    for (int a = 0; a < parameters; ++a)
      good = good & (T(0.0) < m.matrix[a * (a + 1) / 2 + a]) & (abs(step[a]) < T(1e300));
    return good;
  }

  /// m.squares: |r_k|^2.
  void square_residuals() {
    for (int k = 0; k < stations; ++k) {
      T sum(0.0);
      for (int i = 0; i < C; ++i) {
        const T r = m.residual[k * C + i];
        sum = fma(r, r, sum);
      }
      m.squares[k] = sum;
    }
  }

  /// The median of the lengths whose squares are given, over scale_of_median.
  T scale_of(const T* squares) {
    for (int k = 0; k < stations; ++k) m.sorted[k] = sqrt(squares[k]);
    return max(median_of(m.sorted, stations) * T(1 / problem.scale_of_median), T(options.smallest_scale));
  }

  /// |r_k|^2 of the linearised residuals after each of N steps, which stand one after the other, as do the answers.
  template <int N>
  void square_after(const T* steps, T* squares) const {
    for (int k = 0; k < stations; ++k) {
      const T *row = m.jacobian + static_cast<std::ptrdiff_t>(k) * C * parameters, *residual = m.residual + k * C;
      T sum[N];
      for (T& v : sum) v = T(0.0);
      for (int i = 0; i < C; ++i, row += parameters) {
        T r[N];
        for (T& v : r) v = residual[i];
        for (int a = 0; a < parameters / 3; ++a) {
          if (i < first_of(a)) continue;
#pragma GCC unroll 3
          for (int u = 3 * a; u < 3 * a + 3; ++u)
            for (int n = 0; n < N; ++n) r[n] = fma(row[u], steps[n * parameters + u], r[n]);
        }
        for (int n = 0; n < N; ++n) sum[n] = fma(r[n], r[n], sum[n]);
      }
      for (int n = 0; n < N; ++n) squares[n * stations + k] = sum[n];
    }
  }

  /// The step from m.x to the least median of squares: m.best.
  void find_start() {
    T least(1e300);
    for (int a = 0; a < parameters; ++a) m.best[a] = T(0.0);
    const auto take_if_better = [&](const T* step, T* squares, const auto& is_sound) {
      T below(0.0);  // a median below `least` has half of them below it: most subsets need no sorting
      for (int k = 0; k < stations; ++k) below = below + select(squares[k] < least, T(1.0), T(0.0));
      if (!any(is_sound & (T(0.5 * stations) <= below))) return;
      const T median = median_of(squares, stations);
      const auto better = (median < least) & is_sound;
      least = select(better, median, least);
      for (int a = 0; a < parameters; ++a) m.best[a] = select(better, step[a], m.best[a]);
    };
    for (int s = 0; s < problem.subset_count; s += kTogether) {
      decltype(sound(m.step)) is_sound[kTogether];
      for (int n = 0; n < kTogether; ++n) {
        const int* chosen = problem.subsets + static_cast<std::ptrdiff_t>(s + n) * problem.subset_size;
        make_equations<false>(problem.subset_size, [chosen](int i) { return chosen[i]; });
        solve_equations(m.step + n * parameters);
        is_sound[n] = sound(m.step + n * parameters);
      }
      square_after<kTogether>(m.step, m.sorted);
      for (int n = 0; n < kTogether; ++n) take_if_better(m.step + n * parameters, m.sorted + n * stations, is_sound[n]);
    }
    for (int n = 0; n < kConcentrations; ++n) {
      square_after<1>(m.best, m.squares);
      for (int k = 0; k < stations; ++k) m.weight[k] = select(m.squares[k] <= least, T(1.0), T(0.0));
      make_equations<true>(stations, [](int k) { return k; });
      solve_equations(m.step);
      square_after<1>(m.step, m.sorted);
      take_if_better(m.step, m.sorted, sound(m.step));
    }
  }

  /// Residuals at m.x, which is m.step after the last one: by the model where the step is large, of others linear.
  template <class Evaluate, class Mask>
  void move_residuals(const Evaluate& evaluate, const Mask& large) {
    if (!all(large))
      for (int k = 0; k < stations; ++k)
        for (int i = 0; i < C; ++i) {
          const T* row = m.jacobian + static_cast<std::ptrdiff_t>(k * C + i) * parameters;
          T r = m.residual[k * C + i];
          for (int a = 0; a < parameters; ++a) r = fma(row[a], m.step[a], r);
          m.residual[k * C + i] = r;
        }
    if (any(large)) evaluate(m.x, m.residual, m.jacobian, large);
  }

  /// `evaluate(x, residual, jacobian, which)` fills both arrays of the memory in the lanes `which`. The start is
  /// `start`.
  template <class Evaluate>
  RobustOutcome<T> run(const Evaluate& evaluate, const T* start) {
    const T one(1.0), zero(0.0);
    for (int a = 0; a < parameters; ++a) m.x[a] = start[a];
    const auto everyone = zero < one;
    auto good = everyone, active = everyone;
    double tolerance = options.tolerance;
    // One step with the weights there are; what is not active stays. Which steps were large.
    const auto step = [&] {
      make_equations<true>(stations, [](int k) { return k; });
      solve_equations(m.step);
      const auto sound_step = sound(m.step);
      good = good & (sound_step | (!active));
      T largest(0.0);
      for (int a = 0; a < parameters; ++a) {
        m.step[a] = select(active & sound_step, m.step[a], zero);
        m.x[a] = m.x[a] + m.step[a];
        largest = max(largest, abs(m.step[a]) * T(1 / problem.unit[a]));
      }
      active = active & sound_step & (T(tolerance) < largest);
      return active & (T(kLinear) < largest);
    };
    evaluate(m.x, m.residual, m.jacobian, everyone);
    if (options.start == RobustStart::lmeds) {
      find_start();
      for (int a = 0; a < parameters; ++a) m.x[a] = m.x[a] + m.best[a];
      evaluate(m.x, m.residual, m.jacobian, everyone);
    }
    for (int k = 0; k < stations; ++k)
      m.weight[k] =
          problem.given_weights ? load<T>(problem.given_weights + static_cast<std::ptrdiff_t>(k) * kGroup) : one;
    if (options.start == RobustStart::least_squares) {
      if (options.loss != Loss::least_squares) tolerance = std::max(tolerance, kStartTolerance);
      for (int i = 0; i < options.newton_steps && any(active); ++i) move_residuals(evaluate, step());
      tolerance = options.tolerance;
    }
    RobustOutcome<T> out;
    square_residuals();
    out.scale = options.scale == RobustScale::a_priori ? one : scale_of(m.squares);
    out.reweightings = zero;
    if (options.loss != Loss::least_squares) active = good;
    for (int n = 0; options.loss != Loss::least_squares && n < options.reweightings && any(active); ++n) {
      if (options.scale == RobustScale::reweighted && n > 0) out.scale = select(active, scale_of(m.squares), out.scale);
      const T per_scale2 = one / (out.scale * out.scale);
      for (int k = 0; k < stations; ++k)
        m.weight[k] = select(active, station_weight<T>(options.loss, m.squares[k] * per_scale2), m.weight[k]);
      out.reweightings = select(active, out.reweightings + one, out.reweightings);
      const auto large = step();
      if (!any(active)) break;  // the last step is below the tolerance
      move_residuals(evaluate, large);
      square_residuals();
    }
    out.converged = select(good & (!active), one, zero);
    return out;
  }
};

/// Reweighting of stations with C components. Results are in RobustMemory(memory, shape): x, weight, residual
/// (at x, but for a last step below the tolerance).
template <class T, int C, class Evaluate>
RobustOutcome<T> reweight(const RobustProblem& problem, const RobustOptions& options, const Evaluate& evaluate,
                          const T* start, T* memory) {
  return Reweighting<T, C>(problem, options, memory).run(evaluate, start);
}

}  // namespace surveymc::multistation
