#include "chained/block_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

#include "chained/descent_kernel.h"
#include "stats/linear_algebra.h"

namespace surveymc::chained {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Columns = Eigen::Matrix<double, 12, Eigen::Dynamic, 0, 12, 4>;

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

NormalBlocks normal_blocks(const Model& m, const Readings& readings, const Point& at, const ChainPrior* first) {
  const int n = readings.stations();
  const Index q = m.interference.states();
  const Eigen::Map<const ChainVector> prior(m.prior_sd.data()), link(m.link_sd.data());
  NormalBlocks b;
  b.link_weight = link.cwiseAbs2().cwiseInverse();
  if (m.independent()) b.link_weight.head<kReferenceStates>().setZero();
  b.chain_scale = prior.cwiseAbs2().cwiseInverse();
  b.border_scale = 1 / (m.interference.prior_sd * m.interference.prior_sd);
  b.border_rhs = -at.interference / (m.interference.prior_sd * m.interference.prior_sd);
  b.border = MatrixXd::Identity(q, q) / (m.interference.prior_sd * m.interference.prior_sd);
  for (int k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const StationLinear s = linearise(m, readings, at, k);
    Eigen::Matrix<double, 6, 12> j;
    j << s.by_delta, s.by_chain;
    Matrix12 h = j.transpose().lazyProduct(j);  // without the blocks that Eigen cuts large products into
    Columns c(12, 1 + q);
    c.col(0) = j.transpose() * s.residual;
    c.rightCols(q) = j.transpose() * s.by_interference;
    b.border_rhs += s.by_interference.transpose() * s.residual;
    b.border += s.by_interference.transpose() * s.by_interference;

    ChainVector weight = k == 0 && !first ? b.chain_scale : ChainVector(ChainVector::Zero());
    if (m.independent() && !first)
      weight.head<kReferenceStates>() = Eigen::Map<const Vector3d>(m.reference_sd.data()).cwiseAbs2().cwiseInverse();
    const auto chain = c.col(0).tail<kChainStates>();
    ChainVector pull = -weight.cwiseProduct(at.chain[i]);
    if (k > 0) {
      pull -= b.link_weight.cwiseProduct(at.chain[i] - at.chain[i - 1]);
      weight += b.link_weight;
    }
    if (k + 1 < n) {
      pull += b.link_weight.cwiseProduct(at.chain[i + 1] - at.chain[i]);
      weight += b.link_weight;
    }
    if (k == 0 && first) {
      pull += first->information * (first->mean - at.chain[i]);
      h.bottomRightCorner<kChainStates, kChainStates>() += first->information;
    }
    for (const KnownState& known : readings.known)
      if (known.station == k) {
        weight[known.state] += 1 / (known.sd * known.sd);
        pull[known.state] += (known.value - at.chain[i][known.state]) / (known.sd * known.sd);
      }
    c.col(0).tail<kChainStates>() = chain + pull;
    h.diagonal().tail<kChainStates>() += weight;
    b.diagonal.push_back(h);
    b.columns.push_back(c);
  }
  return b;
}

/// The same blocks with half the true Hessian.
NormalBlocks exact_blocks(NormalBlocks b, const Model& m, const Readings& readings, const Point& at) {
  for (int k = 0; k < readings.stations(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const StationCurvature c = curvature(m, linearise(m, readings, at, k), at, k);
    b.diagonal[i].topLeftCorner<3, 3>() -= c.delta_delta;
    b.diagonal[i].block<3, kReferenceStates>(0, 3) -= c.delta_chain;
    b.diagonal[i].block<kReferenceStates, 3>(3, 0) -= c.delta_chain.transpose();
    b.columns[i].topRightCorner(3, m.interference.states()) -= c.delta_interference;
  }
  return b;
}

/// L L' x = 1, row by row: the numbers of a row stand beside each other in memory, so that compilers put them into
/// vectors.
Matrix12 inverse_of(const Eigen::LLT<Matrix12>& pivot) {
  const Matrix12& l = pivot.matrixLLT();
  Eigen::Matrix<double, 12, 12, Eigen::RowMajor> x;
  x.setIdentity();
  for (Index i = 0; i < 12; ++i) {
    for (Index j = 0; j < i; ++j) x.row(i) -= l(i, j) * x.row(j);
    x.row(i) /= l(i, i);
  }
  for (Index i = 12; i-- > 0;) {
    for (Index j = i + 1; j < 12; ++j) x.row(i) -= l(j, i) * x.row(j);
    x.row(i) /= l(i, i);
  }
  return x;
}

/// Block Cholesky from the first station to the last; solves for all columns.
struct BlockSolution {
  std::vector<Eigen::LLT<Matrix12>> pivots;
  std::vector<Matrix12> inverses;  ///< of the pivots
  std::vector<Columns> x;
  VectorXd border;  ///< solution of the border
  stats::SymmetricFactor schur;
  bool sound = true;  ///< all pivots are positive definite
};

BlockSolution solve_blocks(const NormalBlocks& b, double damping) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  BlockSolution s;
  std::vector<Columns> reduced;
  for (std::size_t k = 0; k < n; ++k) {
    Matrix12 d = b.diagonal[k];
    d.diagonal().head<3>().array() += damping * kAttitudeScale;
    d.diagonal().tail<kChainStates>() += damping * b.chain_scale;
    Columns r = b.columns[k];
    if (k > 0) {
      // Off-diagonal block: -W on the chain. Schur complement: D - E' P^-1 E, with E = (0; -W).
      const auto of_chain = s.inverses[k - 1].bottomRows<kChainStates>();
      const auto w = b.link_weight.asDiagonal();
      d.bottomRightCorner<kChainStates, kChainStates>() -= w * of_chain.rightCols<kChainStates>() * w;
      r.bottomRows<kChainStates>() += w * of_chain.lazyProduct(reduced[k - 1]);
    }
    s.pivots.emplace_back(d);
    s.inverses.push_back(inverse_of(s.pivots.back()));
    s.sound = s.sound && s.pivots.back().info() == Eigen::Success;
    reduced.push_back(r);
  }
  s.x.resize(n);
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    Columns r = reduced[k];
    if (back > 0) r.bottomRows<kChainStates>() += b.link_weight.asDiagonal() * s.x[k + 1].bottomRows<kChainStates>();
    s.x[k] = s.inverses[k].lazyProduct(r);
  }
  s.border = VectorXd(0);
  if (q == 0) return s;
  MatrixXd schur = b.border;
  schur.diagonal().array() += damping * b.border_scale;
  VectorXd rhs = b.border_rhs;
  for (std::size_t k = 0; k < n; ++k) {
    schur -= b.columns[k].rightCols(q).transpose() * s.x[k].rightCols(q);
    rhs -= b.columns[k].rightCols(q).transpose() * s.x[k].col(0);
  }
  s.schur = stats::symmetric_factor(schur);
  s.border = s.schur.solve(rhs);
  s.sound = s.sound && s.schur.positive_definite();
  return s;
}

/// Diagonal blocks of the inverse, last station first: S_k = D_k^-1 + G S_k+1 G', G = D_k^-1 (0; W), plus the part of
/// the border.
void set_covariances(const NormalBlocks& b, const BlockSolution& s, Solution& out) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  if (q > 0) out.interference_covariance = s.schur.inverse();
  if (q > 0) out.log_determinant = s.schur.log_determinant();
  for (const auto& pivot : s.pivots) out.log_determinant += 2 * pivot.matrixLLT().diagonal().array().log().sum();
  Matrix12 next;
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    Matrix12 c = s.inverses[k];
    if (back > 0) {
      using Gain = Eigen::Matrix<double, 12, kChainStates>;
      const Gain g = s.inverses[k].rightCols<kChainStates>() * b.link_weight.asDiagonal();
      const Gain by_next = g.lazyProduct(next.bottomRightCorner<kChainStates, kChainStates>());
      c += by_next.lazyProduct(g.transpose());
    }
    next = c;
    const auto z = s.x[k].rightCols(q);
    if (q > 0) c += z * out.interference_covariance * z.transpose();
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
    const Eigen::Matrix<double, 12, 1> own = x.col(0) - x.rightCols(step.da.size()) * step.da;
    step.delta.push_back(own.head<3>());
    step.dc.push_back(own.tail<kChainStates>());
    step.promise += b.columns[k].col(0).dot(own) + damping * (kAttitudeScale * step.delta[k].squaredNorm() +
                                                              b.chain_scale.dot(step.dc[k].cwiseAbs2()));
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
    return readings_cost(m_, readings_, at) + away.dot(first_->information * away);
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
  const ChainPrior prior{mean, covariance.llt().solve(ChainMatrix::Identity())};
  ChainProblem problem(model, one, Point{{frame}, {mean}, VectorXd(0)}, &prior);
  const DescentEnd<double> end = descend(problem, options);
  return {problem.at().frames[0], problem.at().chain[0], static_cast<Status>(end.status),
          static_cast<int>(end.iterations)};
}

Solution solve_blocks(const Model& model, const Readings& readings, const Options& options) {
  return solve_blocks(model, readings, basic_start(model, readings), options);
}

}  // namespace surveymc::chained
