#include "chained/block_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "chained/descent_kernel.h"
#include "stats/linear_algebra.h"
#include "stats/matrices.h"
#include "stats/small_matrix.h"

namespace surveymc::chained {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Columns = Eigen::Matrix<double, 12, Eigen::Dynamic, 0, 12, 4>;
using Pivot = stats::SmallCholesky<12>;

namespace {

/// Normal equations  [H B; B' C] x = -[gradient]: H block tridiagonal, block (k, k+1) of it diagonal: -links on the
/// chain. Halves of gradients and Hessians.
struct NormalBlocks {
  std::vector<Matrix12> diagonal;
  ChainVector link_weight;       ///< 0 for states that are not linked
  std::vector<Columns> columns;  ///< first the negative gradient, then the border
  VectorXd border_rhs;
  MatrixXd border;
  // Levenberg's scale D: steps of the chain and the border in prior sd, of attitudes by kAttitudeScale
  ChainVector chain_scale;
  double border_scale;
};

/// Prior of the first station's chained states, instead of the model's prior.
struct ChainPrior {
  ChainVector mean;
  Eigen::Matrix<double, kChainStates, kChainStates> information;
};

/// 1 / sd^2.
double per_square(double sd) { return 1 / (sd * sd); }

ChainVector per_square(const double* sd) {
  ChainVector w;
  for (Index i = 0; i < kChainStates; ++i) w[i] = per_square(sd[i]);
  return w;
}

double dot12(const double* a, const double* b) { return stats::dot_by_halves<12>(a, b); }
double dot_chain(const ChainVector& a, const ChainVector& b) {
  return stats::dot_by_halves<kChainStates>(a.data(), b.data());
}

ChainVector product(const ChainMatrix& a, const ChainVector& b) {
  ChainVector c = ChainVector::Zero();
  for (Index j = 0; j < kChainStates; ++j)
    for (Index i = 0; i < kChainStates; ++i) c[i] += a(i, j) * b[j];
  return c;
}

/// Of a station's chained states by themselves, without links: the prior, and references that are observed anew.
ChainVector own_weight(const Model& m, int station) {
  ChainVector w = ChainVector::Zero();
  if (station == 0) w = per_square(m.prior_sd.data());
  for (Index i = 0; m.independent() && i < kReferenceStates; ++i)
    w[i] = per_square(m.reference_sd[static_cast<std::size_t>(i)]);
  return w;
}

NormalBlocks normal_blocks(const Model& m, const Readings& readings, const Point& at, const ChainPrior* first) {
  const int n = readings.stations();
  const Index q = m.interference.states();
  NormalBlocks b;
  b.link_weight = per_square(m.link_sd.data());
  if (m.independent()) b.link_weight.head<kReferenceStates>().setZero();
  b.chain_scale = per_square(m.prior_sd.data());
  b.border_scale = per_square(m.interference.prior_sd);
  b.border_rhs = -at.interference / (m.interference.prior_sd * m.interference.prior_sd);
  b.border.setZero(q, q);
  for (Index i = 0; i < q; ++i) b.border(i, i) = b.border_scale;
  for (int k = 0; k < n; ++k) {
    const auto station = static_cast<std::size_t>(k);
    const StationLinear s = linearise(m, readings, at, k);
    Eigen::Matrix<double, 6, 12> j;
    j.leftCols<3>() = s.by_delta;
    j.rightCols<kChainStates>() = s.by_chain;
    Matrix12 h;
    Columns c(12, 1 + q);
    for (Index row = 0; row < 12; ++row) {
      for (Index i = 0; i <= row; ++i) h(row, i) = h(i, row) = dot6(&j(0, row), &j(0, i));
      c(row, 0) = dot6(&j(0, row), s.residual.data());
      for (Index i = 0; i < q; ++i) c(row, 1 + i) = dot6(&j(0, row), &s.by_interference(0, i));
    }
    for (Index i = 0; i < q; ++i) {
      b.border_rhs[i] += dot6(&s.by_interference(0, i), s.residual.data());
      for (Index l = 0; l < q; ++l) b.border(i, l) += dot6(&s.by_interference(0, i), &s.by_interference(0, l));
    }

    const ChainVector& x = at.chain[station];
    ChainVector weight = ChainVector::Zero(), pull;
    if (!first) weight = own_weight(m, k);
    for (Index i = 0; i < kChainStates; ++i) {
      pull[i] = -(weight[i] * x[i]);
      if (k > 0) {
        pull[i] -= b.link_weight[i] * (x[i] - at.chain[station - 1][i]);
        weight[i] += b.link_weight[i];
      }
      if (k + 1 < n) {
        pull[i] += b.link_weight[i] * (at.chain[station + 1][i] - x[i]);
        weight[i] += b.link_weight[i];
      }
    }
    if (k == 0 && first) {
      pull += product(first->information, first->mean - x);
      h.bottomRightCorner<kChainStates, kChainStates>() += first->information;
    }
    for (const KnownState& known : readings.known)
      if (known.station == k) {
        weight[known.state] += per_square(known.sd);
        pull[known.state] += (known.value - x[known.state]) / (known.sd * known.sd);
      }
    for (Index i = 0; i < kChainStates; ++i) {
      c(3 + i, 0) += pull[i];
      h(3 + i, 3 + i) += weight[i];
    }
    b.diagonal.push_back(h);
    b.columns.push_back(c);
  }
  return b;
}

/// The same blocks with half the true Hessian.
NormalBlocks exact_blocks(NormalBlocks b, const Model& m, const Readings& readings, const Point& at) {
  for (int k = 0; k < readings.stations(); ++k) {
    const StationCurvature c = curvature(m, linearise(m, readings, at, k), at, k);
    Matrix12& h = b.diagonal[static_cast<std::size_t>(k)];
    Columns& columns = b.columns[static_cast<std::size_t>(k)];
    for (Index row = 0; row < 3; ++row) {
      for (Index i = 0; i < 3; ++i) h(row, i) -= c.delta_delta(row, i);
      for (Index i = 0; i < kReferenceStates; ++i) {
        h(row, 3 + i) -= c.delta_chain(row, i);
        h(3 + i, row) -= c.delta_chain(row, i);
      }
      for (Index i = 0; i < m.interference.states(); ++i) columns(row, 1 + i) -= c.delta_interference(row, i);
    }
  }
  return b;
}

/// Columns of the inverse stand beside each other in memory, so that compilers put them into vectors. No column sees
/// another: no bit depends on that.
Matrix12 inverse_of(const Pivot& pivot) {
  using Row = std::array<double, 12>;
  const Matrix12& l = pivot.lower();
  std::array<Row, 12> x{};
  for (std::size_t i = 0; i < 12; ++i) x[i][i] = 1;
  const auto subtract = [](Row& to, double factor, const Row& of) {
    for (std::size_t c = 0; c < 12; ++c) to[c] -= factor * of[c];
  };
  for (std::size_t i = 0; i < 12; ++i) {
    const auto row = static_cast<Index>(i);
    for (std::size_t j = 0; j < i; ++j) subtract(x[i], l(row, static_cast<Index>(j)), x[j]);
    for (double& v : x[i]) v /= l(row, row);
  }
  for (std::size_t i = 12; i-- > 0;) {
    const auto row = static_cast<Index>(i);
    for (std::size_t j = i + 1; j < 12; ++j) subtract(x[i], l(static_cast<Index>(j), row), x[j]);
    for (double& v : x[i]) v /= l(row, row);
  }
  return Eigen::Map<const Matrix12>(x.front().data());  // rows as columns: symmetric
}

Columns solved(const Pivot& pivot, Columns columns) {
  for (Index i = 0; i < columns.cols(); ++i) pivot.solve_in_place(&columns(0, i));
  return columns;
}

/// Block Cholesky from the first station to the last; solves for all columns.
struct BlockSolution {
  std::vector<Pivot> pivots;
  std::vector<Columns> x;
  VectorXd border;  ///< solution of the border
  stats::SymmetricFactor schur;
  bool sound = true;  ///< all pivots are positive definite
};

/// Adds what the link to a station says whose columns are known: W times their chained states.
void add_linked(const NormalBlocks& b, const Columns& of, Columns& to) {
  for (Index column = 0; column < to.cols(); ++column)
    for (Index i = 0; i < kChainStates; ++i) to(3 + i, column) += b.link_weight[i] * of(3 + i, column);
}

BlockSolution solve_blocks(const NormalBlocks& b, double damping) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  BlockSolution s;
  std::vector<Columns> reduced;
  for (std::size_t k = 0; k < n; ++k) {
    Matrix12 d = b.diagonal[k];
    for (Index i = 0; i < 3; ++i) d(i, i) += damping * kAttitudeScale;
    for (Index i = 0; i < kChainStates; ++i) d(3 + i, 3 + i) += damping * b.chain_scale[i];
    Columns r = b.columns[k];
    if (k > 0) {
      // Off-diagonal block: -W on the chain. Schur complement: D - E' P^-1 E, with E = (0; -W).
      const Matrix12 inverse = inverse_of(s.pivots[k - 1]);
      for (Index j = 0; j < kChainStates; ++j)
        for (Index i = 0; i < kChainStates; ++i)
          d(3 + i, 3 + j) -= b.link_weight[i] * inverse(3 + i, 3 + j) * b.link_weight[j];
      add_linked(b, solved(s.pivots[k - 1], reduced[k - 1]), r);
    }
    s.pivots.emplace_back(d);
    s.sound = s.sound && s.pivots.back().positive_definite();
    reduced.push_back(r);
  }
  s.x.resize(n);
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    Columns r = reduced[k];
    if (back > 0) add_linked(b, s.x[k + 1], r);
    s.x[k] = solved(s.pivots[k], r);
  }
  s.border = VectorXd(0);
  if (q == 0) return s;
  MatrixXd schur = b.border;
  for (Index i = 0; i < q; ++i) schur(i, i) += damping * b.border_scale;
  VectorXd rhs = b.border_rhs;
  for (std::size_t k = 0; k < n; ++k)
    for (Index i = 0; i < q; ++i) {
      const double* of = &b.columns[k](0, 1 + i);
      for (Index j = 0; j < q; ++j) schur(i, j) -= dot12(of, &s.x[k](0, 1 + j));
      rhs[i] -= dot12(of, s.x[k].data());
    }
  s.schur = stats::symmetric_factor(schur);
  s.border = s.schur.solve(rhs);
  s.sound = s.sound && s.schur.positive_definite();
  return s;
}

/// z a z', z the columns of a station's solution that stand for the border: at most three.
Matrix12 by_border(const Columns& x, const MatrixXd& a) {
  const Index q = a.rows();
  Matrix12 c = Matrix12::Zero();
  for (Index j = 0; j < q; ++j) {
    Vector12 za = Vector12::Zero();
    for (Index l = 0; l < q; ++l)
      for (Index i = 0; i < 12; ++i) za[i] += x(i, 1 + l) * a(l, j);
    for (Index column = 0; column < 12; ++column)
      for (Index i = 0; i < 12; ++i) c(i, column) += za[i] * x(column, 1 + j);
  }
  return c;
}

/// Diagonal blocks of the inverse, last station first: S_k = D_k^-1 + G S_k+1 G', G = D_k^-1 (0; W), plus the part of
/// the border.
void set_covariances(const NormalBlocks& b, const BlockSolution& s, Solution& out) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  if (q > 0) out.interference_covariance = s.schur.inverse();
  if (q > 0) out.log_determinant = s.schur.log_determinant();
  for (const Pivot& pivot : s.pivots) {
    double sum = 0;
    for (Index i = 0; i < 12; ++i) sum += std::log(pivot.lower()(i, i));
    out.log_determinant += 2 * sum;
  }
  Matrix12 next;
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    Matrix12 c = inverse_of(s.pivots[k]);
    if (back > 0) {
      using Gain = Eigen::Matrix<double, 12, kChainStates>;
      Gain g, by_next;
      for (Index j = 0; j < kChainStates; ++j)
        for (Index i = 0; i < 12; ++i) g(i, j) = c(i, 3 + j) * b.link_weight[j];
      const ChainMatrix of_chain = next.bottomRightCorner<kChainStates, kChainStates>();
      const Eigen::Matrix<double, kChainStates, 12> transposed = g.transpose();
      Matrix12 from_next;
      stats::set_product(g, of_chain, by_next);
      stats::set_product(by_next, transposed, from_next);
      c += from_next;
    }
    next = c;
    if (q > 0) c += by_border(s.x[k], out.interference_covariance);
    out.stations[k].covariance = (c + c.transpose()) / 2;
  }
}

struct Step {
  std::vector<Vector3d> delta;
  std::vector<ChainVector> dc;
  VectorXd da;
  bool positive = true;
  double promise = 0;  ///< stats/descent.h
};
Step step_of(const NormalBlocks& b, const BlockSolution& s, double damping) {
  Step step;
  step.da = s.border;
  step.positive = s.sound;
  step.promise = b.border_rhs.dot(step.da) + damping * b.border_scale * step.da.squaredNorm();
  for (std::size_t k = 0; k < s.x.size(); ++k) {
    const Columns& x = s.x[k];
    Vector12 own;
    for (Index i = 0; i < 12; ++i) {
      double by_border = 0;
      for (Index j = 0; j < step.da.size(); ++j) by_border += x(i, 1 + j) * step.da[j];
      own[i] = x(i, 0) - by_border;
    }
    step.delta.push_back(own.head<3>());
    step.dc.push_back(own.tail<kChainStates>());
    step.promise +=
        dot12(b.columns[k].data(), own.data()) +
        damping * (kAttitudeScale * step.delta[k].squaredNorm() + dot_chain(b.chain_scale, step.dc[k].cwiseAbs2()));
  }
  return step;
}

/// The chain as a problem of stats/descent.h.
class ChainProblem {
 public:
  using Scalar = double;

  ChainProblem(const Model& m, const Readings& readings, Point start, const ChainPrior* first = nullptr)
      : m_(m), readings_(readings), first_(first), at_(std::move(start)), next_(at_) {}

  const Point& at() const { return at_; }
  double cost() const { return cost_of(at_); }
  DescentStep<double, bool> solve(bool curved, double damping) {
    if (!gauss_newton_) gauss_newton_ = normal_blocks(m_, readings_, at_, first_);
    if (curved && !newton_) newton_ = exact_blocks(*gauss_newton_, m_, readings_, at_);
    const NormalBlocks& b = curved ? *newton_ : *gauss_newton_;
    step_ = step_of(b, solve_blocks(b, damping), damping);
    return {step_.positive, step_.promise, step_size2(m_, step_.delta, step_.dc, step_.da)};
  }
  double try_step() {
    next_ = at_;
    for (int k = 0; k < readings_.stations(); ++k)
      step_station(next_, k, step_.delta[static_cast<std::size_t>(k)], step_.dc[static_cast<std::size_t>(k)]);
    next_.interference += step_.da;
    return cost_of(next_);
  }
  void take(bool where) {
    if (!where) return;
    std::swap(at_, next_);
    gauss_newton_.reset();
    newton_.reset();
  }
  double rounding(double cost) const { return cost_rounding(m_, readings_.stations(), cost); }

 private:
  double cost_of(const Point& at) const {
    if (!first_) return chain_cost(m_, readings_, at);
    const ChainVector away = at.chain[0] - first_->mean;
    return readings_cost(m_, readings_, at) + dot_chain(away, product(first_->information, away));
  }

  const Model& m_;
  const Readings& readings_;
  const ChainPrior* first_;
  Point at_, next_;
  std::optional<NormalBlocks> gauss_newton_, newton_;
  Step step_;
};

}  // namespace

Point basic_start(const Model& model, const Readings& readings, const StationSolver& solver) {
  Point p;
  for (const StationReading& y : readings.y) p.frames.push_back(solver(y));
  p.chain.assign(readings.y.size(), ChainVector::Zero());
  p.interference = VectorXd::Zero(model.interference.states());
  return p;
}

double cost_rounding(const Model& m, int stations, double cost) {
  double largest = 0;
  for (std::size_t i = 0; i < 6; ++i)
    largest = std::max(largest, (i < 3 ? m.gravity : std::hypot(m.horizontal, m.down)) / m.noise[i]);
  const double equations = 15.0 * stations;
  return 4 * std::numeric_limits<double>::epsilon() * (2 * largest * std::sqrt(equations * (1 + cost)) + cost);
}

Solution solution_at(const Model& model, const Readings& readings, const Ended& end) {
  Solution out;
  out.status = end.status;
  out.converged = end.status == Status::converged;
  out.iterations = end.iterations;
  out.cost = end.cost;
  out.interference = end.at.interference;
  for (std::size_t k = 0; k < end.at.frames.size(); ++k)
    out.stations.push_back({end.at.frames[k], end.at.chain[k], Matrix12::Zero()});
  const NormalBlocks blocks = normal_blocks(model, readings, end.at, nullptr);
  set_covariances(blocks, solve_blocks(blocks, 0), out);
  return out;
}

Ended descend_blocks(const Model& model, const Readings& readings, const Point& start, const Options& options) {
  check(model);
  Point from = start;
  from.interference.conservativeResize(model.interference.states());
  ChainProblem problem(model, readings, std::move(from));
  const DescentEnd<double> end = descend(problem, options);
  return {problem.at(), end.cost, static_cast<Status>(end.status), static_cast<int>(end.iterations)};
}

Solution solve_blocks(const Model& model, const Readings& readings, const Point& start, const Options& options) {
  return solution_at(model, readings, descend_blocks(model, readings, start, options));
}

StationMinimum solve_station(const Model& model, const Readings& readings, int station, const Eigen::Matrix3d& frame,
                             const ChainVector& mean, const ChainMatrix& covariance, const Options& options) {
  const auto k = static_cast<std::size_t>(station);
  Readings one{{readings.y[k]}};
  if (!readings.left_out.empty()) one.left_out = {readings.left_out[k]};
  ChainPrior prior{mean, ChainMatrix::Identity()};
  const stats::SmallCholesky<kChainStates> factor(covariance);
  for (Index i = 0; i < kChainStates; ++i) factor.solve_in_place(&prior.information(0, i));
  ChainProblem problem(model, one, Point{{frame}, {mean}, VectorXd(0)}, &prior);
  const DescentEnd<double> end = descend(problem, options);
  return {problem.at().frames[0], problem.at().chain[0], static_cast<Status>(end.status),
          static_cast<int>(end.iterations)};
}

Solution solve_blocks(const Model& model, const Readings& readings, const Options& options) {
  return solve_blocks(model, readings, basic_start(model, readings), options);
}

}  // namespace surveymc::chained
