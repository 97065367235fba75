/// The estimators of field_fit.h, MSA among them, through NLopt: an independent second solver. It is slow, takes one
/// trial at a time, and shares only the readable residual with the kernels.
#include <cmath>

#include <Eigen/Core>
#include <nlopt.hpp>

#include "estimate/field_fit_estimators.h"
#include "simd/dual.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// One trial's data in units of the total field. Unknowns p, q / total, then z if joint.
struct Problem {
  struct Row {
    survey::Vec3<double> m, u;
    double bh, bv;
  };
  FieldFitModel model;
  std::vector<Row> rows;
  Vector start;
  Vector tilt;   ///< of the equations of p: twice fitted_correction() with the derivative at the fitted field, else 0
  Matrix scale;  ///< x = start + scale z: near-round contours in z for the derivative-free methods
  int evaluations = 0;

  Eigen::Index size() const { return model.joint ? 8 : 6; }

  /// Calls `visit(e, j)` with every weighted residual e, j being its gradient (Dual) or nothing.
  template <class T, class Visit>
  void residuals(const std::array<T, 8>& v, const Visit& visit) const {
    // W = L L': the weighted residuals are L' r.
    const double l11 = std::sqrt(model.w_hh), l21 = model.w_hv / l11, l22 = std::sqrt(model.w_vv - l21 * l21);
    const MsaUnknowns<T> x{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    for (const Row& row : rows) {
      const auto r = field_fit_residual<T>(model, {T(row.m.x), T(row.m.y), T(row.m.z)},
                                           {T(row.u.x), T(row.u.y), T(row.u.z)}, row.bh, row.bv, x, {v[6], v[7]});
      visit(T(l11) * r[0] + T(l21) * r[1]);
      visit(T(l22) * r[1]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      visit(T(std::sqrt(model.gain_prior)) * (v[i] - T(1.0)));
      visit(T(std::sqrt(model.bias_prior[i])) * v[3 + i]);
    }
    if (model.joint)
      for (std::size_t l = 6; l < 8; ++l) visit(T(std::sqrt(model.unit_weight)) * v[l]);
  }

  double cost(const Vector& x, Vector* gradient, Matrix* normal) const {
    double sum = 0;
    if (!gradient) {
      std::array<double, 8> v{};
      for (Eigen::Index i = 0; i < size(); ++i) v[static_cast<std::size_t>(i)] = x[i];
      residuals<double>(v, [&](double r) { sum += r * r; });
      return sum;
    }
    using D = simd::Dual<double, 8>;
    gradient->setZero(size());
    if (normal) normal->setZero(size(), size());
    std::array<D, 8> v;
    for (Eigen::Index i = 0; i < size(); ++i) {
      const auto a = static_cast<std::size_t>(i);
      v[a] = D::variable(x[i], a);
    }
    residuals<D>(v, [&](const D& e) {
      const Eigen::Map<const Vector> j(e.d.data(), size());
      sum += e.a * e.a;
      *gradient += 2 * e.a * j;
      if (normal) *normal += j * j.transpose();
    });
    for (Eigen::Index i = 0; i < 6; ++i)
      if (!model.estimated[static_cast<std::size_t>(i)]) {
        (*gradient)[i] = 0;
        if (normal) {
          normal->row(i).setZero();
          normal->col(i).setZero();
        }
      }
    return sum;
  }

  /// The unknowns that NLopt's z stands for; parameters that are not estimated keep their values.
  Vector at(const std::vector<double>& z) const {
    Vector x = start + scale * Eigen::Map<const Vector>(z.data(), size());
    for (Eigen::Index i = 0; i < 6; ++i)
      if (!model.estimated[static_cast<std::size_t>(i)]) x[i] = start[i];
    return x;
  }
};

/// The terms that the derivative at the fitted field subtracts from the equation of p_i (field_fit_kernel.h):
/// sum_k (a_i'W r)(a_i'r) / p_i, with a_i = -dr/dq_i by dual numbers from the readable residual.
Vector fitted_correction(const Problem& p, const Vector& x) {
  using D = simd::Dual<double, 3>;
  std::array<double, 8> v{};
  for (Eigen::Index i = 0; i < p.size(); ++i) v[static_cast<std::size_t>(i)] = x[i];
  const MsaUnknowns<D> unknowns{{D(v[0]), D(v[1]), D(v[2])},
                                {D::variable(v[3], 0), D::variable(v[4], 1), D::variable(v[5], 2)}};
  Vector c = Vector::Zero(p.size());
  for (const Problem::Row& row : p.rows) {
    const auto r =
        field_fit_residual<D>(p.model, {D(row.m.x), D(row.m.y), D(row.m.z)}, {D(row.u.x), D(row.u.y), D(row.u.z)},
                              row.bh, row.bv, unknowns, {D(v[6]), D(v[7])});
    const double fh = p.model.w_hh * r[0].a + p.model.w_hv * r[1].a, fv = p.model.w_hv * r[0].a + p.model.w_vv * r[1].a;
    for (std::size_t i = 0; i < 3; ++i)
      if (p.model.estimated[i])
        c[static_cast<Eigen::Index>(i)] +=
            (r[0].d[i] * fh + r[1].d[i] * fv) * (r[0].d[i] * r[0].a + r[1].d[i] * r[1].a) / v[i];
  }
  return c;
}

double objective(const std::vector<double>& z, std::vector<double>& gradient, void* data) {
  Problem& p = *static_cast<Problem*>(data);
  ++p.evaluations;
  const Vector x = p.at(z);
  const double tilted = p.tilt.dot(x - p.start);
  if (gradient.empty()) return p.cost(x, nullptr, nullptr) - tilted;
  Vector g;
  const double value = p.cost(x, &g, nullptr) - tilted;
  g -= p.tilt;
  Eigen::Map<Vector>(gradient.data(), p.size()) = p.scale.transpose() * g;
  return value;
}

/// Moves the start to x and scales the unknowns by the normal matrix there. `tilted`: subtracts a linear term from the
/// cost, with gradient twice the fitted_correction() at x. A minimum that then stays at x solves the equations with the
/// derivative at the fitted field.
void recenter(Problem& p, const Vector& x, bool tilted) {
  Vector g;
  Matrix normal;
  p.start = x;
  p.cost(x, &g, &normal);
  p.tilt = Vector::Zero(p.size());
  if (tilted) p.tilt = 2 * fitted_correction(p, x);
  // An unknown that nothing depends on (a reference without uncertainty and without weight) keeps its place.
  for (Eigen::Index i = 0; i < p.size(); ++i)
    if (normal(i, i) == 0) normal(i, i) = 1;
  p.scale = stats::cholesky(normal).solve_upper(Matrix::Identity(p.size(), p.size()));
}

class FieldFitNlopt final : public Estimator {
 public:
  FieldFitNlopt(std::string name, nlopt::algorithm algorithm, const FieldFitModel& model, const NewtonOptions& options)
      : name_(std::move(name)), algorithm_(algorithm), model_(model), options_(options) {}
  std::string name() const override { return name_; }
  bool estimates_reference() const override { return model_.joint; }

  void solve(const survey::ReadingBlock& in, EstimateBlock& out) const override {
    for (int t = 0; t < in.trials; ++t) solve_one(in, t, out);
  }

 private:
  void solve_one(const survey::ReadingBlock& in, int t, EstimateBlock& out) const {
    const double total = model_.total;
    Problem p;
    p.model = model_;
    for (int k = 0; k < in.stations; ++k) {
      const auto triad = [&](const survey::LaneArray& a, double s) {
        return survey::Vec3<double>{a.value(t, 3 * k) * s, a.value(t, 3 * k + 1) * s, a.value(t, 3 * k + 2) * s};
      };
      p.rows.push_back({triad(in.magnetic, 1 / total), triad(in.down, 1),
                        in.reference.value(t, in.reference_stride * k) / total,
                        in.reference.value(t, in.reference_stride * k + 1) / total});
    }
    Vector x = Vector::Zero(p.size());
    x.head<3>().setOnes();
    bool converged = false;
    // Restart from the answer with fresh scaling until it no longer moves: one Nelder-Mead run may stall.
    for (int run = 0; run < 30 && !converged; ++run) {
      // The first search is for the minimum without tilt: far from the minimum the tilt would mislead it.
      const bool tilted = model_.fitted_derivative && run > 0;
      recenter(p, x, tilted);
      if (!p.scale.allFinite()) break;
      nlopt::opt opt(algorithm_, static_cast<unsigned>(p.size()));
      opt.set_min_objective(objective, &p);
      opt.set_xtol_abs(1e-13);
      opt.set_ftol_abs(1e-30);
      opt.set_maxeval(20000);
      opt.set_initial_step(run == 0 ? 1e-1 : 1e-4);
      std::vector<double> z(static_cast<std::size_t>(p.size()), 0.0);
      double value = 0;
      try {
        opt.optimize(z, value);
      } catch (const nlopt::roundoff_limited&) {  // z holds the best point so far: as good as it gets
      } catch (const std::runtime_error&) {
        break;
      }
      const Vector next = p.at(z);
      const double moved = (next - x).cwiseAbs().maxCoeff();
      x = next;
      converged = tilted == model_.fitted_derivative && std::isfinite(moved) &&
                  moved <= std::max(options_.step_tolerance, 1e-9);
    }
    const int group = t / simd::kGroup, i = t % simd::kGroup;
    for (int a = 0; a < 3; ++a) {
      out.parameters.row(group, a)[i] = 1 / x[a];
      out.parameters.row(group, 3 + a)[i] = x[3 + a] / x[a] * total;
    }
    if (model_.joint) {
      const double bh = p.rows[0].bh * total, bv = p.rows[0].bv * total, turn = x[7] * model_.dip_sd;
      const double stretch = 1 + x[6] * model_.total_sd * total / std::hypot(bh, bv);
      out.reference.row(group, 0)[i] = stretch * (std::cos(turn) * bh - std::sin(turn) * bv);
      out.reference.row(group, 1)[i] = stretch * (std::sin(turn) * bh + std::cos(turn) * bv);
    }
    out.cost.row(group, 0)[i] = p.cost(x, nullptr, nullptr) * total * total;
    out.iterations.row(group, 0)[i] = p.evaluations;
    out.converged.row(group, 0)[i] = converged && x.allFinite() && x.head<3>().minCoeff() > 0 ? 1 : 0;
  }

  std::string name_;
  nlopt::algorithm algorithm_;
  FieldFitModel model_;
  NewtonOptions options_;
};

}  // namespace

std::unique_ptr<Estimator> make_field_fit_nlopt(const std::string& name, const std::string& algorithm,
                                                const FieldFitModel& model, const NewtonOptions& options) {
  const nlopt::algorithm a = algorithm == "neldermead" ? nlopt::LN_NELDERMEAD
                             : algorithm == "bobyqa"   ? nlopt::LN_BOBYQA
                                                       : nlopt::LD_LBFGS;
  return std::make_unique<FieldFitNlopt>(name + " (NLopt " + algorithm + ")", a, model, options);
}

}  // namespace surveymc::estimate
