#pragma once
/// Gauss-Newton and Newton for MSA, on lanes of trials. Readable model: msa_residual.h.
///
///   b = p m - q,  Bv = u.b,  e = (u x b) / Bh,  Bh = |u x b|,  n = (b - Bv u) / Bh
/// with u, n, e an orthonormal base: down, north, east.
///   dBh/dp_i = n_i m_i,  dBh/dq_i = -n_i,  dBv/dp_i = u_i m_i,  dBv/dq_i = -u_i
/// so that with W = n n' + u u' = 1 - e e' and g = (Bh - Bh_ref) n + (Bv - Bv_ref) u the normal equations of one
/// station are  [ W_ij m_i m_j   -W_ij m_i ]          [ g_i m_i ]
///      [     .            W_ij    ]  dx = -  [  -g_i   ].
/// Only Bh is curved: d2Bh/db2 = e e' / Bh. With kappa = 1 - (Bh - Bh_ref) / Bh the exact second derivative of the cost
/// is the same matrix with W = 1 - kappa e e': Newton costs no more than Gauss-Newton, and the sums that do not depend
/// on e are made once for all iterations.
/// Fields are in units of `total`, so that all six unknowns and their columns are of order one.
#include <array>

#include "estimate/newton.h"
#include "survey/frames.h"

namespace surveymc::estimate {

using namespace simd;

/// Pointers to one group of a ReadingBlock, or to one of its lanes. ReadingBlock names the rows, which are kGroup
/// apart.
struct MsaData {
  const double *magnetic, *down, *reference;
  int stations, reference_stride;
  double per_total;  ///< 1 / total field, 1/nT
};

/// Unknowns p, q / total; the cost in units of total^2.
template <class T>
using MsaNormalEquations = NormalEquations<T, 6>;
template <class T>
using MsaSolution = NewtonSolution<T, 6>;

/// Sums over the stations of m_i and m_i^2, in nT: the part of the matrix that no iteration changes.
template <class T>
struct MsaReadingSums {
  std::array<T, 3> m, mm;
};
template <class T>
MsaReadingSums<T> msa_reading_sums(const MsaData& d) {
  MsaReadingSums<T> s;
  for (std::size_t i = 0; i < 3; ++i) s.m[i] = s.mm[i] = T(0.0);
  for (int k = 0; k < d.stations; ++k)
    for (std::size_t i = 0; i < 3; ++i) {
      const T m = load<T>(d.magnetic + (3 * static_cast<std::size_t>(k) + i) * kGroup);
      s.m[i] = s.m[i] + m;
      s.mm[i] = fma(m, m, s.mm[i]);
    }
  return s;
}

/// Normal equations at x = (p, q / total). `second_order`: 0 for the Gauss-Newton matrix J'J, 1 for Newton's. Without
/// `WithMatrix` only gradient and cost, with the same bits, for less than half the work.
template <class T, bool WithMatrix = true>
MsaNormalEquations<T> msa_normal_equations(const MsaData& d, const MsaReadingSums<T>& sums, const std::array<T, 6>& x,
                                           const T& second_order) {
  MsaNormalEquations<T> out;
  for (T& a : out.matrix) a = T(0.0);
  for (T& a : out.gradient) a = T(0.0);
  out.cost = T(0.0);
  const T per_total(d.per_total), minus_per_total(-d.per_total);
  // Readings stay in nT; the scale goes to the unknowns here and to the sums at the end.
  const std::array<T, 3> p{x[0] * per_total, x[1] * per_total, x[2] * per_total}, q{x[3], x[4], x[5]};
  const double *magnetic = d.magnetic, *down = d.down, *reference = d.reference;
  for (int k = 0; k < d.stations; ++k) {
    std::array<T, 3> m, u, b, g;
    for (std::size_t i = 0; i < 3; ++i) {
      m[i] = load<T>(magnetic + i * kGroup);
      u[i] = load<T>(down + i * kGroup);
      b[i] = fms(p[i], m[i], q[i]);
    }
    const T bv = fma(u[0], b[0], fma(u[1], b[1], u[2] * b[2]));
    std::array<T, 3> e{fms(u[1], b[2], u[2] * b[1]), fms(u[2], b[0], u[0] * b[2]), fms(u[0], b[1], u[1] * b[0])};
    const T bh2 = fma(e[0], e[0], fma(e[1], e[1], e[2] * e[2]));
    const T bh = sqrt(bh2), per_bh = bh * (T(1.0) / bh2);  // root and quotient need not wait for each other
    const T rh = fma(load<T>(reference), minus_per_total, bh),
            rv = fma(load<T>(reference + kGroup), minus_per_total, bv);
    out.cost = fma(rh, rh, fma(rv, rv, out.cost));
    const T along_b = rh * per_bh, along_u = fma(-along_b, bv, rv);
    for (std::size_t i = 0; i < 3; ++i) {
      g[i] = fma(along_b, b[i], along_u * u[i]);
      out.gradient[i] = fma(g[i], m[i], out.gradient[i]);
      out.gradient[3 + i] = out.gradient[3 + i] - g[i];
    }
    if constexpr (WithMatrix) {
      const T kappa = fma(-second_order, along_b, T(1.0));
      std::array<T, 3> ke, em, kem;  // kappa e, e m, kappa e m
      for (std::size_t i = 0; i < 3; ++i) {
        e[i] = e[i] * per_bh;
        ke[i] = kappa * e[i];
        em[i] = e[i] * m[i];
        kem[i] = ke[i] * m[i];
      }
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          out.matrix[packed(i, j)] = fma(kem[i], em[j], out.matrix[packed(i, j)]);
          out.matrix[packed(3 + i, 3 + j)] = fma(ke[i], e[j], out.matrix[packed(3 + i, 3 + j)]);
        }
        for (std::size_t j = 0; j < 3; ++j)  // d/dq_i d/dp_j
          out.matrix[packed(3 + i, j)] = fma(ke[i], em[j], out.matrix[packed(3 + i, j)]);
      }
    }
    magnetic += 3 * kGroup;
    down += 3 * kGroup;
    reference += d.reference_stride * kGroup;
  }
  for (std::size_t i = 0; i < 3; ++i) out.gradient[i] = out.gradient[i] * per_total;
  if constexpr (WithMatrix) {  // so far the sums of kappa e e' only
    const T stations(static_cast<double>(d.stations)), per_total2(d.per_total * d.per_total);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        T &pp = out.matrix[packed(i, j)], &qq = out.matrix[packed(3 + i, 3 + j)];
        pp = ((i == j ? sums.mm[i] : T(0.0)) - pp) * per_total2;
        qq = (i == j ? stations : T(0.0)) - qq;
      }
      for (std::size_t j = 0; j < 3; ++j) {
        T& qp = out.matrix[packed(3 + i, j)];
        qp = (qp - (i == j ? sums.m[i] : T(0.0))) * per_total;
      }
    }
  }
  return out;
}

template <class T>
struct MsaEquations {
  const MsaData& data;
  MsaReadingSums<T> sums;
  template <bool WithMatrix>
  MsaNormalEquations<T> operator()(const std::array<T, 6>& x, const T& second_order) const {
    return msa_normal_equations<T, WithMatrix>(data, sums, x, second_order);
  }
};

/// From `start` to the minimum (newton.h).
template <class T>
MsaSolution<T> msa_solve_from(const std::array<T, 6>& start, const MsaData& data, const NewtonOptions& options) {
  const T zero(0.0), one(1.0);
  MsaSolution<T> s = newton_minimum<T, 6>(MsaEquations<T>{data, msa_reading_sums<T>(data)}, start, options);
  s.converged = select((zero < s.converged) & are_sound(s.x), one, zero);
  return s;
}

/// From unit gains and zero biases.
template <class T>
MsaSolution<T> msa_solve(const MsaData& data, const NewtonOptions& options) {
  const T zero(0.0), one(1.0);
  return msa_solve_from<T>({one, one, one, zero, zero, zero}, data, options);
}

}  // namespace surveymc::estimate
