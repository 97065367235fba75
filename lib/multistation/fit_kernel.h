#pragma once
/// Gauss-Newton for any parameters of the table, on lanes of trials. Readable model: model.h.
///
/// Unknowns come in kinds of three, and so does the normal matrix: blocks of 3 x 3 for each pair of kinds that is
/// estimated, unrolled, so that one kernel serves all sets. A parameter of such a kind that is not in the set keeps a
/// row of the identity and does not move. The rows of a station follow from its residuals' gradients by the corrected
/// readings, pulled back through the triads: n = -A^-T dr/dg or -M^-T dr/db; then, with v = g or b,
///   bias n,  scale n_i v_i,  rotation v x n,  skew n_a v_b + n_b v_a.
#include <array>
#include <cstddef>

#include "multistation/model.h"
#include "simd/lanes.h"
#include "simd/solve.h"

namespace surveymc::multistation {

using namespace simd;

/// Unknowns: the parameters of the table, then errors of the reference: gravity (m/s2), total field (nT), dip (rad).
inline constexpr int kReferenceKind = kParameters, kUnknowns = kParameters + 3, kUnknownKinds = kKinds + 1;

/// What does not change from trial to trial.
struct FitPlan {
  ResidualKind residuals = ResidualKind::survey;
  std::array<int, kUnknownKinds> kinds{};  ///< first unknown of each kind that is estimated, rising
  int kind_count = 0;
  bool corrects_accelerometers = false;
  bool gravity_is_noisy = true;
  std::array<bool, kUnknowns> free{};
  std::array<double, kUnknowns> scale{};      ///< unit of an unknown in the search: its default prior
  std::array<double, kUnknowns> precision{};  ///< of the prior, (scale / sd)^2
  std::array<double, kResiduals> per_size{};
  /// Of the reference's two values by its total field and dip.
  double first_by_total = 0, first_by_dip = 0, second_by_total = 0, second_by_dip = 0;
  int max_iterations = 50;
  double step_tolerance = 1e-6;  ///< converged when no unknown moves by more, in units of `scale`

  int size() const { return 3 * kind_count; }
};

/// Pointers to one group of trials, or to one of its lanes; rows are kGroup apart.
struct FitData {
  const double *gravity, *magnetic;  ///< rows 3 k + axis
  const double* reference;           ///< rows reference_stride k + {gravity, first, second}
  const double* weight;              ///< row k: weight of station k; null: all 1
  int stations, reference_stride;    ///< 3, or 0: one reference for the run
};

/// Block (a, b), b <= a, of the kinds of a plan.
constexpr std::size_t block(std::size_t a, std::size_t b) { return a * (a + 1) / 2 + b; }

/// Correction by trial parameters.
template <class T>
struct Correction {
  std::array<T, 9> a_inverse, m_inverse;
  survey::Vec3<T> a_bias, m_bias;
  std::array<T, kResiduals> reference_error;
};

template <class T>
std::array<T, 9> inverse3(const std::array<T, 9>& m) {
  const auto minor = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return fms(m[a], m[b], m[c] * m[d]);
  };
  std::array<T, 9> r{minor(4, 8, 5, 7), minor(2, 7, 1, 8), minor(1, 5, 2, 4), minor(5, 6, 3, 8), minor(0, 8, 2, 6),
                     minor(2, 3, 0, 5), minor(3, 7, 4, 6), minor(1, 6, 0, 7), minor(0, 4, 1, 3)};
  const T per_det = T(1.0) / fma(m[0], r[0], fma(m[1], r[3], m[2] * r[6]));
  for (T& v : r) v = v * per_det;
  return r;
}

/// The triads' matrices A and M (parameters.h), row by row, from errors in the table's order.
template <class T>
std::array<T, 9> accelerometer_matrix(const std::array<T, kUnknowns>& x) {
  const T one(1.0), xy = x[kAccelerometerSkew], xz = x[kAccelerometerSkew + 1], yz = x[kAccelerometerSkew + 2];
  return {one + x[kAccelerometerScale],    xy, xz, xy, one + x[kAccelerometerScale + 1], yz, xz, yz,
          one + x[kAccelerometerScale + 2]};
}
template <class T>
std::array<T, 9> magnetometer_matrix(const std::array<T, kUnknowns>& x) {
  const T one(1.0), xy = x[kMagnetometerSkew], xz = x[kMagnetometerSkew + 1], yz = x[kMagnetometerSkew + 2],
                    rx = x[kRotation], ry = x[kRotation + 1], rz = x[kRotation + 2];
  return {one + x[kMagnetometerScale],     xy - rz, xz + ry, xy + rz,
          one + x[kMagnetometerScale + 1], yz - rx, xz - ry, yz + rx,
          one + x[kMagnetometerScale + 2]};
}

/// `x`: all unknowns, in their units; zero where they are not estimated.
template <class T>
Correction<T> correction_of(const FitPlan& plan, const std::array<T, kUnknowns>& x) {
  Correction<T> c;
  c.a_inverse = inverse3<T>(accelerometer_matrix(x));
  c.m_inverse = inverse3<T>(magnetometer_matrix(x));
  c.a_bias = {x[kAccelerometerBias], x[kAccelerometerBias + 1], x[kAccelerometerBias + 2]};
  c.m_bias = {x[kMagnetometerBias], x[kMagnetometerBias + 1], x[kMagnetometerBias + 2]};
  const T total = x[kReferenceKind + 1], dip = x[kReferenceKind + 2];
  c.reference_error = {x[kReferenceKind], fma(T(plan.first_by_total), total, T(plan.first_by_dip) * dip),
                       fma(T(plan.second_by_total), total, T(plan.second_by_dip) * dip)};
  return c;
}

template <class T>
survey::Vec3<T> load3(const double* p) {
  return {load<T>(p), load<T>(p + kGroup), load<T>(p + 2 * kGroup)};
}
template <class T>
survey::Vec3<T> times(const std::array<T, 9>& m, const survey::Vec3<T>& v) {
  return {fma(m[0], v.x, fma(m[1], v.y, m[2] * v.z)), fma(m[3], v.x, fma(m[4], v.y, m[5] * v.z)),
          fma(m[6], v.x, fma(m[7], v.y, m[8] * v.z))};
}
template <class T>
survey::Vec3<T> transposed_times(const std::array<T, 9>& m, const survey::Vec3<T>& v) {
  return {fma(m[0], v.x, fma(m[3], v.y, m[6] * v.z)), fma(m[1], v.x, fma(m[4], v.y, m[7] * v.z)),
          fma(m[2], v.x, fma(m[5], v.y, m[8] * v.z))};
}

/// A station's corrected readings, its residuals in units of the sizes times `root_weight`, and minus their gradients,
/// pulled back to readings: rows of the Jacobian for biases.
template <class T>
struct StationTerms {
  survey::Vec3<T> g, b;
  std::array<T, kResiduals> r;
  std::array<survey::Vec3<T>, kResiduals> by_gravity, by_field;  ///< by_field[0] is zero and not set
};

template <class T>
[[gnu::always_inline]] inline StationTerms<T> station_terms(const FitPlan& plan, const Correction<T>& c,
                                                            const double* gravity, const double* magnetic,
                                                            const double* reference, const T& root_weight) {
  using survey::Vec3;
  StationTerms<T> s;
  s.g = load3<T>(gravity);
  if (plan.corrects_accelerometers) s.g = times(c.a_inverse, s.g - c.a_bias);
  s.b = times(c.m_inverse, load3<T>(magnetic) - c.m_bias);
  const T one(1.0), g2 = dot(s.g, s.g), gravity_size = sqrt(g2), per_g = gravity_size * (one / g2);
  const Vec3<T> u = scale(per_g, s.g);
  const T bv = dot(u, s.b);
  std::array<T, kResiduals> size, value;
  for (std::size_t j = 0; j < kResiduals; ++j) size[j] = T(plan.per_size[j]) * root_weight;
  value[0] = gravity_size;
  Vec3<T> first, second, turning;  // dr/db of the two residuals; direction into which gravity's error turns them
  T first_turn, second_turn;
  if (plan.residuals == ResidualKind::survey) {
    const Vec3<T> across{fma(-bv, u.x, s.b.x), fma(-bv, u.y, s.b.y), fma(-bv, u.z, s.b.z)};
    const T bh2 = dot(across, across), bh = sqrt(bh2), per_bh = bh * (one / bh2);
    first = turning = scale(per_bh, across);
    second = u;
    first_turn = -bv * per_g;
    second_turn = bh * per_g;
    value[1] = bh;
    value[2] = bv;
  } else {
    const T b2 = dot(s.b, s.b), total = sqrt(b2), per_total = total * (one / b2), sine = bv * per_total;
    first = scale(per_total, s.b);
    turning = {fma(-sine, u.x, first.x), fma(-sine, u.y, first.y), fma(-sine, u.z, first.z)};
    second = scale(per_total, Vec3<T>{fma(-sine, first.x, u.x), fma(-sine, first.y, u.y), fma(-sine, first.z, u.z)});
    first_turn = T(0.0);
    second_turn = per_g;
    value[1] = total;
    value[2] = sine;
  }
  for (std::size_t j = 0; j < kResiduals; ++j)
    s.r[j] = (value[j] - (load<T>(reference + j * kGroup) + c.reference_error[j])) * size[j];
  s.by_field[1] = scale(-size[1], transposed_times(c.m_inverse, first));
  s.by_field[2] = scale(-size[2], transposed_times(c.m_inverse, second));
  if (plan.corrects_accelerometers) {
    s.by_gravity[0] = scale(-size[0], transposed_times(c.a_inverse, u));
    const Vec3<T> turn = transposed_times(c.a_inverse, turning);
    s.by_gravity[1] = scale(-size[1] * first_turn, turn);
    s.by_gravity[2] = scale(-size[2] * second_turn, turn);
  }
  return s;
}

/// The three columns of a kind, from minus the gradient `n` by the triad's reading and its corrected value `v`.
template <class T>
[[gnu::always_inline]] inline std::array<T, 3> columns_of(int kind, const survey::Vec3<T>& n,
                                                          const survey::Vec3<T>& v) {
  switch (kind) {
    case kAccelerometerBias:
    case kMagnetometerBias:
      return {n.x, n.y, n.z};
    case kAccelerometerScale:
    case kMagnetometerScale:
      return {n.x * v.x, n.y * v.y, n.z * v.z};
    case kRotation:
      return {fms(v.y, n.z, v.z * n.y), fms(v.z, n.x, v.x * n.z), fms(v.x, n.y, v.y * n.x)};
    default:
      return {fma(n.x, v.y, n.y * v.x), fma(n.x, v.z, n.z * v.x), fma(n.y, v.z, n.z * v.y)};
  }
}
constexpr bool is_of_accelerometer(int kind) {
  return kind == kAccelerometerBias || kind == kAccelerometerScale || kind == kAccelerometerSkew;
}

/// Normal equations in units of the plan's scales, priors included, of the unknowns of its kinds (3 a + i).
template <class T>
struct FitEquations {
  std::array<T, static_cast<std::size_t>(kUnknowns*(kUnknowns + 1) / 2)> matrix;  ///< lower triangle, row by row
  std::array<T, static_cast<std::size_t>(kUnknowns)> gradient;                    ///< half the gradient of the cost
  T cost;
};

/// Of unknowns `x` of the plan's kinds (3 a + i), in units of its scales.
template <class T>
[[gnu::always_inline]] inline Correction<T> correction_at(const FitPlan& plan, const T* x) {
  std::array<T, kUnknowns> value;
  for (T& v : value) v = T(0.0);
  for (std::size_t a = 0; a < static_cast<std::size_t>(plan.kind_count); ++a)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t at = static_cast<std::size_t>(plan.kinds[a]) + i;
      value[at] = T(plan.scale[at]) * x[3 * a + i];
    }
  return correction_of(plan, value);
}

/// At `x`, in units of the plan's scales. Without `WithMatrix` the matrix is not set; all else has the same bits.
template <class T, bool WithMatrix>
void fit_equations(const FitPlan& plan, const FitData& data, const std::array<T, kUnknowns>& x, FitEquations<T>& out) {
  const T zero(0.0);
  const auto kinds = static_cast<std::size_t>(plan.kind_count);
  const Correction<T> c = correction_at(plan, x.data());
  std::array<T, 9 * block(kUnknownKinds, 0)> blocks;
  std::array<T, kUnknowns> gradient;
  for (std::size_t q = 0; WithMatrix && q < 9 * block(kinds, 0); ++q) blocks[q] = zero;
  for (std::size_t q = 0; q < 3 * kinds; ++q) gradient[q] = zero;
  T cost = zero;
  const double *gravity = data.gravity, *magnetic = data.magnetic, *reference = data.reference, *weight = data.weight;
  for (int k = 0; k < data.stations; ++k) {
    const T root_weight = weight ? sqrt(load<T>(weight)) : T(1.0);
    const StationTerms<T> s = station_terms<T>(plan, c, gravity, magnetic, reference, root_weight);
    for (const T& r : s.r) cost = fma(r, r, cost);
    // A kind's columns are linear in the gradient: those of the sum give its part of the right side.
    const auto sum = [&](const std::array<survey::Vec3<T>, kResiduals>& n, std::size_t from) {
      survey::Vec3<T> v = scale(s.r[from], n[from]);
      for (std::size_t j = from + 1; j < kResiduals; ++j)
        v = {fma(s.r[j], n[j].x, v.x), fma(s.r[j], n[j].y, v.y), fma(s.r[j], n[j].z, v.z)};
      return v;
    };
    const survey::Vec3<T> of_field = sum(s.by_field, 1), of_gravity = plan.corrects_accelerometers
                                                                          ? sum(s.by_gravity, 0)
                                                                          : survey::Vec3<T>{zero, zero, zero};
    std::array<std::array<std::array<T, 3>, kResiduals>, kUnknownKinds> rows;
    for (std::size_t a = 0; a < kinds; ++a) {
      const int kind = plan.kinds[a];
      T* g = gradient.data() + 3 * a;
      if (kind == kReferenceKind) {
        std::array<T, kResiduals> size;
        for (std::size_t j = 0; j < kResiduals; ++j) size[j] = T(-plan.per_size[j]) * root_weight;
        const T ft = size[1] * T(plan.first_by_total), fd = size[1] * T(plan.first_by_dip),
                st = size[2] * T(plan.second_by_total), sd = size[2] * T(plan.second_by_dip);
        g[0] = fma(size[0], s.r[0], g[0]);
        g[1] = fma(ft, s.r[1], fma(st, s.r[2], g[1]));
        g[2] = fma(fd, s.r[1], fma(sd, s.r[2], g[2]));
        if constexpr (WithMatrix) {
          rows[a][0] = {size[0], zero, zero};
          rows[a][1] = {zero, ft, fd};
          rows[a][2] = {zero, st, sd};
        }
      } else {
        const bool accelerometer = is_of_accelerometer(kind);
        const std::array<T, 3> of_sum =
            columns_of(kind, accelerometer ? of_gravity : of_field, accelerometer ? s.g : s.b);
        for (std::size_t i = 0; i < 3; ++i) g[i] = g[i] + of_sum[i];
        if constexpr (WithMatrix)
          for (std::size_t j = accelerometer ? 0 : 1; j < kResiduals; ++j)
            rows[a][j] = columns_of(kind, accelerometer ? s.by_gravity[j] : s.by_field[j], accelerometer ? s.g : s.b);
      }
    }
    if constexpr (WithMatrix) {
      const auto sees_gravity = [&](std::size_t a) {
        return plan.kinds[a] == kReferenceKind || is_of_accelerometer(plan.kinds[a]);
      };
      for (std::size_t a = 0; a < kinds; ++a)
        for (std::size_t b = 0; b <= a; ++b) {
          T* m = blocks.data() + 9 * block(a, b);
#pragma GCC unroll 3
          for (std::size_t i = 0; i < 3; ++i)
#pragma GCC unroll 3
            for (std::size_t l = 0; l < 3; ++l)
              m[3 * i + l] = fma(rows[a][1][i], rows[b][1][l], fma(rows[a][2][i], rows[b][2][l], m[3 * i + l]));
          if (sees_gravity(a) && sees_gravity(b)) {
#pragma GCC unroll 3
            for (std::size_t i = 0; i < 3; ++i)
#pragma GCC unroll 3
              for (std::size_t l = 0; l < 3; ++l) m[3 * i + l] = fma(rows[a][0][i], rows[b][0][l], m[3 * i + l]);
          }
        }
    }
    gravity += 3 * kGroup;
    magnetic += 3 * kGroup;
    reference += data.reference_stride * kGroup;
    if (weight) weight += kGroup;
  }
  const auto unknown = [&](std::size_t i) { return static_cast<std::size_t>(plan.kinds[i / 3]) + i % 3; };
  for (std::size_t i = 0; i < 3 * kinds; ++i) {
    const std::size_t at = unknown(i);
    const T precision(plan.precision[at]);
    cost = fma(precision * x[i], x[i], cost);
    out.gradient[i] = plan.free[at] ? fma(precision, x[i], T(plan.scale[at]) * gradient[i]) : zero;
    if constexpr (WithMatrix)
      for (std::size_t j = 0; j <= i; ++j) {
        const std::size_t to = unknown(j);
        T m = blocks[9 * block(i / 3, j / 3) + 3 * (i % 3) + j % 3] * T(plan.scale[at] * plan.scale[to]);
        if (i == j) m = m + precision;
        out.matrix[packed(i, j)] = plan.free[at] && plan.free[to] ? m : T(i == j ? 1.0 : 0.0);
      }
  }
  out.cost = cost;
}

/// A = L D L' in place, of the first n unknowns, a multiple of three: L below the diagonal, 1/D on it (simd/solve.h).
/// Three columns at once: what they take away from the rest is summed in registers, column by column.
template <class T>
void factorise(std::size_t n, T* a) {
  std::array<T, 3 * kUnknowns> minus;  // of each row: minus its three entries before they are divided by D
  for (std::size_t k = 0; k < n; k += 3) {
    T *row0 = a + packed(k, k), *row1 = a + packed(k + 1, k), *row2 = a + packed(k + 2, k);
    const T one(1.0), per_d0 = one / row0[0], u10 = row1[0], u20 = row2[0], l10 = u10 * per_d0, l20 = u20 * per_d0,
                      per_d1 = one / fma(-u10, l10, row1[1]), u21 = fma(-u20, l10, row2[1]), l21 = u21 * per_d1,
                      per_d2 = one / fma(-u21, l21, fma(-u20, l20, row2[2]));
    row0[0] = per_d0;
    row1[0] = l10;
    row1[1] = per_d1;
    row2[0] = l20;
    row2[1] = l21;
    row2[2] = per_d2;
    for (std::size_t i = k + 3; i < n; ++i) {
      T* row = a + packed(i, k);
      const T u0 = row[0], u1 = fma(-u0, l10, row[1]), u2 = fma(-u1, l21, fma(-u0, l20, row[2]));
      row[0] = u0 * per_d0;
      row[1] = u1 * per_d1;
      row[2] = u2 * per_d2;
      minus[3 * i] = -u0;
      minus[3 * i + 1] = -u1;
      minus[3 * i + 2] = -u2;
    }
    for (std::size_t i = k + 3; i < n; i += 3)
      for (std::size_t j = k + 3; j <= i; j += 3)
#pragma GCC unroll 3
        for (std::size_t u = 0; u < 3; ++u)
#pragma GCC unroll 3
          for (std::size_t v = 0; v < 3; ++v) {
            if (j + v > i + u) continue;
            const T *left = minus.data() + 3 * (i + u), *right = a + packed(j + v, k);
            T& entry = a[packed(i + u, j + v)];
            entry = fma(left[2], right[2], fma(left[1], right[1], fma(left[0], right[0], entry)));
          }
  }
}

/// Solves A x = b from factorise().
template <class T>
void solve_factorised(std::size_t n, const T* f, T* x) {
  for (std::size_t k = 0; k < n; k += 3) {
    const T *row1 = f + packed(k + 1, k), *row2 = f + packed(k + 2, k);
    const T x0 = x[k], x1 = fma(-row1[0], x0, x[k + 1]), x2 = fma(-row2[1], x1, fma(-row2[0], x0, x[k + 2]));
    x[k + 1] = x1;
    x[k + 2] = x2;
    for (std::size_t i = k + 3; i < n; ++i) {
      const T* row = f + packed(i, k);
      x[i] = fma(-row[2], x2, fma(-row[1], x1, fma(-row[0], x0, x[i])));
    }
  }
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] * f[packed(i, i)];
  for (std::size_t k = n; k > 0; k -= 3) {
    const T *row1 = f + packed(k - 2, 0), *row2 = f + packed(k - 1, 0);
    const T x2 = x[k - 1], x1 = fma(-row2[k - 2], x2, x[k - 2]),
            x0 = fma(-row1[k - 3], x1, fma(-row2[k - 3], x2, x[k - 3]));
    x[k - 2] = x1;
    x[k - 3] = x0;
    const T* row0 = f + packed(k - 3, 0);
    for (std::size_t i = 0; i + 3 < k; ++i) x[i] = fma(-row0[i], x0, fma(-row1[i], x1, fma(-row2[i], x2, x[i])));
  }
}

/// Diagonal of A^-1 from factorise(): sum_k (L^-1)_ki^2 / D_k.
template <class T>
void inverse_diagonal(std::size_t n, const T* f, T* out) {
  for (std::size_t i = 0; i < n; ++i) {
    std::array<T, kUnknowns> column;  // i of L^-1
    for (std::size_t k = i; k < n; ++k) column[k] = T(k == i ? 1.0 : 0.0);
    T sum(0.0);
    for (std::size_t k = i; k < n; ++k) {
      for (std::size_t l = k + 1; l < n; ++l) column[l] = fma(-f[packed(l, k)], column[k], column[l]);
      sum = fma(column[k] * column[k], f[packed(k, k)], sum);
    }
    out[i] = sum;
  }
}

/// Of the unknowns of the plan's kinds (3 a + i), in units of its scales.
template <class T>
struct FitSolution {
  std::array<T, kUnknowns> x;
  std::array<T, static_cast<std::size_t>(kUnknowns*(kUnknowns + 1) / 2)> factor;  ///< of the last normal matrix
  T cost;        ///< sum of weighted squared residuals and of the priors' part
  T iterations;  ///< evaluations of the model
  T converged;   ///< 1 or 0
};

/// Gauss-Newton from `start`. A matrix serves for the next steps too as long as each step is a tenth of the step
/// before. A step that raises the cost is halved. A lane that has finished is frozen and a lane that keeps its matrix
/// ignores a new one, so that the answer of a lane does not depend on the other lanes.
template <class T>
void solve_fit(const FitPlan& plan, const FitData& data, const std::array<T, kUnknowns>& start, FitSolution<T>& out) {
  const T zero(0.0), one(1.0), tolerance(plan.step_tolerance);
  constexpr double kFirstBound = 100;  // of the first step, in priors: within a tenth of it the matrix is kept
  const auto n = static_cast<std::size_t>(plan.size());
  std::array<T, kUnknowns> step, x, next;
  out.x = start;
  for (std::size_t i = 0; i < n; ++i) step[i] = zero;
  for (std::size_t i = 0; i < packed(n, 0); ++i) out.factor[i] = zero;
  FitEquations<T> e;
  T best_cost(1e300), iterations = zero, last_largest(kFirstBound);
  auto active = zero < one, keeps_matrix = one < zero, converged = one < zero;
  for (int it = 0; it < plan.max_iterations && any(active); ++it) {
    for (std::size_t i = 0; i < n; ++i) x[i] = out.x[i] + step[i];
    if (all(keeps_matrix | (!active))) {
      fit_equations<T, false>(plan, data, x, e);
    } else {
      fit_equations<T, true>(plan, data, x, e);
      factorise(n, e.matrix.data());
      for (std::size_t i = 0; i < packed(n, 0); ++i)
        out.factor[i] = select(keeps_matrix | (!active), out.factor[i], e.matrix[i]);
    }
    for (std::size_t i = 0; i < n; ++i) next[i] = -e.gradient[i];
    solve_factorised(n, out.factor.data(), next.data());
    // Rounding may raise the cost of a step that no longer matters; such steps are below any sensible tolerance.
    const auto accept = active & (e.cost <= best_cost * T(1 + 1e-10));
    T largest = zero;
    for (std::size_t i = 0; i < n; ++i) {
      out.x[i] = select(accept, x[i], out.x[i]);
      step[i] = select(accept, next[i], T(0.5) * step[i]);
      largest = largest + abs(step[i]) * abs(step[i]);  // a NaN stays one
    }
    largest = sqrt(largest);
    best_cost = select(accept, e.cost, best_cost);
    iterations = iterations + select(active, one, zero);
    keeps_matrix = accept & (largest < T(0.1) * last_largest);
    last_largest = largest;
    const auto done = active & (largest <= tolerance);
    for (std::size_t i = 0; i < n; ++i)  // the last step is free: take it
      out.x[i] = select(done & accept, out.x[i] + step[i], out.x[i]);
    converged = converged | done;
    active = active & (!done) & (largest < T(1e300));
  }
  out.cost = best_cost;
  out.iterations = iterations;
  out.converged = select(converged, one, zero);
}

}  // namespace surveymc::multistation
