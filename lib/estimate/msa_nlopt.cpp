/// MSA through NLopt: the independent second solver. Slow, one trial at a time; shares only msa_residual.h with the
/// Gauss-Newton kernel.
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <nlopt.hpp>

#include "estimate/msa.h"
#include "estimate/msa_residual.h"
#include "simd/dual.h"

namespace surveymc {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// One trial's data in units of the total field.
struct Problem {
  struct Row {
    Vec3<double> m, u;
    double bh, bv;
  };
  std::vector<Row> rows;
  Vector6 start;  ///< p, q of the start
  Matrix6 scale;  ///< x = start + scale z: near-round contours in z for the derivative-free methods
  int evaluations = 0;

  double cost(const Vector6& x, Vector6* gradient, Matrix6* normal) const {
    using D = Dual<double, 6>;
    double sum = 0;
    if (!gradient) {
      const MsaUnknowns<double> v{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
      for (const Row& row : rows)
        for (const double r : msa_residual(row.m, row.u, row.bh, row.bv, v)) sum += r * r;
      return sum;
    }
    gradient->setZero();
    std::array<D, 6> v;
    for (int i = 0; i < 6; ++i) v[static_cast<std::size_t>(i)] = D::variable(x[i], static_cast<std::size_t>(i));
    for (const Row& row : rows) {
      const auto r = msa_residual<D>({row.m.x, row.m.y, row.m.z}, {row.u.x, row.u.y, row.u.z}, row.bh, row.bv,
                                     {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
      for (const D& e : r) {
        const Eigen::Map<const Vector6> j(e.d.data());
        sum += e.a * e.a;
        *gradient += 2 * e.a * j;
        if (normal) *normal += j * j.transpose();
      }
    }
    return sum;
  }
};

double objective(const std::vector<double>& z, std::vector<double>& gradient, void* data) {
  Problem& p = *static_cast<Problem*>(data);
  ++p.evaluations;
  const Vector6 x = p.start + p.scale * Eigen::Map<const Vector6>(z.data());
  if (gradient.empty()) return p.cost(x, nullptr, nullptr);
  Vector6 g;
  const double value = p.cost(x, &g, nullptr);
  Eigen::Map<Vector6>(gradient.data()) = p.scale.transpose() * g;
  return value;
}

/// Moves the start to x and scales the unknowns by the normal matrix there.
void recenter(Problem& p, const Vector6& x) {
  Vector6 g;
  Matrix6 normal = Matrix6::Zero();
  p.start = x;
  p.cost(x, &g, &normal);
  p.scale = normal.llt().matrixU().solve(Matrix6::Identity());
}

class MsaNlopt final : public Estimator {
 public:
  MsaNlopt(nlopt::algorithm algorithm, std::string label, const MsaOptions& options, double total)
      : algorithm_(algorithm), label_(std::move(label)), options_(options), total_(total) {}
  std::string name() const override { return "msa (NLopt " + label_ + ")"; }

  void solve(const ReadingBlock& in, EstimateBlock& out) const override {
    for (int t = 0; t < in.trials; ++t) solve_one(in, t, out);
  }

 private:
  void solve_one(const ReadingBlock& in, int t, EstimateBlock& out) const {
    Problem p;
    for (int k = 0; k < in.stations; ++k) {
      const auto triad = [&](const LaneArray& a, double s) {
        return Vec3<double>{a.value(t, 3 * k) * s, a.value(t, 3 * k + 1) * s, a.value(t, 3 * k + 2) * s};
      };
      p.rows.push_back({triad(in.magnetic, 1 / total_), triad(in.down, 1),
                        in.reference.value(t, in.reference_stride * k) / total_,
                        in.reference.value(t, in.reference_stride * k + 1) / total_});
    }
    Vector6 x;
    x << 1, 1, 1, 0, 0, 0;
    bool converged = false;
    // Restart from the answer with fresh scaling until it no longer moves: one Nelder-Mead run may stall.
    for (int run = 0; run < 30 && !converged; ++run) {
      recenter(p, x);
      if (!p.scale.allFinite()) break;
      nlopt::opt opt(algorithm_, 6);
      opt.set_min_objective(objective, &p);
      opt.set_xtol_abs(1e-13);
      opt.set_ftol_abs(1e-30);
      opt.set_maxeval(20000);
      opt.set_initial_step(run == 0 ? 1e-1 : 1e-4);
      std::vector<double> z(6, 0.0);
      double value = 0;
      try {
        opt.optimize(z, value);
      } catch (const nlopt::roundoff_limited&) {  // z holds the best point so far: as good as it gets
      } catch (const std::runtime_error&) {
        break;
      }
      const Vector6 next = p.start + p.scale * Eigen::Map<const Vector6>(z.data());
      const double moved = (next - x).cwiseAbs().maxCoeff();
      x = next;
      converged = std::isfinite(moved) && moved <= std::max(options_.step_tolerance, 1e-9);
    }
    const int group = t / kGroup, i = t % kGroup;
    for (int a = 0; a < 3; ++a) {
      out.parameters.row(group, a)[i] = 1 / x[a];
      out.parameters.row(group, 3 + a)[i] = x[3 + a] / x[a] * total_;
    }
    out.cost.row(group, 0)[i] = p.cost(x, nullptr, nullptr) * total_ * total_;
    out.iterations.row(group, 0)[i] = p.evaluations;
    out.converged.row(group, 0)[i] = converged && x.allFinite() && x.head<3>().minCoeff() > 0 ? 1 : 0;
  }

  nlopt::algorithm algorithm_;
  std::string label_;
  MsaOptions options_;
  double total_;
};

}  // namespace

std::unique_ptr<Estimator> make_msa_nlopt(const std::string& algorithm, const MsaOptions& options,
                                          const ReferenceField& field) {
  const nlopt::algorithm a = algorithm == "neldermead" ? nlopt::LN_NELDERMEAD
                             : algorithm == "bobyqa"   ? nlopt::LN_BOBYQA
                                                       : nlopt::LD_LBFGS;
  return std::make_unique<MsaNlopt>(a, algorithm, options, field.total);
}

}  // namespace surveymc
