#pragma once
/// Smoother and filter over all stations of the trials in the lanes, from the basic solution to convergence. Lanes
/// never wait for each other: what has converged is frozen, so a trial's bits do not depend on its neighbours.
#include "chained/chain_kernel.h"

namespace surveymc::chained {

using namespace simd;

/// What the smoother keeps of a station from the way forwards. Little, as long runs have to fit the caches: terms are
/// made again on the way back.
template <class T>
struct StationMemory {
  StationPoint<T> at;                     ///< the point
  std::array<T, kChainStates> predicted;  ///< mean before the update
  ChainCovariance<T> covariance;          ///< before the update
  Update<T> update;
};

/// (delta, c), lower triangle.
template <class T>
using StationCovariance = Symmetric<T, 12>;

template <class T>
struct Outcome {
  T converged, iterations, cost;  ///< converged: 1 or 0
};

template <class T>
std::array<T, 6> load_reading(const double* readings, int station) {
  std::array<T, 6> y;
  for (std::size_t i = 0; i < 6; ++i) y[i] = load<T>(readings + (6 * static_cast<std::size_t>(station) + i) * kGroup);
  return y;
}

template <class Mask, class T>
ToolFrame<T> chosen(const Mask& first, const ToolFrame<T>& a, const ToolFrame<T>& b) {
  const auto vector = [&](const survey::Vec3<T>& u, const survey::Vec3<T>& v) -> survey::Vec3<T> {
    return {select(first, u.x, v.x), select(first, u.y, v.y), select(first, u.z, v.z)};
  };
  return {vector(a.n, b.n), vector(a.d, b.d)};
}

/// As basic_station() of basic_solution.h.
template <class T>
ToolFrame<T> basic_frame_of(const std::array<T, 6>& y) {
  const T zero(0.0);
  return orthonormal(ToolFrame<T>{{y[3], y[4], y[5]}, {zero - y[0], zero - y[1], zero - y[2]}});
}

/// Squared size of a step of one station as in linearised_station.h.
template <class T>
T step_size2(const KernelModel& m, const survey::Vec3<T>& delta, const std::array<T, kChainStates>& dc) {
  T sum = T(1e6) * dot(delta, delta);
  for (std::size_t i = 0; i < kChainStates; ++i) sum = fma(dc[i] * dc[i], T(1 / m.prior_variance[i]), sum);
  return sum;
}

/// Joint covariance from that of the chain: delta = (by the readings) + L dc.
template <class T>
StationCovariance<T> joint_covariance(const KernelModel& m, const StationTerms<T>& t, const ToolFrame<T>& frame,
                                      const ChainCovariance<T>& p) {
  const StationAttitude<T> attitude = station_attitude(m, t);
  std::array<std::array<T, 3>, kChainStates> by_chain;  // L'
  const std::array<T, 6> no_residual{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  for (std::size_t i = 0; i < kChainStates; ++i) {
    std::array<T, kChainStates> unit;
    for (std::size_t j = 0; j < kChainStates; ++j) unit[j] = T(i == j ? 1.0 : 0.0);
    by_chain[i] = ldlt_solve<T, 3>(attitude.factor, attitude.right_side(m, t, frame, no_residual, unit));
  }
  StationCovariance<T> c;
  std::array<std::array<T, 3>, kChainStates> cross;  // P L'
  for (std::size_t i = 0; i < kChainStates; ++i)
    for (std::size_t r = 0; r < 3; ++r) {
      T s(0.0);
      for (std::size_t j = 0; j < kChainStates; ++j)
        s = fma(p[j <= i ? packed(i, j) : packed(j, i)], by_chain[j][r], s);
      cross[i][r] = s;
      c[packed(3 + i, r)] = s;
    }
  for (std::size_t i = 0; i < kChainStates; ++i)
    for (std::size_t j = 0; j <= i; ++j) c[packed(3 + i, 3 + j)] = p[packed(i, j)];
  for (std::size_t r = 0; r < 3; ++r) {
    std::array<T, 3> unit{T(0.0), T(0.0), T(0.0)};
    unit[r] = T(1.0);
    const auto column = ldlt_solve<T, 3>(attitude.factor, unit);
    for (std::size_t q = 0; q <= r; ++q) {
      T s = column[q];
      for (std::size_t i = 0; i < kChainStates; ++i) s = fma(cross[i][r], by_chain[i][q], s);
      c[packed(r, q)] = s;
    }
  }
  return c;
}

/// Forwards over all stations, linearised at their points.
template <class T>
void forward_pass(const KernelModel& m, const double* readings, StationMemory<T>* stations) {
  std::array<T, kChainStates> mean;
  ChainCovariance<T> p;
  begin_chain(m, mean, p);
  for (int k = 0; k < m.stations; ++k) {
    StationMemory<T>& s = stations[k];
    s.predicted = mean;
    s.covariance = p;
    s.update = update_chain(station_terms(m, load_reading<T>(readings, k), s.at), s.at.c, mean, p);
    predict_chain(m, mean, p);
  }
}

/// Backwards: calls use(k, terms, smoothed state, covariance) from the last station to the first.
template <class T, bool WithCovariance, class Use>
void backward_pass(const KernelModel& m, const double* readings, const StationMemory<T>* stations, const Use& use) {
  std::array<T, kChainStates> l;
  ChainCovariance<T> big;
  for (T& x : l) x = T(0.0);
  for (T& x : big) x = T(0.0);
  for (int k = m.stations - 1; k >= 0; --k) {
    const StationMemory<T>& s = stations[k];
    const StationTerms<T> terms = station_terms(m, load_reading<T>(readings, k), s.at);
    smooth_back<T, WithCovariance>(terms.rows, s.update, l, big);
    std::array<T, kChainStates> c = s.predicted;
    for (std::size_t i = 0; i < kChainStates; ++i)
      for (std::size_t j = 0; j < kChainStates; ++j)
        c[i] = fma(-s.covariance[j <= i ? packed(i, j) : packed(j, i)], l[j], c[i]);
    ChainCovariance<T> smoothed = s.covariance;  // P - P L P
    if constexpr (WithCovariance)
      for (std::size_t i = 0; i < kChainStates; ++i) {
        std::array<T, kChainStates> pl;  // row i of P L
        for (std::size_t j = 0; j < kChainStates; ++j) {
          T sum(0.0);
          for (std::size_t r = 0; r < kChainStates; ++r)
            sum =
                fma(s.covariance[r <= i ? packed(i, r) : packed(r, i)], big[j <= r ? packed(r, j) : packed(j, r)], sum);
          pl[j] = sum;
        }
        for (std::size_t j = 0; j <= i; ++j)
          for (std::size_t r = 0; r < kChainStates; ++r)
            smoothed[packed(i, j)] =
                fma(-pl[r], s.covariance[r <= j ? packed(j, r) : packed(r, j)], smoothed[packed(i, j)]);
      }
    use(k, terms, c, smoothed);
    if (!m.independent) continue;
    for (std::size_t i = 0; i < kChainStates; ++i) {
      if (i < kReferenceStates) l[i] = T(0.0);
      for (std::size_t j = 0; j <= i && j < kReferenceStates; ++j) big[packed(i, j)] = T(0.0);
    }
  }
}

/// J at the stations' points, as chain_cost() of linearised_station.h.
template <class T>
T chain_cost(const KernelModel& m, const double* readings, const StationMemory<T>* stations) {
  T sum(0.0);
  const T zero(0.0);
  for (int k = 0; k < m.stations; ++k) {
    const StationPoint<T>& at = stations[k].at;
    const auto e = reading_residual<T>(m.gravity, m.horizontal, m.down, load_reading<T>(readings, k), at.frame, at.c,
                                       {zero, zero, zero});
    for (std::size_t i = 0; i < 6; ++i) sum = fma(e[i] * e[i], T(1 / m.noise_variance[i]), sum);
    for (std::size_t i = 0; i < kChainStates; ++i) {
      const bool alone = k == 0 || (m.independent && i < kReferenceStates);
      const T change = alone ? at.c[i] : at.c[i] - stations[k - 1].at.c[i];
      sum = fma(change * change, T(1 / (k == 0 ? m.prior_variance[i] : m.link_variance[i])), sum);
    }
  }
  return sum;
}

/// All stations together. `stations`: scratch of m.stations; calls store_station(k, station, covariance) for each of
/// them at the end, whether converged or not.
template <class T, class Store>
Outcome<T> smooth_lanes(const KernelModel& m, const double* readings, StationMemory<T>* stations,
                        const Store& store_station) {
  for (int k = 0; k < m.stations; ++k) {
    stations[k].at.frame = basic_frame_of(load_reading<T>(readings, k));
    for (T& x : stations[k].at.c) x = T(0.0);
  }
  const T zero(0.0), one(1.0), tolerance2(m.step_tolerance * m.step_tolerance * m.stations);
  auto active = zero < one;
  Outcome<T> out{zero, zero, zero};
  for (int it = 0; it < m.max_iterations && any(active); ++it) {
    forward_pass(m, readings, stations);
    T size2(0.0);
    backward_pass<T, false>(
        m, readings, stations,
        [&](int k, const StationTerms<T>& terms, const std::array<T, kChainStates>& c, const ChainCovariance<T>&) {
          StationMemory<T>& s = stations[k];
          std::array<T, kChainStates> dc;
          for (std::size_t i = 0; i < kChainStates; ++i) dc[i] = c[i] - s.at.c[i];
          const StationAttitude<T> attitude = station_attitude(m, terms);
          const auto x =
              ldlt_solve<T, 3>(attitude.factor, attitude.right_side(m, terms, s.at.frame, terms.residual, dc));
          const survey::Vec3<T> delta{x[0], x[1], x[2]};
          size2 = size2 + step_size2(m, delta, dc);
          const ToolFrame<T> next = turned(delta, s.at.frame);
          s.at.frame = chosen(active, next, s.at.frame);
          for (std::size_t i = 0; i < kChainStates; ++i) s.at.c[i] = select(active, c[i], s.at.c[i]);
        });
    out.iterations = out.iterations + select(active, one, zero);
    const auto done = active & (size2 <= tolerance2);
    out.converged = select(done, one, out.converged);
    active = active & !done & (size2 < T(1e12));  // NaN fails it: no way back
  }
  forward_pass(m, readings, stations);
  out.cost = chain_cost(m, readings, stations);
  backward_pass<T, true>(
      m, readings, stations,
      [&](int k, const StationTerms<T>& terms, const std::array<T, kChainStates>&, const ChainCovariance<T>& p) {
        const StationMemory<T>& s = stations[k];
        store_station(k, s.at, joint_covariance(m, terms, s.at.frame, p));
      });
  return out;
}

/// Station by station as while drilling: run_filter() of smoother.h.
template <class T, class Store>
Outcome<T> filter_lanes(const KernelModel& m, const double* readings, const Store& store_station) {
  const T zero(0.0), one(1.0), tolerance2(m.step_tolerance * m.step_tolerance);
  Outcome<T> out{one, zero, zero};
  std::array<T, kChainStates> mean;
  ChainCovariance<T> p;
  begin_chain(m, mean, p);
  for (int k = 0; k < m.stations; ++k) {
    const auto y = load_reading<T>(readings, k);
    StationPoint<T> at{basic_frame_of(y), mean};
    auto active = zero < one;
    auto converged = one < zero;
    T iterations(0.0);
    for (int it = 0; it < m.max_iterations && any(active); ++it) {
      const StationTerms<T> terms = station_terms(m, y, at);
      auto c = mean;
      auto after = p;
      update_chain(terms, at.c, c, after);
      std::array<T, kChainStates> dc;
      for (std::size_t i = 0; i < kChainStates; ++i) dc[i] = c[i] - at.c[i];
      const StationAttitude<T> attitude = station_attitude(m, terms);
      const auto x = ldlt_solve<T, 3>(attitude.factor, attitude.right_side(m, terms, at.frame, terms.residual, dc));
      const survey::Vec3<T> delta{x[0], x[1], x[2]};
      const T size2 = step_size2(m, delta, dc);
      const ToolFrame<T> next = turned(delta, at.frame);
      at.frame = chosen(active, next, at.frame);
      for (std::size_t i = 0; i < kChainStates; ++i) at.c[i] = select(active, c[i], at.c[i]);
      iterations = iterations + select(active, one, zero);
      converged = converged | (active & (size2 <= tolerance2));
      active = active & !converged & (size2 < T(1e12));
    }
    out.iterations = max(out.iterations, iterations);
    out.converged = select(converged, out.converged, zero);
    const StationTerms<T> terms = station_terms(m, y, at);
    const Update<T> update = update_chain(terms, at.c, mean, p);
    out.cost = out.cost + update.minimum;
    store_station(k, at, joint_covariance(m, terms, at.frame, p));
    predict_chain(m, mean, p);
  }
  return out;
}

}  // namespace surveymc::chained
