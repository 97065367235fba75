#pragma once
/// The problems of stats/descent.h for several starts side by side, all from the same readings: the chain, one station
/// alone (attitude search), and constant offsets (offset search). T: double or Lanes. Readable models: block_solver.cpp
/// for the chain, mode_search.h for the searches.
#include "chained/model.h"
#include "chained/reading_residual.h"
#include "simd/solve.h"
#include "stats/descent.h"

namespace surveymc::chained {

using namespace simd;
using stats::descend;
using stats::DescentEnd;
using stats::DescentStep;

/// Attitudes in Levenberg's scale D: 1 / (0.1 rad)^2. Marquardt's diagonal would hold back most where the
/// accelerometers see the attitude, and the weak direction is a turn about the vertical.
inline constexpr double kAttitudeScale = 1 / (0.1 * 0.1);

/// The model as plain numbers: weights are 1 / sd^2. No interference, no known states.
struct DescentModel {
  double gravity, horizontal, down;
  double first[kChainStates],
      later[kChainStates];    ///< of the states themselves, at the first station and at the others
  double link[kChainStates];  ///< of their changes; 0 where there is no link
  double links[kChainStates * (kChainStates + 1) / 2];  ///< products of two of them
  double scale[kChainStates];                           ///< 1 / prior sd^2
  double per_rounding, rounding_of_cost;                ///< rounding of J: a sqrt(1 + J) + b J
  int stations;
  const double *readings, *weights;  ///< rows 6 k + axis; the weight of a reading left out is 0
};

/// v_i w_i
template <class T>
survey::Vec3<T> weighted(const survey::Vec3<T>& v, const double* w) {
  return {v.x * T(w[0]), v.y * T(w[1]), v.z * T(w[2])};
}

/// A station of all starts to first order: half the Hessian [A C; C' D], with J'J or Newton's second order in it, and
/// half the negative gradient. Columns of C by chained state.
template <class T>
struct StationNormal {
  Symmetric<T, 3> a;
  std::array<std::array<T, 3>, kChainStates> c;
  Symmetric<T, kChainStates> d;
  std::array<T, 3> by_delta;
  std::array<T, kChainStates> by_chain;
};

template <class T>
std::array<T, 6> broadcast(const double* y) {
  return {T(y[0]), T(y[1]), T(y[2]), T(y[3]), T(y[4]), T(y[5])};
}

/// [v]x' W [v]x, added to the attitude's block.
template <class T>
void add_turns(Symmetric<T, 3>& a, const survey::Vec3<T>& v, const double* w) {
  const T wx(w[0]), wy(w[1]), wz(w[2]);
  a[packed(0, 0)] = a[packed(0, 0)] + fma(wz * v.y, v.y, wy * v.z * v.z);
  a[packed(1, 1)] = a[packed(1, 1)] + fma(wz * v.x, v.x, wx * v.z * v.z);
  a[packed(2, 2)] = a[packed(2, 2)] + fma(wy * v.x, v.x, wx * v.y * v.y);
  a[packed(1, 0)] = a[packed(1, 0)] - wz * v.x * v.y;
  a[packed(2, 0)] = a[packed(2, 0)] - wy * v.x * v.z;
  a[packed(2, 1)] = a[packed(2, 1)] - wx * v.y * v.z;
}

/// Second-order part of the attitude's block (StationCurvature): -s ((u v' + v u')/2 - (u.v) 1), s: 1 or 0.
template <class T>
void add_curvature(Symmetric<T, 3>& a, const survey::Vec3<T>& u, const survey::Vec3<T>& v, const T& s) {
  const T half = T(-0.5) * s, along = s * dot(u, v);
  a[packed(0, 0)] = a[packed(0, 0)] + fma(T(2.0) * half * u.x, v.x, along);
  a[packed(1, 1)] = a[packed(1, 1)] + fma(T(2.0) * half * u.y, v.y, along);
  a[packed(2, 2)] = a[packed(2, 2)] + fma(T(2.0) * half * u.z, v.z, along);
  a[packed(1, 0)] = fma(half, fma(u.x, v.y, v.x * u.y), a[packed(1, 0)]);
  a[packed(2, 0)] = fma(half, fma(u.x, v.z, v.x * u.z), a[packed(2, 0)]);
  a[packed(2, 1)] = fma(half, fma(u.y, v.z, v.y * u.z), a[packed(2, 1)]);
}

/// Residuals, and what they are linear in: f, h (model.h) and u = W e.
template <class T>
struct StationFieldsAt {
  survey::Vec3<T> f, h, uf, uh;
};
template <class T>
StationFieldsAt<T> fields_at(const DescentModel& m, const double* y, const double* w, const ToolFrame<T>& frame,
                             const std::array<T, kChainStates>& c) {
  const T zero(0.0);
  const auto e = reading_residual<T>(m.gravity, m.horizontal, m.down, broadcast<T>(y), frame, c, {zero, zero, zero});
  return {scale(-(T(m.gravity) + c[0]), frame.d),
          scale(T(m.horizontal) + c[1], frame.n) + scale(T(m.down) + c[2], frame.d),
          weighted(survey::Vec3<T>{e[0], e[1], e[2]}, w), weighted(survey::Vec3<T>{e[3], e[4], e[5]}, w + 3)};
}

/// Sum of the weighted squares of a station's residuals.
template <class T>
[[gnu::noinline]] T station_cost(const DescentModel& m, const double* y, const double* w, const ToolFrame<T>& frame,
                                 const std::array<T, kChainStates>& c) {
  const T zero(0.0);
  const auto e = reading_residual<T>(m.gravity, m.horizontal, m.down, broadcast<T>(y), frame, c, {zero, zero, zero});
  T sum = zero;
  for (std::size_t i = 0; i < 6; ++i) sum = fma(e[i] * T(w[i]), e[i], sum);
  return sum;
}

/// Normal equations of the readings of one station. `curved`: 1 where the true Hessian is wanted, else 0.
template <class T>
[[gnu::noinline, gnu::flatten]] StationNormal<T> station_normal(const DescentModel& m, const double* y, const double* w,
                                                                const ToolFrame<T>& frame,
                                                                const std::array<T, kChainStates>& c, const T& curved) {
  const StationFieldsAt<T> s = fields_at(m, y, w, frame, c);
  const survey::Vec3<T>&n = frame.n, &d = frame.d;
  const T zero(0.0), one(1.0);
  StationNormal<T> out;
  for (T& x : out.a) x = zero;
  add_turns(out.a, s.f, w);
  add_turns(out.a, s.h, w + 3);
  add_curvature(out.a, s.uf, s.f, curved);
  add_curvature(out.a, s.uh, s.h, curved);
  const auto column = [](const survey::Vec3<T>& v) { return std::array<T, 3>{v.x, v.y, v.z}; };
  const survey::Vec3<T> x{one, zero, zero}, yy{zero, one, zero}, z{zero, zero, one};
  const survey::Vec3<T> wd = weighted(d, w), vn = weighted(n, w + 3), vd = weighted(d, w + 3);
  out.c[0] = column(scale(curved, cross(d, s.uf)) - cross(s.f, wd));
  out.c[1] = column(cross(s.h, vn) - scale(curved, cross(n, s.uh)));
  out.c[2] = column(cross(s.h, vd) - scale(curved, cross(d, s.uh)));
  out.c[3] = column(scale(T(w[0]), cross(s.f, x)));
  out.c[4] = column(scale(T(w[1]), cross(s.f, yy)));
  out.c[5] = column(scale(T(w[2]), cross(s.f, z)));
  out.c[6] = column(scale(T(w[3]), cross(s.h, x)));
  out.c[7] = column(scale(T(w[4]), cross(s.h, yy)));
  out.c[8] = column(scale(T(w[5]), cross(s.h, z)));
  for (T& v : out.d) v = zero;
  out.d[packed(0, 0)] = dot(d, wd);
  out.d[packed(1, 1)] = dot(n, vn);
  out.d[packed(2, 1)] = dot(n, vd);
  out.d[packed(2, 2)] = dot(d, vd);
  const std::array<T, 3> of_g = column(wd), of_h = column(vn), of_d = column(vd);
  for (std::size_t i = 0; i < 3; ++i) {
    out.d[packed(3 + i, 0)] = -of_g[i];
    out.d[packed(3 + i, 3 + i)] = T(w[i]);
    out.d[packed(6 + i, 1)] = of_h[i];
    out.d[packed(6 + i, 2)] = of_d[i];
    out.d[packed(6 + i, 6 + i)] = T(w[3 + i]);
  }
  out.by_delta = column(cross(s.f, s.uf) + cross(s.h, s.uh));
  out.by_chain = {zero - dot(d, s.uf), dot(n, s.uh), dot(d, s.uh), s.uf.x, s.uf.y, s.uf.z, s.uh.x, s.uh.y, s.uh.z};
  return out;
}

/// ldlt (simd/solve.h) of nine chained states. This and the three functions below are a block's arithmetic, unrolled
/// (a few kilobytes each: entries stay in registers) and never inlined, as a descent would be hundreds of kilobytes.
template <class T>
[[gnu::noinline, gnu::flatten]] Symmetric<T, kChainStates> chain_ldlt(Symmetric<T, kChainStates> a) {
  return ldlt<T, kChainStates>(a);
}
/// A^-1 from chain_ldlt(A): all of a station's solutions are products with it, which do not wait for one another.
template <class T>
[[gnu::noinline]] Symmetric<T, kChainStates> chain_inverse(const Symmetric<T, kChainStates>& f) {
  Symmetric<T, kChainStates> l, out;  // l: the inverse of the unit triangle
#pragma GCC unroll 9
  for (std::size_t j = 0; j < kChainStates; ++j) {
    l[packed(j, j)] = T(1.0);
#pragma GCC unroll 9
    for (std::size_t i = j + 1; i < kChainStates; ++i) {
      T s = -f[packed(i, j)];
#pragma GCC unroll 9
      for (std::size_t k = j + 1; k < i; ++k) s = fma(-f[packed(i, k)], l[packed(k, j)], s);
      l[packed(i, j)] = s;
    }
  }
#pragma GCC unroll 9
  for (std::size_t a = 0; a < kChainStates; ++a) {
    std::array<T, kChainStates> scaled;  // column a over D
#pragma GCC unroll 9
    for (std::size_t i = a; i < kChainStates; ++i) scaled[i] = l[packed(i, a)] * f[packed(i, i)];
#pragma GCC unroll 9
    for (std::size_t b = 0; b <= a; ++b) {
      T s(0.0);
#pragma GCC unroll 9
      for (std::size_t i = a; i < kChainStates; ++i) s = fma(scaled[i], l[packed(i, b)], s);
      out[packed(a, b)] = s;
    }
  }
  return out;
}

template <class T>
[[gnu::noinline]] std::array<T, kChainStates> chain_product(const Symmetric<T, kChainStates>& m,
                                                            const std::array<T, kChainStates>& x) {
  std::array<T, kChainStates> y;
  for (T& v : y) v = T(0.0);
    // A column at a time: nine sums that do not wait for one another
#pragma GCC unroll 9
  for (std::size_t j = 0; j < kChainStates; ++j) {
#pragma GCC unroll 9
    for (std::size_t i = 0; i < j; ++i) y[i] = fma(m[packed(j, i)], x[j], y[i]);
#pragma GCC unroll 9
    for (std::size_t i = j; i < kChainStates; ++i) y[i] = fma(m[packed(i, j)], x[j], y[i]);
  }
  return y;
}

template <class T, std::size_t N>
auto all_positive(const Symmetric<T, N>& factor) {
  auto positive = T(0.0) < factor[0];
#pragma GCC unroll 1
  for (std::size_t i = 1; i < N; ++i) positive = positive & (T(0.0) < factor[packed(i, i)]);
  return positive;
}

/// What a descent of the chain keeps of a station.
template <class T>
struct DescentMemory {
  ToolFrame<T> frame, next_frame;
  std::array<T, kChainStates> c, next_c;
  std::array<T, 3> gradient, turned;                    ///< by_delta; A^-1 of it
  std::array<std::array<T, 3>, kChainStates> coupling;  ///< A^-1 C
  std::array<T, kChainStates> slope, reduced;           ///< by_chain with all pulls; right side after elimination
  Symmetric<T, kChainStates> inverse;                   ///< of the states' block after elimination
};

/// Eliminates the attitude from a station's normal equations: A's factor (returned), A^-1 times gradient and C, and
/// what is left for the chained states, D - C' A^-1 C (in n.d) and their right side.
template <class T>
[[gnu::noinline, gnu::flatten]] Symmetric<T, 3> eliminate_attitude(StationNormal<T>& n, DescentMemory<T>& s) {
  const Symmetric<T, 3> a = ldlt<T, 3>(n.a);
  s.turned = ldlt_solve<T, 3>(a, s.gradient);
#pragma GCC unroll 9
  for (std::size_t i = 0; i < kChainStates; ++i) s.coupling[i] = ldlt_solve<T, 3>(a, n.c[i]);
#pragma GCC unroll 9
  for (std::size_t i = 0; i < kChainStates; ++i) {
    T r = s.slope[i];
    for (std::size_t x = 0; x < 3; ++x) r = fma(-n.c[i][x], s.turned[x], r);
    s.reduced[i] = r;
#pragma GCC unroll 9
    for (std::size_t j = 0; j <= i; ++j) {
      T d = n.d[packed(i, j)];
      for (std::size_t x = 0; x < 3; ++x) d = fma(-n.c[i][x], s.coupling[j][x], d);
      n.d[packed(i, j)] = d;
    }
  }
  return a;
}
/// Adds what the stations to the left say of the states: their solution `before` and the inverse of their block.
template <class T>
[[gnu::noinline]] void couple_left(const DescentModel& m, const std::array<T, kChainStates>& before,
                                   const Symmetric<T, kChainStates>& inverse, Symmetric<T, kChainStates>& d,
                                   std::array<T, kChainStates>& right) {
#pragma GCC unroll 1
  for (std::size_t i = 0; i < kChainStates; ++i) right[i] = fma(T(m.link[i]), before[i], right[i]);
#pragma GCC unroll 1
  for (std::size_t e = 0; e < d.size(); ++e) d[e] = fma(T(-m.links[e]), inverse[e], d[e]);
}

/// The whole chain. A station's attitude is eliminated first, then the chained states from the first station to the
/// last.
template <class T>
class ChainDescent {
 public:
  using Scalar = T;
  using Mask = decltype(T(0.0) < T(0.0));

  /// frame and c of `memory` are the start.
  ChainDescent(const DescentModel& m, DescentMemory<T>* memory) : m_(m), at_(memory) {}

  T cost() const {
    return cost_of([](const DescentMemory<T>& s) -> const ToolFrame<T>& { return s.frame; },
                   [](const DescentMemory<T>& s) -> const std::array<T, kChainStates>& { return s.c; });
  }

  [[gnu::noinline]] DescentStep<T, Mask> solve(const Mask& where_curved, const T& damping) {
    const T zero(0.0), curved = select(where_curved, T(1.0), zero);
    Mask positive = zero < T(1.0);
    std::array<T, kChainStates> before;  // solution from the left of the station before
    for (int k = 0; k < m_.stations; ++k) {
      DescentMemory<T>& s = at_[k];
      StationNormal<T> n = station_normal(m_, y(k), w(k), s.frame, s.c, curved);
#pragma GCC unroll 1
      for (std::size_t i = 0; i < kChainStates; ++i) {
        const double own = k == 0 ? m_.first[i] : m_.later[i];
        T pull = T(-own) * s.c[i], weight(own);
        if (k > 0) {
          pull = fma(T(m_.link[i]), at_[k - 1].c[i] - s.c[i], pull);
          weight = weight + T(m_.link[i]);
        }
        if (k + 1 < m_.stations) {
          pull = fma(T(m_.link[i]), at_[k + 1].c[i] - s.c[i], pull);
          weight = weight + T(m_.link[i]);
        }
        s.slope[i] = n.by_chain[i] + pull;
        n.d[packed(i, i)] = n.d[packed(i, i)] + fma(damping, T(m_.scale[i]), weight);
      }
      s.gradient = n.by_delta;
      for (std::size_t i = 0; i < 3; ++i) n.a[packed(i, i)] = fma(damping, T(kAttitudeScale), n.a[packed(i, i)]);
      const Symmetric<T, 3> a = eliminate_attitude(n, s);
      if (k > 0) couple_left(m_, before, at_[k - 1].inverse, n.d, s.reduced);
      const Symmetric<T, kChainStates> factor = chain_ldlt<T>(n.d);
      positive = positive & all_positive<T, 3>(a) & all_positive<T, kChainStates>(factor);
      s.inverse = chain_inverse<T>(factor);
      if (k + 1 < m_.stations) before = chain_product<T>(s.inverse, s.reduced);
    }
    DescentStep<T, Mask> step{positive, zero, zero};
    std::array<T, kChainStates> x;
    for (int k = m_.stations - 1; k >= 0; --k) {
      DescentMemory<T>& s = at_[k];
      std::array<T, kChainStates> r = s.reduced;
      if (k + 1 < m_.stations)
#pragma GCC unroll 1
        for (std::size_t i = 0; i < kChainStates; ++i) r[i] = fma(T(m_.link[i]), x[i], r[i]);
      x = chain_product<T>(s.inverse, r);
      std::array<T, 3> delta = s.turned;
      T turns = zero, states = zero;
#pragma GCC unroll 1
      for (std::size_t i = 0; i < kChainStates; ++i) {
        for (std::size_t a = 0; a < 3; ++a) delta[a] = fma(-s.coupling[i][a], x[i], delta[a]);
        states = fma(T(m_.scale[i]) * x[i], x[i], states);
        step.promise = fma(s.slope[i], x[i], step.promise);
        s.next_c[i] = s.c[i] + x[i];
      }
      for (std::size_t a = 0; a < 3; ++a) {
        turns = fma(delta[a], delta[a], turns);
        step.promise = fma(s.gradient[a], delta[a], step.promise);
      }
      step.promise = fma(damping, fma(T(kAttitudeScale), turns, states), step.promise);
      step.size2 = step.size2 + fma(T(1e6), turns, states);
      s.next_frame = chained::turned<T>({delta[0], delta[1], delta[2]}, s.frame);
    }
    step.size2 = step.size2 * T(1.0 / m_.stations);
    return step;
  }

  T try_step() const {
    return cost_of([](const DescentMemory<T>& s) -> const ToolFrame<T>& { return s.next_frame; },
                   [](const DescentMemory<T>& s) -> const std::array<T, kChainStates>& { return s.next_c; });
  }

  void take(const Mask& where) {
    for (int k = 0; k < m_.stations; ++k) {
      DescentMemory<T>& s = at_[k];
      take_frame(where, s.next_frame, s.frame);
#pragma GCC unroll 1
      for (std::size_t i = 0; i < kChainStates; ++i) s.c[i] = select(where, s.next_c[i], s.c[i]);
    }
  }

  T rounding(const T& cost) const {
    return fma(T(m_.per_rounding), sqrt(T(1.0) + cost), T(m_.rounding_of_cost) * cost);
  }

  static void take_frame(const Mask& where, const ToolFrame<T>& next, ToolFrame<T>& frame) {
    frame.n = {select(where, next.n.x, frame.n.x), select(where, next.n.y, frame.n.y),
               select(where, next.n.z, frame.n.z)};
    frame.d = {select(where, next.d.x, frame.d.x), select(where, next.d.y, frame.d.y),
               select(where, next.d.z, frame.d.z)};
  }

 private:
  const double* y(int k) const { return m_.readings + 6 * static_cast<std::size_t>(k); }
  const double* w(int k) const { return m_.weights + 6 * static_cast<std::size_t>(k); }

  template <class Frame, class Chain>
  T cost_of(const Frame& frame, const Chain& chain) const {
    T sum(0.0);
    for (int k = 0; k < m_.stations; ++k) {
      const std::array<T, kChainStates>& c = chain(at_[k]);
      sum = sum + station_cost(m_, y(k), w(k), frame(at_[k]), c);
#pragma GCC unroll 1
      for (std::size_t i = 0; i < kChainStates; ++i) {
        sum = fma(T(k == 0 ? m_.first[i] : m_.later[i]) * c[i], c[i], sum);
        if (k == 0) continue;
        const T change = c[i] - chain(at_[k - 1])[i];
        sum = fma(T(m_.link[i]) * change, change, sum);
      }
    }
    return sum;
  }

  const DescentModel& m_;
  DescentMemory<T>* at_;
};

/// The attitude of one station alone, with no offset and the given weights.
template <class T>
class AttitudeDescent {
 public:
  using Scalar = T;
  using Mask = decltype(T(0.0) < T(0.0));

  AttitudeDescent(const DescentModel& m, int station, const ToolFrame<T>& start)
      : m_(m),
        y_(m.readings + 6 * static_cast<std::size_t>(station)),
        w_(m.weights + 6 * static_cast<std::size_t>(station)),
        frame_(start),
        next_(start) {
    for (T& c : none_) c = T(0.0);
    // A turn moves the readings by up to |field|: its weight in units of theirs.
    scale_ = (w_[0] + w_[1] + w_[2]) * m.gravity * m.gravity +
             (w_[3] + w_[4] + w_[5]) * (m.horizontal * m.horizontal + m.down * m.down);
  }

  const ToolFrame<T>& frame() const { return frame_; }
  T cost() const { return station_cost(m_, y_, w_, frame_, none_); }
  [[gnu::noinline]] DescentStep<T, Mask> solve(const Mask& where_curved, const T& damping) {
    StationNormal<T> n = station_normal(m_, y_, w_, frame_, none_, select(where_curved, T(1.0), T(0.0)));
    const T more = damping * T(scale_);
    for (std::size_t i = 0; i < 3; ++i) n.a[packed(i, i)] = n.a[packed(i, i)] + more;
    const Symmetric<T, 3> factor = ldlt<T, 3>(n.a);
    const std::array<T, 3> x = ldlt_solve<T, 3>(factor, n.by_delta);
    const T size2 = fma(x[0], x[0], fma(x[1], x[1], x[2] * x[2]));
    next_ = turned<T>({x[0], x[1], x[2]}, frame_);
    const T along = fma(n.by_delta[0], x[0], fma(n.by_delta[1], x[1], n.by_delta[2] * x[2]));
    return {all_positive<T, 3>(factor), fma(more, size2, along), size2};
  }
  T try_step() const { return station_cost(m_, y_, w_, next_, none_); }
  void take(const Mask& where) { ChainDescent<T>::take_frame(where, next_, frame_); }
  T rounding(const T& cost) const { return T(1e-12) * (T(1.0) + cost); }

 private:
  const DescentModel& m_;
  const double *y_, *w_;
  double scale_;
  std::array<T, kChainStates> none_;
  ToolFrame<T> frame_, next_;
};

/// The offset search as plain numbers; readings as in DescentModel.
struct OffsetModel {
  double gravity, horizontal, down;
  double per_sd[3];     ///< of gravity, horizontal and downward field of a station, 1/(m/s2), 1/nT
  double offset_sd[6];  ///< prior sd of the offsets
  int stations;
  const double* readings;
};

/// Constant offsets b, in units of their prior sd. With f and h the readings without them:
///   d = -f/|f|,  down = d.h,  level = h - down d,  n = level/|level|
///   d|f|/db_a = d,  d(down)/d(b_a, b_m) = (level/|f|, -d),  d|level|/d(b_a, b_m) = (-down n/|f|, -n).
template <class T>
class OffsetDescent {
 public:
  using Scalar = T;
  using Mask = decltype(T(0.0) < T(0.0));

  OffsetDescent(const OffsetModel& m, const std::array<T, 6>& start) : m_(m), x_(start), next_(start) {}

  const std::array<T, 6>& offsets() const { return x_; }
  T cost() const { return cost_at(x_); }
  [[gnu::noinline]] DescentStep<T, Mask> solve(const Mask&, const T& damping) {  // Gauss-Newton's matrix alone
    const T zero(0.0);
    Symmetric<T, 6> a;
    std::array<T, 6> g;
    for (T& v : a) v = zero;
#pragma GCC unroll 1
    for (std::size_t i = 0; i < 6; ++i) {
      a[packed(i, i)] = T(1.0) + damping;
      g[i] = -x_[i];
    }
    for (int k = 0; k < m_.stations; ++k) {
      const Single s = single(x_, k);
      const T per_g = T(1.0) / s.gravity, turn = (zero - s.vertical) * per_g;
      const survey::Vec3<T> lift = scale(per_g * s.level, s.n);
      const std::array<T, 6> rows[3] = {
          {s.d.x, s.d.y, s.d.z, zero, zero, zero},
          {turn * s.n.x, turn * s.n.y, turn * s.n.z, -s.n.x, -s.n.y, -s.n.z},
          {lift.x, lift.y, lift.z, -s.d.x, -s.d.y, -s.d.z},
      };
      const std::array<T, 3> r = residuals(s);
#pragma GCC unroll 1
      for (std::size_t q = 0; q < 3; ++q) {
        std::array<T, 6> j;
#pragma GCC unroll 1
        for (std::size_t i = 0; i < 6; ++i) j[i] = rows[q][i] * T(m_.per_sd[q] * m_.offset_sd[i]);
#pragma GCC unroll 1
        for (std::size_t i = 0; i < 6; ++i) {
          g[i] = fma(-j[i], r[q], g[i]);
#pragma GCC unroll 1
          for (std::size_t l = 0; l <= i; ++l) a[packed(i, l)] = fma(j[i], j[l], a[packed(i, l)]);
        }
      }
    }
    const Symmetric<T, 6> factor = ldlt<T, 6>(a);
    const std::array<T, 6> step = ldlt_solve<T, 6>(factor, g);
    T size2 = zero, along = zero;
#pragma GCC unroll 1
    for (std::size_t i = 0; i < 6; ++i) {
      size2 = fma(step[i], step[i], size2);
      along = fma(g[i], step[i], along);
      next_[i] = x_[i] + step[i];
    }
    return {all_positive<T, 6>(factor), fma(damping, size2, along), size2};
  }
  T try_step() const { return cost_at(next_); }
  void take(const Mask& where) {
#pragma GCC unroll 1
    for (std::size_t i = 0; i < 6; ++i) x_[i] = select(where, next_[i], x_[i]);
  }
  T rounding(const T& cost) const { return T(1e-12) * (T(1.0) + cost); }

 private:
  struct Single {
    survey::Vec3<T> d, n;
    T gravity, level, vertical;
  };
  Single single(const std::array<T, 6>& x, int k) const {
    const double* y = m_.readings + 6 * static_cast<std::size_t>(k);
    std::array<T, 6> r;
#pragma GCC unroll 1
    for (std::size_t i = 0; i < 6; ++i) r[i] = fma(T(-m_.offset_sd[i]), x[i], T(y[i]));
    const survey::Vec3<T> f{r[0], r[1], r[2]}, h{r[3], r[4], r[5]};
    Single s;
    s.gravity = norm(f);
    s.d = scale(T(-1.0) / s.gravity, f);
    s.vertical = dot(s.d, h);
    const survey::Vec3<T> level = h - scale(s.vertical, s.d);
    s.level = norm(level);
    s.n = scale(T(1.0) / s.level, level);
    return s;
  }
  std::array<T, 3> residuals(const Single& s) const {
    return {(s.gravity - T(m_.gravity)) * T(m_.per_sd[0]), (s.level - T(m_.horizontal)) * T(m_.per_sd[1]),
            (s.vertical - T(m_.down)) * T(m_.per_sd[2])};
  }
  T cost_at(const std::array<T, 6>& x) const {
    T sum(0.0);
    for (const T& b : x) sum = fma(b, b, sum);
    for (int k = 0; k < m_.stations; ++k)
      for (const T& r : residuals(single(x, k))) sum = fma(r, r, sum);
    return sum;
  }

  const OffsetModel& m_;
  std::array<T, 6> x_, next_;
};

}  // namespace surveymc::chained
