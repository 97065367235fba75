#include "chained/smoother.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "base/error.h"
#include "stats/linear_algebra.h"

namespace surveymc::chained {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
// The chained states, followed by the amplitudes of interference: at most 12 states.
using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 12, 1>;
using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
using ByState = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 12>;

namespace {

constexpr int kFilterUndamped = 30;  // steps of Gauss-Newton at a station, as BatchOptions has them

struct Gaussian {
  State mean;
  Covariance covariance;
};

Gaussian first_prediction(const Model& m) {
  const Index q = m.interference.states();
  Gaussian g{State::Zero(kChainStates + q), Covariance::Zero(kChainStates + q, kChainStates + q)};
  for (Index i = 0; i < kChainStates; ++i) {
    const auto s = static_cast<std::size_t>(i);
    const double sd = m.independent() && i < kReferenceStates ? m.reference_sd[s] : m.prior_sd[s];
    g.covariance(i, i) = sd * sd;
  }
  for (Index i = 0; i < q; ++i)
    g.covariance(kChainStates + i, kChainStates + i) = m.interference.prior_sd * m.interference.prior_sd;
  return g;
}

/// 0 for references that are observed anew, 1 for all else: the diagonal of F.
State transition(const Model& m) {
  State f = State::Ones(kChainStates + m.interference.states());
  if (m.independent()) f.head<kReferenceStates>().setZero();
  return f;
}

Gaussian predicted(const Model& m, const Gaussian& g) {
  const State f = transition(m);
  Gaussian p{f.cwiseProduct(g.mean), f.asDiagonal() * g.covariance * f.asDiagonal()};
  for (Index i = 0; i < kChainStates; ++i) {
    const auto s = static_cast<std::size_t>(i);
    const double sd = m.independent() && i < kReferenceStates ? m.reference_sd[s] : m.link_sd[s];
    p.covariance(i, i) += sd * sd;
  }
  return p;
}

State state_at(const Point& at, int k) {
  State x(kChainStates + at.interference.size());
  x << at.chain[static_cast<std::size_t>(k)], at.interference;
  return x;
}

/// A station's equations, split into those of the chain alone and those that give the attitude.
struct Parted {
  StationLinear linear;
  ByState by_state;
  Eigen::Matrix<double, 6, 3> null;  ///< N
};
Parted parted(const Model& m, const Readings& readings, const Point& at, int k) {
  Parted p;
  p.linear = linearise(m, readings, at, k);
  p.by_state.resize(6, kChainStates + m.interference.states());
  p.by_state << p.linear.by_chain, p.linear.by_interference;
  p.null = stats::orthogonal_complement(p.linear.by_delta);
  return p;
}

Gaussian updated(const Parted& p, const State& linearised_at, const Gaussian& before) {
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12> h = p.null.transpose() * p.by_state;
  const Vector3d innovation = p.null.transpose() * p.linear.residual + h * (linearised_at - before.mean);
  const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 12, 3> ph = before.covariance * h.transpose();
  const Matrix3d s = h * ph + Matrix3d::Identity();
  const Eigen::LLT<Matrix3d> factor(s);
  Gaussian after{before.mean + ph * factor.solve(innovation), before.covariance - ph * factor.solve(ph.transpose())};
  after.covariance = ((after.covariance + after.covariance.transpose()) / 2).eval();
  return after;
}

/// delta = A^-1 by_delta' (e - by_state dx), A = by_delta' by_delta.
struct AttitudeGivenState {
  Matrix3d inverse;                                             ///< A^-1: covariance of delta if the states are known
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12> by_state;  ///< d delta / d x
  Vector3d delta;
};
AttitudeGivenState attitude_given(const Parted& p, const State& dx) {
  AttitudeGivenState a;
  const auto& j = p.linear.by_delta;
  a.inverse = Matrix3d(j.transpose() * j).inverse();
  a.by_state = -a.inverse * (j.transpose() * p.by_state);
  a.delta = a.inverse * (j.transpose() * p.linear.residual) + a.by_state * dx;
  return a;
}

Eigen::Matrix<double, 12, 12> joint_covariance(const AttitudeGivenState& a, const Covariance& states) {
  Eigen::Matrix<double, 12, 12> c;
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12> cross = a.by_state * states;
  c.topLeftCorner<3, 3>() = a.inverse + cross * a.by_state.transpose();
  c.topRightCorner<3, kChainStates>() = cross.leftCols<kChainStates>();
  c.bottomLeftCorner<kChainStates, 3>() = cross.leftCols<kChainStates>().transpose();
  c.bottomRightCorner<kChainStates, kChainStates>() = states.topLeftCorner<kChainStates, kChainStates>();
  return c;
}

/// Smoothed states of all stations, linearised at `at`.
struct Pass {
  std::vector<Parted> stations;
  std::vector<Gaussian> smoothed;
};
Pass pass(const Model& m, const Readings& readings, const Point& at) {
  const auto n = static_cast<std::size_t>(readings.stations());
  Pass out;
  std::vector<Gaussian> before, after;
  for (std::size_t k = 0; k < n; ++k) {
    out.stations.push_back(parted(m, readings, at, static_cast<int>(k)));
    before.push_back(k == 0 ? first_prediction(m) : predicted(m, after.back()));
    after.push_back(updated(out.stations[k], state_at(at, static_cast<int>(k)), before[k]));
  }
  out.smoothed = after;
  const State f = transition(m);
  for (std::size_t back = 1; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    // Gain P F' P(k+1|k)^-1, from the factor of the predicted covariance.
    const Covariance gain =
        stats::cholesky(before[k + 1].covariance).solve(f.asDiagonal() * after[k].covariance).transpose();
    Gaussian& s = out.smoothed[k];
    s.mean += gain * (out.smoothed[k + 1].mean - before[k + 1].mean);
    s.covariance += gain * (out.smoothed[k + 1].covariance - before[k + 1].covariance) * gain.transpose();
  }
  return out;
}

Point resized(const Model& m, Point p) {
  if (p.interference.size() != m.interference.states()) p.interference = VectorXd::Zero(m.interference.states());
  return p;
}

}  // namespace

Solution run_smoother(const Model& m, const Readings& readings, const Point& start, const Options& options) {
  check(m);
  require(readings.known.empty(), "chained smoother: known states: must be none, they are for solve_chained");
  Solution out;
  Point at = resized(m, start);
  const auto n = static_cast<std::size_t>(readings.stations());
  for (; out.iterations < options.max_iterations && !out.converged; ++out.iterations) {
    const Pass p = pass(m, readings, at);
    std::vector<Vector3d> delta;
    std::vector<ChainVector> dc;
    const VectorXd da = p.smoothed[0].mean.tail(at.interference.size()) - at.interference;
    for (std::size_t k = 0; k < n; ++k) {
      const State dx = p.smoothed[k].mean - state_at(at, static_cast<int>(k));
      delta.push_back(attitude_given(p.stations[k], dx).delta);
      dc.push_back(dx.head<kChainStates>());
    }
    const double size2 = step_size2(m, delta, dc, da);
    if (!std::isfinite(size2)) {
      out.status = Status::not_finite;
      break;
    }
    for (std::size_t k = 0; k < n; ++k) step_station(at, static_cast<int>(k), delta[k], dc[k]);
    at.interference += da;
    out.converged = size2 <= options.step_tolerance * options.step_tolerance;
  }
  if (out.converged) out.status = Status::converged;
  const Pass p = pass(m, readings, at);
  for (std::size_t k = 0; k < n; ++k)
    out.stations.push_back({at.frames[k], at.chain[k],
                            joint_covariance(attitude_given(p.stations[k], State::Zero(p.smoothed[k].mean.size())),
                                             p.smoothed[k].covariance)});
  const Index q = at.interference.size();
  out.interference = at.interference;
  out.interference_covariance = p.smoothed[0].covariance.bottomRightCorner(q, q);
  out.cost = chain_cost(m, readings, at);
  return out;
}

Solution run_filter(const Model& m, const Readings& readings, const Point& start, const Options& options) {
  check(m);
  require(m.interference.states() == 0, "chained filter: interference: must be none, it is for the smoother");
  require(readings.known.empty(), "chained filter: known states: must be none, they are for solve_chained");
  Solution out;
  const Point at_start = resized(m, start);
  Point at = at_start;
  out.status = Status::converged;
  Gaussian after;
  for (int k = 0; k < readings.stations(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Gaussian before = k == 0 ? first_prediction(m) : predicted(m, after);
    at.chain[i] = before.mean;
    bool converged = false;
    int it = 0;
    for (; it < std::min(options.max_iterations, kFilterUndamped) && !converged; ++it) {
      const Parted p = parted(m, readings, at, k);
      after = updated(p, at.chain[i], before);
      const ChainVector dc = after.mean - at.chain[i];
      const Vector3d delta = attitude_given(p, dc).delta;
      const double size2 = step_size2(m, {delta}, {dc}, at.interference);
      if (!std::isfinite(size2)) break;
      step_station(at, k, delta, dc);
      converged = size2 <= options.step_tolerance * options.step_tolerance;
    }
    if (!converged && options.damped) {  // from the start, not from the last point of Gauss-Newton
      const StationMinimum minimum =
          solve_station(m, readings, k, at_start.frames[i], before.mean, before.covariance, options);
      at.frames[i] = minimum.frame;
      at.chain[i] = minimum.chain;
      it += minimum.iterations;
      if (minimum.status != Status::converged && out.status == Status::converged) out.status = minimum.status;
    } else if (!converged && out.status == Status::converged) {
      out.status = Status::iteration_limit;
    }
    const Parted p = parted(m, readings, at, k);
    after = updated(p, at.chain[i], before);
    out.stations.push_back(
        {at.frames[i], at.chain[i], joint_covariance(attitude_given(p, State::Zero(kChainStates)), after.covariance)});
    const State pull = after.mean - before.mean;
    out.cost += p.linear.residual.squaredNorm() + pull.dot(VectorXd(stats::cholesky(before.covariance).solve(pull)));
    out.iterations = std::max(out.iterations, it);
  }
  out.converged = out.status == Status::converged;
  return out;
}

Solution run_smoother(const Model& model, const Readings& readings, const Options& options) {
  return run_smoother(model, readings, basic_start(model, readings), options);
}
Solution run_filter(const Model& model, const Readings& readings, const Options& options) {
  return run_filter(model, readings, basic_start(model, readings), options);
}

}  // namespace surveymc::chained
