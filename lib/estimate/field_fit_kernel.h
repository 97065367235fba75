#pragma once
/// Normal equations of field_fit.h, on lanes of trials.
///
///   b = p m - q,  Bv = u.b,  e = (u x b) / Bh,  Bh = |u x b|,  n = (b - Bv u) / Bh: u, n, e are down, north, east.
///   d(Bh, Bv)/dp_i = a_i m_i,  d(Bh, Bv)/dq_i = -a_i,  a_i = (n_i, u_i)
///   d(Bh', Bv')/dz0 = (Bh', Bv') sd_total / (B stretch),  d(Bh', Bv')/dz1 = (-Bv', Bh') sd_dip
/// With M_ij = a_i' W a_j, f = W r, g_i = a_i' f and c_l the columns of -d(Bh', Bv')/dz_l, one station gives
///       [ M_ij m_i m_j   -M_ij m_i    a_i'W c_l m_i ]        [  g_i m_i ]
///       [      .            M_ij     -a_i'W c_l     ]  dx = -[ -g_i     ]
///       [      .             .         c_l'W c_m    ]        [  c_l' f  ]
/// Bh is curved, d2Bh/db2 = e e' / Bh, which adds f_h / Bh e_i e_j to M_ij for the exact second derivative. The
/// reference is curved, too, which adds to the lower right block.
///
/// The right side above has the *measured* reading m_i in the derivative by a gain. The noise of m_i is in r too, so
/// that the expectation of g_i m_i at the truth is not zero (errors in variables). The derivative at the *fitted* field
///   b' = Bh' n + Bv' u,   m'_i = (b'_i + q_i) / p_i = m_i - s_i / p_i,   s = b - b' = r_h n + r_v u
/// subtracts C_i / p_i from the equation of p_i, C_i = sum_k g_i s_i. With K_ij = delta_ij - (1 - r_h / Bh) e_i e_j,
///   dC_i/db_j = M_ij s_i + K_ij g_i,   dC_i/dz_l = (a_i'W c_l) s_i + (a_i'c_l) g_i   (M with the second derivative).
#include "estimate/field_fit.h"
#include "estimate/newton.h"

namespace surveymc::estimate {

using namespace simd;

/// Pointers to one group of a ReadingBlock, or to one of its lanes. ReadingBlock names the rows, which are kGroup
/// apart.
struct FieldFitData {
  const double *magnetic, *down, *reference;
  int stations, reference_stride;
};

/// The terms that the derivative at the fitted field subtracts from the equations of p, and from the rows of their
/// matrix.
template <class T, std::size_t N>
struct FittedCorrection {
  std::array<T, 3> value;
  std::array<std::array<T, N>, 3> derivative;  ///< set with the matrix
};

/// N = 6: unknowns p, q / total. N = 8: z too. `correction` is written if Fitted.
template <class T, std::size_t N, bool WithMatrix, bool Fitted = false>
NormalEquations<T, N> field_fit_equations(const FieldFitModel& model, const FieldFitData& d, const std::array<T, N>& x,
                                          const T& second_order, FittedCorrection<T, N>* correction = nullptr) {
  constexpr bool joint = N == 8;
  static_assert(N == 6 || joint);
  NormalEquations<T, N> out;
  for (T& a : out.matrix) a = T(0.0);
  for (T& a : out.gradient) a = T(0.0);
  out.cost = T(0.0);
  if constexpr (Fitted) {
    for (T& c : correction->value) c = T(0.0);
    for (auto& row : correction->derivative)
      for (T& c : row) c = T(0.0);
  }
  const T per_total(1 / model.total), w_hh(model.w_hh), w_hv(model.w_hv), w_vv(model.w_vv), dip_sd(model.dip_sd);
  T sine(0.0), cosine(1.0), stretch(1.0), stretch_sd(0.0);
  if constexpr (joint) {
    const T bh = load<T>(d.reference), bv = load<T>(d.reference + kGroup);
    stretch_sd = T(model.total_sd * model.total) / sqrt(fma(bh, bh, bv * bv));
    stretch = fma(x[6], stretch_sd, T(1.0));
    const auto [s, c] = sincos(x[7] * dip_sd);
    sine = s * stretch;
    cosine = c * stretch;
  }
  const T relative_stretch_sd = stretch_sd / stretch;
  const double *magnetic = d.magnetic, *down = d.down, *reference = d.reference;
  for (int k = 0; k < d.stations; ++k) {
    std::array<T, 3> m, u, b, n, g;
    for (std::size_t i = 0; i < 3; ++i) {
      m[i] = load<T>(magnetic + i * kGroup) * per_total;
      u[i] = load<T>(down + i * kGroup);
      b[i] = fms(x[i], m[i], x[3 + i]);
    }
    const T bv = fma(u[0], b[0], fma(u[1], b[1], u[2] * b[2]));
    std::array<T, 3> e{fms(u[1], b[2], u[2] * b[1]), fms(u[2], b[0], u[0] * b[2]), fms(u[0], b[1], u[1] * b[0])};
    const T bh2 = fma(e[0], e[0], fma(e[1], e[1], e[2] * e[2]));
    const T bh = sqrt(bh2), per_bh = bh * (T(1.0) / bh2);
    T h_ref = load<T>(reference) * per_total, v_ref = load<T>(reference + kGroup) * per_total;
    if constexpr (joint) {
      const T h = h_ref;
      h_ref = fms(cosine, h, sine * v_ref);
      v_ref = fma(sine, h, cosine * v_ref);
    }
    const T rh = bh - h_ref, rv = bv - v_ref;
    const T fh = fma(w_hh, rh, w_hv * rv), fv = fma(w_hv, rh, w_vv * rv);
    out.cost = fma(fh, rh, fma(fv, rv, out.cost));
    for (std::size_t i = 0; i < 3; ++i) {
      n[i] = fma(-bv, u[i], b[i]) * per_bh;
      g[i] = fma(fh, n[i], fv * u[i]);
      out.gradient[i] = fma(g[i], m[i], out.gradient[i]);
      out.gradient[3 + i] = out.gradient[3 + i] - g[i];
    }
    std::array<T, 3> s;  // corrected less fitted field
    if constexpr (Fitted)
      for (std::size_t i = 0; i < 3; ++i) {
        s[i] = fma(rh, n[i], rv * u[i]);
        correction->value[i] = fma(g[i], s[i], correction->value[i]);
      }
    std::array<T, 2> ch, cv;  // columns of z
    if constexpr (joint) {
      ch = {-h_ref * relative_stretch_sd, v_ref * dip_sd};
      cv = {-v_ref * relative_stretch_sd, -h_ref * dip_sd};
      for (std::size_t l = 0; l < 2; ++l) out.gradient[6 + l] = fma(ch[l], fh, fma(cv[l], fv, out.gradient[6 + l]));
    }
    if constexpr (WithMatrix) {
      const T curvature = second_order * fh * per_bh;
      std::array<T, 3> wh, wv, ce;  // W a_i, curvature e_i
      for (std::size_t i = 0; i < 3; ++i) {
        e[i] = e[i] * per_bh;
        ce[i] = curvature * e[i];
        wh[i] = fma(w_hh, n[i], w_hv * u[i]);
        wv[i] = fma(w_hv, n[i], w_vv * u[i]);
      }
      Symmetric<T, 3> a;  // M_ij
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j <= i; ++j) a[packed(i, j)] = fma(wh[i], n[j], fma(wv[i], u[j], ce[i] * e[j]));
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          const T& aij = a[i >= j ? packed(i, j) : packed(j, i)];
          const T am = aij * m[j];
          if (j <= i) {
            out.matrix[packed(i, j)] = fma(am, m[i], out.matrix[packed(i, j)]);
            out.matrix[packed(3 + i, 3 + j)] = out.matrix[packed(3 + i, 3 + j)] + aij;
          }
          out.matrix[packed(3 + i, j)] = out.matrix[packed(3 + i, j)] - am;
        }
      if constexpr (Fitted) {
        const T bent = T(1.0) - rh * per_bh;
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 3; ++j) {
            const T kij = fma(-bent * e[i], e[j], T(i == j ? 1.0 : 0.0));
            const T by_b = fma(a[i >= j ? packed(i, j) : packed(j, i)], s[i], kij * g[i]);
            T &by_p = correction->derivative[i][j], &by_q = correction->derivative[i][3 + j];
            by_p = fma(by_b, m[j], by_p);
            by_q = by_q - by_b;
          }
      }
      if constexpr (joint) {
        for (std::size_t l = 0; l < 2; ++l)
          for (std::size_t i = 0; i < 3; ++i) {
            const T awc = fma(wh[i], ch[l], wv[i] * cv[l]);
            out.matrix[packed(6 + l, i)] = fma(awc, m[i], out.matrix[packed(6 + l, i)]);
            out.matrix[packed(6 + l, 3 + i)] = out.matrix[packed(6 + l, 3 + i)] - awc;
            if constexpr (Fitted) {
              T& by_z = correction->derivative[i][6 + l];
              by_z = fma(awc, s[i], fma(fma(n[i], ch[l], u[i] * cv[l]), g[i], by_z));
            }
          }
        for (std::size_t l = 0; l < 2; ++l)
          for (std::size_t r = 0; r <= l; ++r) {
            const T first = fma(ch[l], fma(w_hh, ch[r], w_hv * cv[r]), cv[l] * fma(w_hv, ch[r], w_vv * cv[r]));
            out.matrix[packed(6 + l, 6 + r)] = out.matrix[packed(6 + l, 6 + r)] + first;
          }
        const T along = second_order * fma(fh, h_ref, fv * v_ref), across = second_order * fms(fh, v_ref, fv * h_ref);
        out.matrix[packed(7, 6)] = fma(across, relative_stretch_sd * dip_sd, out.matrix[packed(7, 6)]);
        out.matrix[packed(7, 7)] = fma(along, dip_sd * dip_sd, out.matrix[packed(7, 7)]);
      }
    }
    magnetic += 3 * kGroup;
    down += 3 * kGroup;
    reference += d.reference_stride * kGroup;
  }
  const auto add_prior = [&](std::size_t i, const T& from_centre, double weight) {
    const T w(weight);
    out.cost = fma(w * from_centre, from_centre, out.cost);
    out.gradient[i] = fma(w, from_centre, out.gradient[i]);
    if constexpr (WithMatrix) out.matrix[packed(i, i)] = out.matrix[packed(i, i)] + w;
  };
  for (std::size_t i = 0; i < 3; ++i) {
    add_prior(i, x[i] - T(1.0), model.gain_prior);
    add_prior(3 + i, x[3 + i], model.bias_prior[i]);
  }
  if constexpr (joint) {
    add_prior(6, x[6], model.unit_weight);
    add_prior(7, x[7], model.unit_weight);
  }
  for (std::size_t i = 0; i < 6; ++i)  // a parameter that is not estimated has a step of zero and moves no other
    if (!model.estimated[i]) {
      out.gradient[i] = T(0.0);
      if constexpr (WithMatrix)
        for (std::size_t j = 0; j < N; ++j) out.matrix[i > j ? packed(i, j) : packed(j, i)] = T(i == j ? 1.0 : 0.0);
    }
  if constexpr (Fitted)
    for (std::size_t i = 0; i < 3; ++i) {
      const T weight = T(model.estimated[i] ? 1.0 : 0.0) / x[i];
      T& c = correction->value[i];
      c = c * weight;
      for (std::size_t j = 0; j < N; ++j) {
        T& by = correction->derivative[i][j];
        by = j < 6 && !model.estimated[j] ? T(0.0) : by * weight;
      }
      correction->derivative[i][i] = fma(-c, weight, correction->derivative[i][i]);
    }
  return out;
}

/// The equations of the derivative at the fitted field, with their exact derivative. They are no gradient, so the
/// matrix is not symmetric.
template <class T, std::size_t N, bool WithMatrix>
RootEquations<T, N> fitted_field_equations(const FieldFitModel& model, const FieldFitData& d,
                                           const std::array<T, N>& x) {
  FittedCorrection<T, N> correction;
  const NormalEquations<T, N> e = field_fit_equations<T, N, WithMatrix, true>(model, d, x, T(1.0), &correction);
  RootEquations<T, N> out;
  out.value = e.gradient;
  out.cost = e.cost;
  if constexpr (WithMatrix)
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j) out.matrix[i * N + j] = e.matrix[i >= j ? packed(i, j) : packed(j, i)];
  for (std::size_t i = 0; i < 3; ++i) {
    out.value[i] = out.value[i] - correction.value[i];
    if constexpr (WithMatrix)
      for (std::size_t j = 0; j < N; ++j) out.matrix[i * N + j] = out.matrix[i * N + j] - correction.derivative[i][j];
  }
  return out;
}

template <class T, std::size_t N>
struct FieldFitEquations {
  const FieldFitModel& model;
  const FieldFitData& data;
  template <bool WithMatrix>
  NormalEquations<T, N> operator()(const std::array<T, N>& x, const T& second_order) const {
    return field_fit_equations<T, N, WithMatrix>(model, data, x, second_order);
  }
};

template <class T, std::size_t N>
struct FittedFieldEquations {
  const FieldFitModel& model;
  const FieldFitData& data;
  template <bool WithMatrix>
  RootEquations<T, N> operator()(const std::array<T, N>& x) const {
    return fitted_field_equations<T, N, WithMatrix>(model, data, x);
  }
};

/// The minimum; from there, if asked for, the root of the equations with the derivative at the fitted field. The
/// minimum is then only a start, a few tenths of a standard deviation from the root, and need not be accurate.
template <class T, std::size_t N>
NewtonSolution<T, N> field_fit_solution(const FieldFitModel& model, const FieldFitData& data,
                                        const std::array<T, N>& start, const NewtonOptions& options) {
  constexpr double kNear = 1e-3;
  if (!model.fitted_derivative) return newton_minimum<T, N>(FieldFitEquations<T, N>{model, data}, start, options);
  NewtonOptions rough = options;
  rough.step_tolerance = rough.step_tolerance < kNear ? kNear : rough.step_tolerance;
  const NewtonSolution<T, N> near = newton_minimum<T, N>(FieldFitEquations<T, N>{model, data}, start, rough);
  NewtonSolution<T, N> s = newton_root<T, N>(FittedFieldEquations<T, N>{model, data}, near.x, options);
  s.iterations = s.iterations + near.iterations;
  s.converged = s.converged * near.converged;
  return s;
}

}  // namespace surveymc::estimate
