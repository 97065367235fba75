#include "estimate/chained_newton.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace surveymc {

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
  ChainVector
      prior_weight;     ///< Levenberg's scale of the chain: steps in prior sd. Attitudes: Marquardt's, the diagonal.
  double border_scale;  ///< the same for the border
};

NormalBlocks normal_blocks(const ChainedModel& m, const ChainedReadings& readings, const ChainedPoint& at) {
  const int n = readings.stations();
  const Index q = m.interference.states();
  const Eigen::Map<const ChainVector> prior(m.prior_sd.data()), link(m.link_sd.data());
  NormalBlocks b;
  b.link_weight = link.cwiseAbs2().cwiseInverse();
  if (m.independent()) b.link_weight.head<kReferenceStates>().setZero();
  b.prior_weight = prior.cwiseAbs2().cwiseInverse();
  b.border_scale = 1 / (m.interference.prior_sd * m.interference.prior_sd);
  b.border_rhs = -at.interference / (m.interference.prior_sd * m.interference.prior_sd);
  b.border = MatrixXd::Identity(q, q) / (m.interference.prior_sd * m.interference.prior_sd);
  for (int k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const StationLinear s = linearise(m, readings, at, k);
    Eigen::Matrix<double, 6, 12> j;
    j << s.by_delta, s.by_chain;
    Matrix12 h = j.transpose() * j;
    Columns c(12, 1 + q);
    c.col(0) = j.transpose() * s.residual;
    c.rightCols(q) = j.transpose() * s.by_interference;
    b.border_rhs += s.by_interference.transpose() * s.residual;
    b.border += s.by_interference.transpose() * s.by_interference;

    ChainVector weight = k == 0 ? b.prior_weight : ChainVector(ChainVector::Zero());
    if (m.independent())
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
    c.col(0).tail<kChainStates>() = chain + pull;
    h.diagonal().tail<kChainStates>() += weight;
    b.diagonal.push_back(h);
    b.columns.push_back(c);
  }
  return b;
}

/// Block Cholesky from the first station to the last; solves for all columns.
struct BlockSolution {
  std::vector<Eigen::LLT<Matrix12>> pivots;
  std::vector<Columns> x;
  VectorXd border;  ///< solution of the border
  Eigen::LDLT<MatrixXd> schur;
  bool sound = true;
};

BlockSolution solve_blocks(const NormalBlocks& b, double damping) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  BlockSolution s;
  std::vector<Columns> reduced;
  for (std::size_t k = 0; k < n; ++k) {
    Matrix12 d = b.diagonal[k];
    d.diagonal().head<3>() *= 1 + damping;
    d.diagonal().tail<kChainStates>() += damping * b.prior_weight;
    Columns r = b.columns[k];
    if (k > 0) {
      // Off-diagonal block: -W on the chain. Schur complement: D - E' P^-1 E, with E = (0; -W).
      const Matrix12 inverse = s.pivots[k - 1].solve(Matrix12::Identity());
      const auto w = b.link_weight.asDiagonal();
      d.bottomRightCorner<kChainStates, kChainStates>() -=
          w * inverse.bottomRightCorner<kChainStates, kChainStates>() * w;
      r.bottomRows<kChainStates>() += w * s.pivots[k - 1].solve(reduced[k - 1]).bottomRows<kChainStates>();
    }
    s.pivots.emplace_back(d);
    s.sound = s.sound && s.pivots.back().info() == Eigen::Success;
    reduced.push_back(r);
  }
  s.x.resize(n);
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    Columns r = reduced[k];
    if (back > 0) r.bottomRows<kChainStates>() += b.link_weight.asDiagonal() * s.x[k + 1].bottomRows<kChainStates>();
    s.x[k] = s.pivots[k].solve(r);
  }
  MatrixXd schur = b.border;
  schur.diagonal().array() += damping * b.border_scale;
  VectorXd rhs = b.border_rhs;
  for (std::size_t k = 0; k < n; ++k) {
    schur -= b.columns[k].rightCols(q).transpose() * s.x[k].rightCols(q);
    rhs -= b.columns[k].rightCols(q).transpose() * s.x[k].col(0);
  }
  s.border = VectorXd(0);
  if (q > 0) {
    s.schur.compute(schur);
    s.border = s.schur.solve(rhs);
  }
  return s;
}

/// Diagonal blocks of the inverse, last station first: S_k = D_k^-1 + G S_k+1 G', G = D_k^-1 (0; W), and what the
/// border adds.
void set_covariances(const NormalBlocks& b, const BlockSolution& s, ChainedSolution& out) {
  const std::size_t n = b.diagonal.size();
  const Index q = b.border.rows();
  if (q > 0) out.interference_covariance = s.schur.solve(MatrixXd::Identity(q, q));
  Matrix12 next;
  for (std::size_t back = 0; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    const Matrix12 inverse = s.pivots[k].solve(Matrix12::Identity());
    Matrix12 c = inverse;
    if (back > 0) {
      const Eigen::Matrix<double, 12, kChainStates> g = inverse.rightCols<kChainStates>() * b.link_weight.asDiagonal();
      c += g * next.bottomRightCorner<kChainStates, kChainStates>() * g.transpose();
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
};
Step step_of(const BlockSolution& s) {
  Step step;
  step.da = s.border;
  for (const Columns& x : s.x) {
    const Eigen::Matrix<double, 12, 1> own = x.col(0) - x.rightCols(step.da.size()) * step.da;
    step.delta.push_back(own.head<3>());
    step.dc.push_back(own.tail<kChainStates>());
  }
  return step;
}

}  // namespace

ChainedPoint basic_start(const ChainedModel& model, const ChainedReadings& readings, const StationSolver& solver) {
  ChainedPoint p;
  for (const StationReading& y : readings.y) p.frames.push_back(solver(y));
  p.chain.assign(readings.y.size(), ChainVector::Zero());
  p.interference = VectorXd::Zero(model.interference.states());
  return p;
}

ChainedSolution solve_chained(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& start,
                              const ChainedOptions& options) {
  check(model);
  ChainedSolution out;
  ChainedPoint at = start;
  at.interference.conservativeResize(model.interference.states());
  // Undamped as long as that goes down: damping would tilt a step into directions that only the prior holds, and the
  // valley of a free interference vector is curved.
  double cost = chained_cost(model, readings, at), damping = 0;
  const double tolerance2 = options.step_tolerance * options.step_tolerance;
  NormalBlocks blocks = normal_blocks(model, readings, at);
  while (out.iterations < options.max_iterations && !out.converged && std::isfinite(cost)) {
    ++out.iterations;
    const BlockSolution solution = solve_blocks(blocks, damping);
    const Step step = step_of(solution);
    const double size2 = step_size2(model, step.delta, step.dc, step.da);
    ChainedPoint next = at;
    for (int k = 0; k < readings.stations(); ++k)
      step_station(next, k, step.delta[static_cast<std::size_t>(k)], step.dc[static_cast<std::size_t>(k)]);
    next.interference += step.da;
    const double next_cost = chained_cost(model, readings, next);
    const bool near = size2 <= 1e-6 && damping == 0;  // so near that the cost differs by rounding only
    const double rounding = 1e-10 * (1 + cost);
    const bool accept =
        solution.sound && std::isfinite(size2) && (!options.damped || near || next_cost <= cost + rounding);
    if (!accept) {
      if (!options.damped) break;
      damping = std::max(10 * damping, 1e-2);
      if (damping > 1e12) break;
      continue;
    }
    out.converged = size2 <= tolerance2 && damping == 0;
    damping = damping > 1e-7 ? damping / 10 : 0;
    at = std::move(next);
    cost = next_cost;
    blocks = normal_blocks(model, readings, at);
  }
  out.cost = cost;
  out.interference = at.interference;
  for (std::size_t k = 0; k < at.frames.size(); ++k)
    out.stations.push_back({at.frames[k], at.chain[k], Matrix12::Zero()});
  const BlockSolution last = solve_blocks(blocks, 0);
  set_covariances(blocks, last, out);
  return out;
}

ChainedSolution solve_chained(const ChainedModel& model, const ChainedReadings& readings,
                              const ChainedOptions& options) {
  return solve_chained(model, readings, basic_start(model, readings), options);
}

}  // namespace surveymc
