#include "chained/smoother.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "base/error.h"
#include "stats/linear_algebra.h"
#include "stats/matrices.h"
#include "stats/small_matrix.h"

namespace surveymc::chained {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
// The chained states, followed by the amplitudes of interference: at most 12 states.
using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 12, 1>;
using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
using ByState = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 12>;
using AttitudeByState = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 12>;

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

/// F P, F diagonal.
Covariance carried_on(const State& f, Covariance p) {
  for (Index j = 0; j < p.cols(); ++j)
    for (Index i = 0; i < p.rows(); ++i) p(i, j) *= f[i];
  return p;
}

Gaussian predicted(const Model& m, const Gaussian& g) {
  const State f = transition(m);
  Gaussian p{f.cwiseProduct(g.mean), carried_on(f, g.covariance)};
  for (Index j = 0; j < f.size(); ++j)
    for (Index i = 0; i < f.size(); ++i) p.covariance(i, j) *= f[j];
  for (Index i = 0; i < kChainStates; ++i) {
    const auto s = static_cast<std::size_t>(i);
    const double sd = m.independent() && i < kReferenceStates ? m.reference_sd[s] : m.link_sd[s];
    p.covariance(i, i) += sd * sd;
  }
  return p;
}

State state_at(const Point& at, int k) {
  State x(kChainStates + at.interference.size());
  for (Index i = 0; i < kChainStates; ++i) x[i] = at.chain[static_cast<std::size_t>(k)][i];
  for (Index i = 0; i < at.interference.size(); ++i) x[kChainStates + i] = at.interference[i];
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
  p.by_state.leftCols<kChainStates>() = p.linear.by_chain;
  p.by_state.rightCols(m.interference.states()) = p.linear.by_interference;
  p.null = stats::orthogonal_complement(p.linear.by_delta);
  return p;
}

/// a' b.
AttitudeByState of_columns(const Eigen::Matrix<double, 6, 3>& a, const ByState& b) {
  AttitudeByState c(3, b.cols());
  for (Index j = 0; j < b.cols(); ++j)
    for (Index i = 0; i < 3; ++i) c(i, j) = dot6(&a(0, i), &b(0, j));
  return c;
}
Vector3d of_columns(const Eigen::Matrix<double, 6, 3>& a, const Eigen::Matrix<double, 6, 1>& b) {
  return {dot6(&a(0, 0), b.data()), dot6(&a(0, 1), b.data()), dot6(&a(0, 2), b.data())};
}

Vector3d times(const AttitudeByState& a, const State& x) {
  Vector3d sum = Vector3d::Zero();
  for (Index j = 0; j < x.size(); ++j)
    for (Index i = 0; i < 3; ++i) sum[i] += a(i, j) * x[j];
  return sum;
}

Gaussian updated(const Parted& p, const State& linearised_at, const Gaussian& before) {
  const Index n = before.mean.size();
  const AttitudeByState h = of_columns(p.null, p.by_state);
  AttitudeByState hp = AttitudeByState::Zero(3, n);  // H P
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      for (Index l = 0; l < 3; ++l) hp(l, i) += before.covariance(i, j) * h(l, j);
  const Vector3d innovation = of_columns(p.null, p.linear.residual) + times(h, linearised_at - before.mean);
  Matrix3d s = Matrix3d::Zero();
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < 3; ++j)
      for (Index l = 0; l < n; ++l) s(i, j) += h(i, l) * hp(j, l);
  for (Index i = 0; i < 3; ++i) s(i, i) += 1;
  const stats::SmallCholesky<3> factor(s);
  const Vector3d gained = factor.solve(innovation);
  AttitudeByState solved = hp;
  for (Index i = 0; i < n; ++i) factor.solve_row_in_place(&solved(0, i));
  Gaussian after = before;
  for (Index i = 0; i < n; ++i) {
    after.mean[i] += stats::dot_by_halves<3>(&hp(0, i), gained.data());
    for (Index j = 0; j < n; ++j)
      after.covariance(i, j) -= hp(0, i) * solved(0, j) + hp(1, i) * solved(1, j) + hp(2, i) * solved(2, j);
  }
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j <= i; ++j)
      after.covariance(i, j) = after.covariance(j, i) = (after.covariance(i, j) + after.covariance(j, i)) / 2;
  return after;
}

/// delta = A^-1 by_delta' (e - by_state dx), A = by_delta' by_delta.
struct AttitudeGivenState {
  Matrix3d inverse;          ///< A^-1: covariance of delta if the states are known
  AttitudeByState by_state;  ///< d delta / d x
  Vector3d delta;
};
AttitudeGivenState attitude_given(const Parted& p, const State& dx) {
  AttitudeGivenState a;
  const auto& j = p.linear.by_delta;
  Matrix3d normal;
  for (Index i = 0; i < 3; ++i)
    for (Index l = 0; l < 3; ++l) normal(i, l) = dot6(&j(0, i), &j(0, l));
  a.inverse = normal.inverse();
  a.by_state = of_columns(j, p.by_state);
  for (Index i = 0; i < a.by_state.cols(); ++i)
    a.by_state.col(i) = -stats::product_by_halves(a.inverse, Vector3d(a.by_state.col(i)));
  a.delta = stats::product_by_halves(a.inverse, of_columns(j, p.linear.residual)) + times(a.by_state, dx);
  return a;
}

Eigen::Matrix<double, 12, 12> joint_covariance(const AttitudeGivenState& a, const Covariance& states) {
  Eigen::Matrix<double, 12, 12> c;
  const Index n = states.rows();
  AttitudeByState cross(3, n);
  stats::set_product(a.by_state, states, cross);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      double sum = 0;
      for (Index l = 0; l < n; ++l) sum += cross(i, l) * a.by_state(j, l);
      c(i, j) = a.inverse(i, j) + sum;
    }
    for (Index j = 0; j < kChainStates; ++j) c(i, 3 + j) = c(3 + j, i) = cross(i, j);
  }
  for (Index i = 0; i < kChainStates; ++i)
    for (Index j = 0; j < kChainStates; ++j) c(3 + i, 3 + j) = states(i, j);
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
  const Index states = f.size();
  Covariance more, by_more(states, states), from_next(states, states);
  for (std::size_t back = 1; back < n; ++back) {
    const std::size_t k = n - 1 - back;
    // Gain P F' P(k+1|k)^-1, from the factor of the predicted covariance.
    const Covariance gain =
        stats::cholesky(before[k + 1].covariance).solve(carried_on(f, after[k].covariance)).transpose();
    Gaussian& s = out.smoothed[k];
    const State away = out.smoothed[k + 1].mean - before[k + 1].mean;
    for (Index i = 0; i < states; ++i) {
      double sum = 0;
      for (Index j = 0; j < states; ++j) sum += gain(i, j) * away[j];
      s.mean[i] += sum;
    }
    more = out.smoothed[k + 1].covariance - before[k + 1].covariance;
    stats::set_product(gain, more, by_more);
    stats::set_product(gain, Covariance(by_more.transpose()), from_next);
    s.covariance += from_next.transpose();
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
