#include "estimate/estimator.h"
#include "estimate/field_fit_kernel.h"

#include <string>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "msa_trials.h"
#include "simd/dual.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {

InputErrors all_errors() { return {70, 2e-4, 107, 0.16 * kDegree, false, 0.0016, 70}; }

FieldFitModel model_of(const std::string& estimator, const InputErrors& assumed, const survey::ReferenceField& field) {
  return field_fit_model(test::options_of(estimator, assumed), field);
}

/// Noisy readings of a thesis test; the down direction is noisy too.
struct Data : test::MsaTrials {
  explicit Data(int number, int trials = simd::kGroup)
      : MsaTrials(number, trials, test::msa_noise(1, sensor::ReferenceNoise::per_run, 0.002)) {}
  FieldFitData lane(int t) const {
    const MsaData d = MsaTrials::lane(t);
    return {d.magnetic, d.down, d.reference, d.stations, d.reference_stride};
  }
};

/// The two residuals of one station and trial by the readable model, in units of the total field.
template <class T, std::size_t N>
std::array<T, 2> residual(const FieldFitModel& model, const Data& d, int trial, int k, const std::array<T, N>& x) {
  const double s = 1 / d.c.field.total;
  std::array<T, 2> z{T(0.0), T(0.0)};
  if constexpr (N == 8) z = {x[6], x[7]};
  return field_fit_residual<T>(model, test::triad<T>(d.block.magnetic, trial, k, s),
                               test::triad<T>(d.block.down, trial, k), d.block.reference.value(trial, 0) * s,
                               d.block.reference.value(trial, 1) * s, {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}, z);
}

/// What is minimised (field_fit.h), by the readable model.
template <class T, std::size_t N>
T cost(const FieldFitModel& model, const Data& d, int trial, const std::array<T, N>& x) {
  T sum(0.0);
  for (int k = 0; k < d.block.stations; ++k) {
    const auto r = residual<T, N>(model, d, trial, k, x);
    sum = sum + T(model.w_hh) * r[0] * r[0] + T(2 * model.w_hv) * r[0] * r[1] + T(model.w_vv) * r[1] * r[1];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const T p = x[i] - T(1.0), q = x[3 + i];
    sum = sum + T(model.gain_prior) * p * p + T(model.bias_prior[i]) * q * q;
  }
  for (std::size_t i = 6; i < N; ++i) sum = sum + T(model.unit_weight) * x[i] * x[i];
  return sum;
}

/// A point away from every minimum: residuals of some per cent, so that second derivatives matter.
template <std::size_t N>
std::array<double, N> somewhere() {
  std::array<double, N> x{0.93, 1.04, 0.85, 0.004, -0.003, 0.02};
  if constexpr (N == 8) {
    x[6] = 1.3;
    x[7] = -0.7;
  }
  return x;
}

/// Gradient, Gauss-Newton matrix and exact second derivative of the kernel against dual numbers.
template <std::size_t N>
void check_derivatives(const FieldFitModel& model, const Data& d) {
  using D = simd::Dual<double, N>;
  using DD = simd::Dual<D, N>;
  constexpr int trial = 2;
  const std::array<double, N> x = somewhere<N>();
  std::array<D, N> x1;
  std::array<DD, N> x2;
  for (std::size_t i = 0; i < N; ++i) {
    x1[i] = D::variable(x[i], i);
    x2[i] = DD::variable(x1[i], i);
  }
  const DD exact = cost<DD, N>(model, d, trial, x2);
  const auto newton = field_fit_equations<double, N, true>(model, d.lane(trial), x, 1.0);
  const auto gauss = field_fit_equations<double, N, true>(model, d.lane(trial), x, 0.0);
  const auto bare = field_fit_equations<double, N, false>(model, d.lane(trial), x, 0.0);
  CHECK(bare.gradient == newton.gradient);  // the same bits without the matrix
  CHECK(bare.cost == newton.cost);
  CHECK(newton.cost == Approx(exact.a.a).epsilon(1e-12));

  Eigen::Matrix<double, N, N> jwj = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix2d w;
  w << model.w_hh, model.w_hv, model.w_hv, model.w_vv;
  for (int k = 0; k < d.block.stations; ++k) {
    const auto r = residual<D, N>(model, d, trial, k, x1);
    Eigen::Matrix<double, 2, N> j;
    for (int a = 0; a < 2; ++a)
      for (std::size_t i = 0; i < N; ++i) j(a, static_cast<Eigen::Index>(i)) = r[static_cast<std::size_t>(a)].d[i];
    jwj += j.transpose() * w * j;
  }
  for (int i = 0; i < 3; ++i) {
    jwj(i, i) += model.gain_prior;
    jwj(3 + i, 3 + i) += model.bias_prior[static_cast<std::size_t>(i)];
  }
  for (int i = 6; i < static_cast<int>(N); ++i) jwj(i, i) += model.unit_weight;

  // Columns of z are 1e-3 of the others: every element is held to rounding of its own row and column. A sum of 53
  // stations of both signs loses two digits.
  double largest = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const auto ii = static_cast<Eigen::Index>(i);
    const double own = std::sqrt(jwj(ii, ii) * cost<double, N>(model, d, trial, x));
    CHECK(std::abs(newton.gradient[i] - exact.a.d[i] / 2) < 1e-12 * own);
    for (std::size_t j = 0; j <= i; ++j) {
      const auto jj = static_cast<Eigen::Index>(j);
      CAPTURE(i, j);
      const double bound = 1e-12 * std::sqrt(jwj(ii, ii) * jwj(jj, jj));
      CHECK(std::abs(gauss.matrix[simd::packed(i, j)] - jwj(ii, jj)) < bound);
      CHECK(std::abs(newton.matrix[simd::packed(i, j)] - exact.d[i].d[j] / 2) < bound);
      largest =
          std::max(largest, std::abs(newton.matrix[simd::packed(i, j)] - gauss.matrix[simd::packed(i, j)]) / bound);
    }
  }
  CHECK(largest > 1e9);  // the second-order part is there to be wrong: per cents of the matrix

  // The same by central differences of the gradient, which knows nothing of dual numbers: error h^2 + rounding / h.
  for (std::size_t j = 0; j < N; ++j) {
    const double h = 1e-5;
    auto plus = x, minus = x;
    plus[j] += h;
    minus[j] -= h;
    const auto up = field_fit_equations<double, N, false>(model, d.lane(trial), plus, 1.0),
               down = field_fit_equations<double, N, false>(model, d.lane(trial), minus, 1.0);
    for (std::size_t i = 0; i < N; ++i) {
      const auto ii = static_cast<Eigen::Index>(i), jj = static_cast<Eigen::Index>(j);
      const double own = std::sqrt(jwj(ii, ii) * jwj(jj, jj));
      const double rounding = 1e-14 * std::sqrt(jwj(ii, ii) * newton.cost) / h;
      CHECK(std::abs((up.gradient[i] - down.gradient[i]) / (2 * h) -
                     newton.matrix[simd::packed(i > j ? i : j, i > j ? j : i)]) < 1e-7 * own + rounding);
    }
  }
}

/// The equations with the derivative by a gain at the fitted field, as field_fit.h says them: half the gradient of the
/// cost, with the reading in the derivative by p replaced by that of the field n Bh' + u Bv'.
template <class T, std::size_t N>
std::array<T, N> fitted_equations(const FieldFitModel& model, const Data& d, int trial, const std::array<T, N>& x) {
  using D = simd::Dual<T, N>;
  std::array<D, N> variables;
  for (std::size_t i = 0; i < N; ++i) variables[i] = D::variable(x[i], i);
  std::array<T, N> out;
  for (std::size_t i = 0; i < N; ++i) out[i] = T(0.0);
  const double per_total = 1 / d.c.field.total;
  for (int k = 0; k < d.block.stations; ++k) {
    const auto r = residual<D, N>(model, d, trial, k, variables);
    const T fh = T(model.w_hh) * r[0].a + T(model.w_hv) * r[1].a, fv = T(model.w_hv) * r[0].a + T(model.w_vv) * r[1].a;
    const survey::Vec3<T> m = test::triad<T>(d.block.magnetic, trial, k, per_total),
                          u = test::triad<T>(d.block.down, trial, k);
    const survey::Vec3<T> b{x[0] * m.x - x[3], x[1] * m.y - x[4], x[2] * m.z - x[5]};
    const T bv = dot(u, b);
    const survey::Vec3<T> level = b - scale(bv, u);
    const T bh = norm(level), fitted_bh = bh - r[0].a, fitted_bv = bv - r[1].a;
    const survey::Vec3<T> fitted = scale(fitted_bh / bh, level) + scale(fitted_bv, u);
    const std::array<T, 3> fitted_reading{(fitted.x + x[3]) / x[0], (fitted.y + x[4]) / x[1], (fitted.z + x[5]) / x[2]};
    for (std::size_t i = 0; i < N; ++i) {
      // By p_i the derivative is the reading times minus that by q_i.
      const std::size_t from = i < 3 ? 3 + i : i;
      const T g = r[0].d[from] * fh + r[1].d[from] * fv;
      out[i] = out[i] + (i < 3 ? T(-1.0) * fitted_reading[i] * g : g);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = out[i] + T(model.gain_prior) * (x[i] - T(1.0));
    out[3 + i] = out[3 + i] + T(model.bias_prior[i]) * x[3 + i];
  }
  for (std::size_t i = 6; i < N; ++i) out[i] = out[i] + T(model.unit_weight) * x[i];
  return out;
}

/// Equations at the fitted field and their matrix against dual numbers.
template <std::size_t N>
void check_fitted(const FieldFitModel& model, const Data& d) {
  using D = simd::Dual<double, N>;
  constexpr int trial = 3;
  const std::array<double, N> x = somewhere<N>();
  std::array<D, N> variables;
  for (std::size_t i = 0; i < N; ++i) variables[i] = D::variable(x[i], i);
  const auto exact = fitted_equations<D, N>(model, d, trial, variables);
  const auto kernel = fitted_field_equations<double, N, true>(model, d.lane(trial), x);
  const auto bare = fitted_field_equations<double, N, false>(model, d.lane(trial), x);
  const auto measured = field_fit_equations<double, N, true>(model, d.lane(trial), x, 1.0);
  CHECK(bare.value == kernel.value);  // the same bits without the matrix
  CHECK(bare.cost == measured.cost);
  double largest = 0, unsymmetric = 0;
  for (std::size_t i = 0; i < N; ++i) {
    CAPTURE(i);
    const double own = std::sqrt(measured.matrix[simd::packed(i, i)] * measured.cost);
    CHECK(std::abs(kernel.value[i] - exact[i].a) < 1e-12 * own);  // rounding of 53 stations of both signs
    largest = std::max(largest, std::abs(kernel.value[i] - measured.gradient[i]) / own);
    for (std::size_t j = 0; j < N; ++j) {
      CAPTURE(j);
      const double bound = std::sqrt(measured.matrix[simd::packed(i, i)] * measured.matrix[simd::packed(j, j)]);
      CHECK(std::abs(kernel.matrix[i * N + j] - exact[i].d[j]) < 1e-12 * bound);
      unsymmetric = std::max(unsymmetric, std::abs(kernel.matrix[i * N + j] - kernel.matrix[j * N + i]) / bound);
    }
  }
  CHECK(largest > 1e-3);  // what the fitted field changes is there to be wrong
  CHECK(unsymmetric > 1e-3);
}

template <class T, std::size_t N>
struct Equations {
  const FieldFitModel& model;
  FieldFitData data;
  template <bool WithMatrix>
  NormalEquations<T, N> operator()(const std::array<T, N>& x, const T& second_order) const {
    return field_fit_equations<T, N, WithMatrix>(model, data, x, second_order);
  }
};

template <class T, std::size_t N>
struct FittedEquations {
  const FieldFitModel& model;
  FieldFitData data;
  template <bool WithMatrix>
  RootEquations<T, N> operator()(const std::array<T, N>& x) const {
    return fitted_field_equations<T, N, WithMatrix>(model, data, x);
  }
};

template <class T, std::size_t N>
NewtonSolution<T, N> solve(const FieldFitModel& model, const FieldFitData& data) {
  std::array<T, N> start;
  for (std::size_t i = 0; i < N; ++i) start[i] = T(i < 3 ? 1.0 : 0.0);
  const auto minimum = newton_minimum<T, N>(Equations<T, N>{model, data}, start, {});
  return model.fitted_derivative ? newton_root<T, N>(FittedEquations<T, N>{model, data}, minimum.x, {}) : minimum;
}

template <std::size_t N>
void check_lanes(const FieldFitModel& model, const Data& d) {
  test::require_bits_of_trials_alone(d.block.trials, [&]<class T>(int t) { return solve<T, N>(model, d.lane(t)); });
}

}  // namespace

TEST_CASE("Field fit: gradient and matrices are those of dual numbers and of differences") {
  for (const int number : {1, 3, 4}) {
    const Data d(number);
    CAPTURE(number);
    for (const char* name : {"wls_consider", "msa_weighted"})
      check_derivatives<6>(model_of(name, all_errors(), d.c.field), d);
    check_derivatives<8>(model_of("msa_joint", all_errors(), d.c.field), d);
    InputErrors no_priors = all_errors();
    no_priors.gain = no_priors.bias = 0;
    check_derivatives<8>(model_of("msa_joint", no_priors, d.c.field), d);
  }
}

TEST_CASE("Field fit: equations with the derivative at the fitted field, and their matrix, are those of dual numbers") {
  for (const int number : {1, 3, 4}) {
    const Data d(number);
    CAPTURE(number);
    for (const char* name : {"wls_consider", "msa_weighted"})
      check_fitted<6>(model_of(name, all_errors(), d.c.field), d);
    check_fitted<8>(model_of("msa_joint", all_errors(), d.c.field), d);
  }
}

TEST_CASE("Field fit: what is not estimated has no part in the equations at the fitted field") {
  const Data d(4);
  FieldFitModel m = model_of("msa_joint", all_errors(), d.c.field);
  m.estimated = {true, false, true, false, true, false};
  const auto e = fitted_field_equations<double, 8, true>(m, d.lane(0), somewhere<8>());
  for (std::size_t i = 0; i < 6; ++i) {
    if (m.estimated[i]) continue;
    CHECK(e.value[i] == 0);
    for (std::size_t j = 0; j < 8; ++j) {
      CHECK(e.matrix[8 * i + j] == (i == j ? 1 : 0));
      CHECK(e.matrix[8 * j + i] == (i == j ? 1 : 0));
    }
  }
}

TEST_CASE("Field fit: the weights are correlated, so that an exchange of Bh and Bv would show") {
  const test::ThesisCase c = test::thesis_case(4);
  const FieldFitModel m = model_of("msa_weighted", all_errors(), c.field);
  CHECK(std::abs(m.w_hv) > 0.01);
  CHECK(std::abs(m.w_hh - m.w_vv) > 0.01);
  CHECK(m.w_hh * m.w_vv > m.w_hv * m.w_hv);
}

TEST_CASE("Field fit: a reference that is stretched and rotated as its unknowns say leaves no residual") {
  for (const survey::Attitude& at : test::difficult_attitudes()) {
    const FieldFitModel m{.total_sd = 0.002, .dip_sd = 0.003};
    const double z0 = 1.7, z1 = -2.1, dip = 72 * kDegree;
    // In units of the total field; the truth is B (1 + z0 sd), dip + z1 sd.
    const survey::Vec3<double> b = survey::magnetic_T(at, 1 + z0 * m.total_sd, dip + z1 * m.dip_sd);
    const auto r = field_fit_residual<double>(m, b, survey::down_T(at), std::cos(dip), std::sin(dip),
                                              {{1, 1, 1}, {0, 0, 0}}, {z0, z1});
    CHECK(std::abs(r[0]) < 1e-14);
    CHECK(std::abs(r[1]) < 1e-14);
  }
}

TEST_CASE("Field fit: a trial solved in a lane has the same bits as the trial solved alone") {
  for (const int number : {1, 4}) {
    const Data d(number, 80);
    InputErrors errors = all_errors();
    errors.gain = errors.bias = 0;
    for (const bool fitted : {false, true}) {
      FieldFitModel weighted = model_of("msa_weighted", errors, d.c.field),
                    joint = model_of("msa_joint", errors, d.c.field);
      weighted.fitted_derivative = joint.fitted_derivative = fitted;
      check_lanes<6>(weighted, d);
      check_lanes<8>(joint, d);
    }
  }
}
