#include "reliability/minimum.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "stats/descent.h"
#include "stats/linear_algebra.h"

namespace surveymc::reliability {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3d turn(const Vector3d& phi) {
  const double angle = phi.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
}

/// Columns north, east, down in the tool frame. Where the field is parallel to gravity, any north.
Matrix3d directions_of(const std::array<double, kReadings>& y) {
  const Vector3d u = Vector3d(y[0], y[1], y[2]).normalized(), b(y[3], y[4], y[5]);
  const Vector3d across = b - u.dot(b) * u;
  const Vector3d n = across.norm() > 0 ? Vector3d(across.normalized()) : Vector3d(u.unitOrthogonal());
  Matrix3d f;
  f << n, u.cross(n), u;
  return f;
}

constexpr Index kOwn = 4;          // unknowns that turn one station: a small vector, and the angle between shots
constexpr Index kMostShared = 15;  // G, B, Theta, biases, scale factors

struct Problem {
  const StationReadings& y;
  Index stations, width = 0, turns = 0;  // width: of z; turns: unknowns that are no part of z, which come first
  bool rotational = false;
  double digits = 1e-14;  // rounding of a residual, in sd
  VectorXd weight;        // 1 / sd, 0 where an observation is left out; then the elements of zeta
  MatrixXd spread;        // S of z = z_0 + S zeta, S S' = Cov(z_0)

  bool systematic() const { return width > 3; }
};

struct State {
  std::vector<Matrix3d> frames;
  std::vector<double> turned;  // rotational shot: about the tool's z axis, from the first shot
  VectorXd zeta;
};

/// Residuals of one station by the unknowns that turn it, and by zeta. Plain numbers: products of blocks of matrices
/// would take a compiler longer than all else in this file.
using Row = std::array<double, kOwn + kMostShared>;
struct StationRows {
  std::array<Row, kReadings> rows;
  std::array<Index, kOwn> own;  // their unknowns; -1: none
};

struct Linear {
  double omega = 0;
  VectorXd residual;
  std::vector<StationRows> stations;
  MatrixXd squares, hessian;  // J'J; of Omega / 2
  VectorXd gradient, column_size;
};

Problem problem_of(const AdjustmentModel& model, const StationReadings& y, const VectorXd& variances,
                   const std::vector<Index>& out, const std::optional<MatrixXd>& covariance) {
  Problem p{.y = y, .stations = static_cast<Index>(y.readings.size()), .weight = {}, .spread = {}};
  const bool shared = model.mode == AdjustmentMode::mse_shared;
  p.rotational = shared && model.rotational_shot;
  p.width = model.mode == AdjustmentMode::mse_fixed ? 0 : shared && model.systematic_terms ? kMostShared : 3;
  p.turns = p.rotational ? 3 + p.stations - 1 : 3 * p.stations;
  const Index refs = 6 * p.stations, width = p.width;
  p.weight = VectorXd::Ones(refs + width);
  for (Index i = 0; i < refs; ++i) p.weight[i] = 1 / std::sqrt(variances[i]);
  p.spread = MatrixXd::Zero(width, width);
  if (covariance) {
    // In units of the sd first: G, B and Theta differ by many powers of ten
    const VectorXd sd = covariance->diagonal().cwiseSqrt();
    MatrixXd unit = MatrixXd::Identity(width, width);
    for (Index i = 0; i < width; ++i)
      for (Index j = 0; j < width; ++j)
        if (i != j && sd[i] > 0 && sd[j] > 0) unit(i, j) = (*covariance)(i, j) / (sd[i] * sd[j]);
    p.spread = sd.asDiagonal() * stats::cholesky(unit).lower();
  } else {
    for (Index i = 0; i < width; ++i) p.spread(i, i) = std::sqrt(variances[refs + i]);
  }
  for (const Index k : out) p.weight[k] = 0;
  for (Index i = 0; i < refs; ++i) {
    const double reading = y.readings[static_cast<std::size_t>(i / 6)][static_cast<std::size_t>(i % 6)];
    p.digits = std::max(p.digits, std::abs(reading) * p.weight[i] * std::numeric_limits<double>::epsilon());
  }
  return p;
}

void turn_shots(State& s) {
  for (std::size_t k = 1; k < s.frames.size(); ++k) s.frames[k] = turn(Vector3d(0, 0, s.turned[k])) * s.frames[0];
}

State start_of(const Problem& p) {
  State s;
  for (const auto& readings : p.y.readings) s.frames.push_back(directions_of(readings));
  s.zeta = VectorXd::Zero(p.width);
  if (p.rotational) {
    for (std::size_t k = 0; k < s.frames.size(); ++k) {
      const Matrix3d r = s.frames[k] * s.frames[0].transpose();
      s.turned.push_back(k == 0 ? 0 : std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1)));
    }
    turn_shots(s);
  }
  return s;
}

State moved_by(const Problem& p, const State& from, const VectorXd& step) {
  State s = from;
  const auto vector = [&](Index at) { return Vector3d(step[at], step[at + 1], step[at + 2]); };
  if (p.rotational) {
    s.frames[0] = turn(vector(0)) * from.frames[0];
    for (std::size_t k = 1; k < s.frames.size(); ++k) s.turned[k] += step[2 + static_cast<Index>(k)];
    turn_shots(s);
  } else {
    for (std::size_t k = 0; k < s.frames.size(); ++k)
      s.frames[k] = turn(vector(3 * static_cast<Index>(k))) * from.frames[k];
  }
  s.zeta += step.tail(p.width);
  return s;
}

/// z, or (G, B, Theta) that are free of error
std::array<double, kMostShared> shared_at(const Problem& p, const State& s) {
  std::array<double, kMostShared> z{};
  for (std::size_t j = 0; j < 3; ++j) z[j] = p.y.references[j];
  for (Index i = 0; i < p.width; ++i)
    for (Index j = 0; j < p.width; ++j) z[static_cast<std::size_t>(i)] += p.spread(i, j) * s.zeta[j];
  return z;
}

Observations readings_at(const Problem& p, const Matrix3d& f, const std::array<double, kMostShared>& z) {
  const double cosine = std::cos(z[2]), sine = std::sin(z[2]);
  Observations t{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Index>(i);
    t[i] = z[0] * f(row, 2);
    t[3 + i] = z[1] * (cosine * f(row, 0) + sine * f(row, 2));
  }
  if (p.systematic())
    for (std::size_t i = 0; i < 6; ++i) t[i] = (t[i] + z[3 + i]) / (1 - z[9 + i]);
  return t;
}

VectorXd residuals_at(const Problem& p, const State& s) {
  const auto z = shared_at(p, s);
  VectorXd r(p.weight.size());
  for (Index k = 0; k < p.stations; ++k) {
    const auto& y = p.y.readings[static_cast<std::size_t>(k)];
    const Observations readings = readings_at(p, s.frames[static_cast<std::size_t>(k)], z);
    for (Index i = 0; i < 6; ++i) {
      const auto c = static_cast<std::size_t>(i);
      r[6 * k + i] = p.weight[6 * k + i] * (y[c] - readings[c]);
    }
  }
  for (Index j = 6 * p.stations; j < r.size(); ++j) r[j] = -p.weight[j] * s.zeta[j - 6 * p.stations];
  return r;
}

double omega_at(const Problem& p, const State& s) { return residuals_at(p, s).squaredNorm(); }

VectorXd adjusted_at(const Problem& p, const State& s) {
  const auto z = shared_at(p, s);
  VectorXd a(6 * p.stations + p.width);
  for (Index k = 0; k < p.stations; ++k) {
    const Observations readings = readings_at(p, s.frames[static_cast<std::size_t>(k)], z);
    for (Index i = 0; i < 6; ++i) a[6 * k + i] = readings[static_cast<std::size_t>(i)];
  }
  for (Index j = 0; j < p.width; ++j) a[6 * p.stations + j] = z[static_cast<std::size_t>(j)];
  return a;
}

/// Calls use(c, unknown) with the places in a row of station `s` and the unknowns that they belong to.
template <class Use>
void of_row(const Problem& p, const StationRows& s, const Use& use) {
  for (std::size_t c = 0; c < kOwn; ++c)
    if (s.own[c] >= 0) use(c, s.own[c]);
  for (Index j = 0; j < p.width; ++j) use(static_cast<std::size_t>(kOwn + j), p.turns + j);
}

/// Derivatives of the residuals of station `k`. Adds their second derivatives, times the residuals, to `second`.
StationRows linearise_station(const Problem& p, const State& s, const std::array<double, kMostShared>& z, Index k,
                              const VectorXd& residual, MatrixXd& second) {
  const double sine = std::sin(z[2]), cosine = std::cos(z[2]);
  const Matrix3d& f = s.frames[static_cast<std::size_t>(k)];
  const Vector3d u = f.col(2), h = cosine * f.col(0) + sine * u, m = cosine * u - sine * f.col(0);
  const Vector3d g = z[0] * u, b = z[1] * h;
  std::array<double, kReadings> gain, rho;
  for (std::size_t i = 0; i < kReadings; ++i) {
    const Index row = 6 * k + static_cast<Index>(i);
    gain[i] = p.systematic() ? 1 / (1 - z[9 + i]) : 1;
    rho[i] = p.weight[row] * gain[i] * residual[row];
  }
  const Vector3d rg(rho[0], rho[1], rho[2]), rb(rho[3], rho[4], rho[5]);
  Matrix3d turn_turn = -(rg.dot(g) + rb.dot(b)) * Matrix3d::Identity();
  turn_turn += (rg * g.transpose() + g * rg.transpose() + rb * b.transpose() + b * rb.transpose()) / 2;
  Matrix3d turn_reference, reference_reference = Matrix3d::Zero();
  turn_reference << u.cross(rg), h.cross(rb), z[1] * m.cross(rb);
  reference_reference(1, 2) = reference_reference(2, 1) = rb.dot(m);
  reference_reference(2, 2) = -rb.dot(b);

  // The small vector that turns the station, by the unknowns (columns); the angle of a later shot is about its z axis
  std::array<Vector3d, kOwn> chain{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::Zero()};
  StationRows r{};
  r.own = {3 * k, 3 * k + 1, 3 * k + 2, -1};
  if (p.rotational) {
    r.own = {0, 1, 2, k > 0 ? 2 + k : -1};
    if (k > 0) {
      const Matrix3d of_first = turn(Vector3d(0, 0, s.turned[static_cast<std::size_t>(k)]));
      chain = {of_first.col(0), of_first.col(1), of_first.col(2), Vector3d::UnitZ()};
    }
  }
  const Observations readings = readings_at(p, f, z);
  for (std::size_t i = 0; i < kReadings; ++i) {
    const std::size_t axis = i % 3;
    const auto row = static_cast<Index>(axis);
    const double w = p.weight[6 * k + static_cast<Index>(i)];
    for (std::size_t c = 0; c < kOwn; ++c) r.rows[i][c] = w * gain[i] * chain[c].cross(i < 3 ? g : b)[row];
    std::array<double, kMostShared> by_z{};  // of the reading
    if (i < 3) {
      by_z[0] = gain[i] * u[row];
    } else {
      by_z[1] = gain[i] * h[row];
      by_z[2] = gain[i] * z[1] * m[row];
    }
    if (p.systematic()) {
      by_z[3 + i] = gain[i];
      by_z[9 + i] = gain[i] * readings[i];
    }
    for (Index j = 0; j < p.width; ++j) {
      double sum = 0;
      for (Index l = 0; l < p.width; ++l) sum += by_z[static_cast<std::size_t>(l)] * p.spread(l, j);
      r.rows[i][static_cast<std::size_t>(kOwn + j)] = w * sum;
    }
  }
  for (std::size_t c = 0; c < kOwn; ++c) {
    if (r.own[c] < 0) continue;
    const Vector3d turned = turn_turn * chain[c];
    for (std::size_t d = 0; d < kOwn; ++d)
      if (r.own[d] >= 0) second(r.own[d], r.own[c]) += chain[d].dot(turned);
    for (Index j = 0; j < p.width; ++j) {
      double mixed = 0;
      for (Index l = 0; l < 3; ++l) mixed += chain[c].dot(turn_reference.col(l)) * p.spread(l, j);
      second(r.own[c], p.turns + j) += mixed;
      second(p.turns + j, r.own[c]) += mixed;
    }
  }
  for (Index i = 0; i < p.width; ++i)
    for (Index j = 0; j < p.width; ++j) {
      double sum = 0;
      for (Index l = 1; l < 3; ++l)
        for (Index n = 1; n < 3; ++n) sum += p.spread(l, i) * reference_reference(l, n) * p.spread(n, j);
      second(p.turns + i, p.turns + j) += sum;
    }
  return r;
}

Linear linearise(const Problem& p, const State& s) {
  const auto z = shared_at(p, s);
  const Index unknowns = p.turns + p.width;
  Linear l;
  l.residual = residuals_at(p, s);
  l.omega = l.residual.squaredNorm();
  l.gradient = l.column_size = VectorXd::Zero(unknowns);
  MatrixXd second = MatrixXd::Zero(unknowns, unknowns);
  l.squares = second;
  for (Index k = 0; k < p.stations; ++k) {
    l.stations.push_back(linearise_station(p, s, z, k, l.residual, second));
    const StationRows& station = l.stations.back();
    for (std::size_t i = 0; i < kReadings; ++i) {
      const Row& row = station.rows[i];
      const double residual = l.residual[6 * k + static_cast<Index>(i)];
      of_row(p, station, [&](std::size_t c, Index unknown) {
        l.gradient[unknown] += row[c] * residual;  // down the slope of Omega / 2
        of_row(p, station, [&](std::size_t d, Index other) { l.squares(other, unknown) += row[c] * row[d]; });
      });
    }
  }
  for (Index j = 0; j < p.width; ++j) {
    const double weight = p.weight[6 * p.stations + j];
    l.gradient[p.turns + j] += weight * l.residual[6 * p.stations + j];
    l.squares(p.turns + j, p.turns + j) += weight * weight;
  }
  l.column_size = l.squares.diagonal().cwiseSqrt();
  l.hessian = l.squares - second;
  return l;
}

/// Most that a step moves an observation, in sd.
double largest_move(const Problem& p, const Linear& l, const VectorXd& step) {
  double most = 0;
  for (const StationRows& station : l.stations)
    for (const Row& row : station.rows) {
      double moved = 0;
      of_row(p, station, [&](std::size_t c, Index unknown) { moved += row[c] * step[unknown]; });
      most = std::max(most, std::abs(moved));
    }
  for (Index j = 0; j < p.width; ++j) most = std::max(most, std::abs(p.weight[6 * p.stations + j] * step[p.turns + j]));
  return most;
}

/// 1 / |column of J|: unknowns of which one unit moves the observations by one sd.
VectorXd scale_of(const Linear& l) { return l.column_size.cwiseMax(1e-8 * l.column_size.maxCoeff()).cwiseInverse(); }

MatrixXd with_diagonal(MatrixXd h, double more) {
  h.diagonal().array() += more;
  return h;
}

/// The adjustment as a problem of stats/descent.h, in units of which each moves the observations by one sd.
class OmegaProblem {
 public:
  using Scalar = double;

  OmegaProblem(const Problem& p, State start) : p_(p), at_(std::move(start)), next_(at_) {}

  const State& at() const { return at_; }
  double cost() { return linear().omega; }
  stats::DescentStep<double, bool> solve(bool curved, double damping) {
    const Linear& l = linear();
    const VectorXd scale = scale_of(l), gradient = scale.cwiseProduct(l.gradient);
    const stats::Cholesky factor = factor_of(curved ? l.hessian : l.squares, scale, damping, !curved);
    step_ = VectorXd::Zero(gradient.size());
    if (!factor.positive_definite()) return {false, 0, 0};
    const VectorXd d = factor.solve(gradient);
    step_ = scale.cwiseProduct(d);
    const double size = largest_move(p_, l, step_);
    return {true, d.dot(gradient) + damping * d.squaredNorm(), size * size};
  }
  double try_step() {
    next_ = moved_by(p_, at_, step_);
    return omega_at(p_, next_);
  }
  void take(bool where) {
    if (!where) return;
    std::swap(at_, next_);
    linear_.reset();
  }
  double rounding(double omega) const { return 8 * p_.digits * (1 + std::sqrt(omega)); }

  /// A state with a lower Omega where the stationary point has a direction of negative curvature.
  std::optional<State> beside_saddle() {
    constexpr double kLeast = 1e-7;  // curvature per sd and sd; J'J has 1
    const Linear& l = linear();
    const VectorXd scale = scale_of(l);
    const MatrixXd h = scale.asDiagonal() * l.hessian * scale.asDiagonal();
    if (stats::cholesky(with_diagonal(h, kLeast)).positive_definite()) return {};
    const VectorXd along = scale.cwiseProduct(VectorXd(stats::symmetric_eigen(h).vectors.col(0)));
    // Down to steps so small even where one unit of `along` is many turns: an unknown that no observation shows
    for (double size = 1; size > 1e-11; size /= 4) {
      const State right = moved_by(p_, at_, size * along), left = moved_by(p_, at_, -size * along);
      const double of_right = omega_at(p_, right), of_left = omega_at(p_, left);
      if (std::min(of_right, of_left) < l.omega - rounding(l.omega))
        return of_right <= of_left + rounding(l.omega) ? right : left;
    }
    return {};
  }

 private:
  /// Of J'J or of the Hessian, scaled and damped. J'J is singular, to rounding, where a bz that is left out does not
  /// enter the observations to first order (horizontal, east or west). A little damping then keeps the steps finite, so
  /// that the descent ends, if need be at a saddle.
  static stats::Cholesky factor_of(const MatrixXd& a, const VectorXd& scale, double damping, bool is_square) {
    constexpr double kLeastPivot = 1e-12, kLittle = 1e-10;  // J'J has 1 on its diagonal
    const MatrixXd of_scaled = scale.asDiagonal() * a * scale.asDiagonal();
    const stats::Cholesky factor = stats::cholesky(with_diagonal(of_scaled, damping));
    if (!is_square || (factor.positive_definite() && factor.lower().diagonal().minCoeff() > std::sqrt(kLeastPivot)))
      return factor;
    return stats::cholesky(with_diagonal(of_scaled, damping + kLittle));
  }

  const Linear& linear() {
    if (!linear_) linear_ = linearise(p_, at_);
    return *linear_;
  }

  const Problem& p_;
  State at_, next_;
  std::optional<Linear> linear_;  // at at_
  VectorXd step_;
};

Minimum minimum_of(const Problem& p) {
  stats::DescentOptions options;
  options.max_iterations = 300;
  options.step_tolerance = 1e-7;
  Minimum m;
  State from = start_of(p);
  for (;;) {
    OmegaProblem problem(p, std::move(from));
    const stats::DescentEnd<double> end = stats::descend(problem, options);
    const auto status = static_cast<stats::DescentStatus>(end.status);
    m.steps += static_cast<int>(end.iterations);
    m.omega = end.cost;
    m.adjusted = adjusted_at(p, problem.at());
    if (status != stats::DescentStatus::converged && status != stats::DescentStatus::saddle) return m;
    const std::optional<State> lower = problem.beside_saddle();
    m.converged = !lower;
    options.max_iterations -= static_cast<int>(end.iterations);
    if (m.converged || options.max_iterations <= 0) return m;
    from = *lower;
  }
}

}  // namespace

Minimum minimum_of_omega(const AdjustmentModel& model, const StationReadings& y, const VectorXd& variances,
                         const std::vector<Index>& left_out, const std::optional<MatrixXd>& shared_covariance) {
  std::vector<Index> out = left_out;
  const auto bz = static_cast<Index>(index_of(Observation::bz));
  if (model.mode == AdjustmentMode::sse_axial && std::find(out.begin(), out.end(), bz) == out.end()) out.push_back(bz);
  return minimum_of(problem_of(model, y, variances, out, shared_covariance));
}

}  // namespace surveymc::reliability
