#include "reliability/levenberg.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "stats/linear_algebra.h"
#include "survey/frames.h"

namespace surveymc::reliability {
namespace {

using Eigen::Dynamic;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, kReadings, 1>;
using Matrix63 = Eigen::Matrix<double, kReadings, 3>;

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

/// kRows, kColumns: most residuals and unknowns, which keeps a single station on the stack; Dynamic: any number.
template <int kRows, int kColumns>
class Descent {
  using Rows = Eigen::Matrix<double, Dynamic, 1, 0, kRows, 1>;
  using Columns = Eigen::Matrix<double, Dynamic, 1, 0, kColumns, 1>;
  using Jacobian = Eigen::Matrix<double, Dynamic, Dynamic, 0, kRows, kColumns>;
  using Square = Eigen::Matrix<double, Dynamic, Dynamic, 0, kColumns, kColumns>;
  static constexpr int kMostShared = 15;
  using Shared = Eigen::Matrix<double, Dynamic, 1, 0, kMostShared, 1>;
  using SharedSquare = Eigen::Matrix<double, Dynamic, Dynamic, 0, kMostShared, kMostShared>;

  struct State {
    std::vector<Matrix3d> frames;
    std::vector<double> turned;  // rotational shot: about the tool's z axis, from the first shot
    Shared zeta;                 // z = z_0 + S zeta, S S' = Cov(z_0)
  };
  struct Linear {
    double omega = 0;
    Rows residual;
    Jacobian jacobian;
    Square hessian;  // of Omega / 2
    Columns gradient;
  };

 public:
  Descent(const AdjustmentModel& model, const StationReadings& y, const VectorXd& variances,
          const std::vector<Index>& out, const std::optional<MatrixXd>& covariance)
      : y_(y), stations_(static_cast<Index>(y.readings.size())) {
    const bool shared = model.mode == AdjustmentMode::mse_shared;
    rotational_ = shared && model.rotational_shot;
    width_ = model.mode == AdjustmentMode::mse_fixed ? 0 : shared && model.systematic_terms ? 15 : 3;
    const Index refs = 6 * stations_;
    weight_ = Rows::Zero(refs + width_);
    for (Index i = 0; i < refs; ++i) weight_[i] = 1 / std::sqrt(variances[i]);
    weight_.tail(width_).setOnes();
    spread_ = SharedSquare::Zero(width_, width_);
    if (covariance) {
      // In units of the sd first: G, B and Theta differ by many powers of ten
      const VectorXd sd = covariance->diagonal().cwiseSqrt();
      MatrixXd unit = MatrixXd::Identity(width_, width_);
      for (Index i = 0; i < width_; ++i)
        for (Index j = 0; j < width_; ++j)
          if (i != j && sd[i] > 0 && sd[j] > 0) unit(i, j) = (*covariance)(i, j) / (sd[i] * sd[j]);
      spread_ = sd.asDiagonal() * stats::cholesky(unit).lower();
    } else {
      for (Index i = 0; i < width_; ++i) spread_(i, i) = std::sqrt(variances[refs + i]);
    }
    for (const Index k : out) weight_[k] = 0;
    for (Index i = 0; i < refs; ++i)
      digits_ =
          std::max(digits_, std::abs(y.readings[static_cast<std::size_t>(i / 6)][static_cast<std::size_t>(i % 6)]) *
                                weight_[i] * std::numeric_limits<double>::epsilon());
    turns_ = rotational_ ? 3 + stations_ - 1 : 3 * stations_;
  }

  Minimum run() const {
    constexpr int kMost = 300;
    constexpr double kGradient = 1e-8, kStep = 1e-7;
    Minimum m;
    State at = start();
    Linear l = linearise(at);
    double mu = 1e-4, growth = 2;
    for (m.steps = 1; m.steps <= kMost; ++m.steps) {
      const Columns scale = scale_of(l);
      const Square h = scale.asDiagonal() * l.hessian * scale.asDiagonal();
      const Columns gradient = scale.cwiseProduct(l.gradient);
      if (!std::isfinite(l.omega) || !gradient.allFinite()) break;
      const Eigen::LLT<Square> factor(h + mu * Square::Identity(h.rows(), h.cols()));
      if (factor.info() != Eigen::Success) {  // negative curvature that mu does not outweigh yet
        mu = std::max(4 * mu, 1e-3);
        continue;
      }
      const Columns scaled = factor.solve(gradient), step = scale.cwiseProduct(scaled);
      const double moved = (l.jacobian * step).cwiseAbs().maxCoeff();
      if (gradient.cwiseAbs().maxCoeff() <= kGradient && (moved <= kStep || mu > 1)) {
        const std::optional<State> lower = beside_saddle(at, l, h, scale);
        if (!lower) {
          m.converged = true;
          break;
        }
        at = *lower;
        l = linearise(at);
        mu = 1e-4;
        continue;
      }
      const State next = moved_by(at, step);
      const double omega = omega_at(next);
      // Omega falls by step'(2 gradient - H step) in the quadratic model of 2 (Omega / 2)
      const double promised = scaled.dot(2 * gradient - h * scaled), fallen = l.omega - omega;
      const double rounding = 8 * digits_ * (1 + std::sqrt(l.omega));
      const bool flat = std::abs(promised) <= rounding && std::abs(fallen) <= rounding;
      if (flat || fallen > 1e-4 * promised) {
        const double ratio = flat ? 1 : fallen / promised;
        mu *= std::max(0.1, 1 - std::pow(2 * ratio - 1, 3));
        growth = 2;
        at = next;
        l = linearise(at);
      } else {
        mu = std::max(mu, 1e-6) * growth;
        growth *= 2;
        if (mu > 1e16) break;
      }
    }
    m.omega = l.omega;
    m.adjusted = adjusted_at(at);
    return m;
  }

 private:
  bool systematic() const { return width_ > 3; }

  State start() const {
    State s;
    for (const auto& readings : y_.readings) s.frames.push_back(directions_of(readings));
    s.zeta = Shared::Zero(width_);
    if (rotational_) {
      for (Index k = 0; k < stations_; ++k) {
        const Matrix3d r = s.frames[static_cast<std::size_t>(k)] * s.frames[0].transpose();
        s.turned.push_back(k == 0 ? 0 : std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1)));
      }
      turn_shots(s);
    }
    return s;
  }
  void turn_shots(State& s) const {
    for (std::size_t k = 1; k < s.frames.size(); ++k) s.frames[k] = turn(Vector3d(0, 0, s.turned[k])) * s.frames[0];
  }
  State moved_by(const State& from, const Columns& step) const {
    State s = from;
    if (rotational_) {
      s.frames[0] = turn(step.template head<3>()) * from.frames[0];
      for (std::size_t k = 1; k < s.frames.size(); ++k) s.turned[k] += step[2 + static_cast<Index>(k)];
      turn_shots(s);
    } else {
      for (std::size_t k = 0; k < s.frames.size(); ++k)
        s.frames[k] = turn(step.template segment<3>(3 * static_cast<Index>(k))) * from.frames[k];
    }
    s.zeta += step.tail(width_);
    return s;
  }

  /// z, or (G, B, Theta) that are free of error
  Shared shared_at(const State& s) const {
    Shared z = Shared::Zero(std::max<Index>(width_, 3));
    for (Index j = 0; j < 3; ++j) z[j] = y_.references[static_cast<std::size_t>(j)];
    z.head(width_) += spread_ * s.zeta;
    return z;
  }
  Vector6 readings_at(const Matrix3d& f, const Shared& z) const {
    Vector6 t;
    t << z[0] * f.col(2), z[1] * (std::cos(z[2]) * f.col(0) + std::sin(z[2]) * f.col(2));
    if (systematic())
      for (Index i = 0; i < 6; ++i) t[i] = (t[i] + z[3 + i]) / (1 - z[9 + i]);
    return t;
  }
  Rows residuals_at(const State& s) const {
    const Shared z = shared_at(s);
    Rows r(weight_.size());
    for (Index k = 0; k < stations_; ++k) {
      const auto& y = y_.readings[static_cast<std::size_t>(k)];
      const Vector6 readings = readings_at(s.frames[static_cast<std::size_t>(k)], z);
      for (Index i = 0; i < 6; ++i) r[6 * k + i] = weight_[6 * k + i] * (y[static_cast<std::size_t>(i)] - readings[i]);
    }
    for (Index j = 0; j < width_; ++j) r[6 * stations_ + j] = -weight_[6 * stations_ + j] * s.zeta[j];
    return r;
  }
  double omega_at(const State& s) const { return residuals_at(s).squaredNorm(); }

  VectorXd adjusted_at(const State& s) const {
    const Shared z = shared_at(s);
    VectorXd a(6 * stations_ + width_);
    for (Index k = 0; k < stations_; ++k) a.segment<6>(6 * k) = readings_at(s.frames[static_cast<std::size_t>(k)], z);
    a.tail(width_) = z.head(width_);
    return a;
  }

  Linear linearise(const State& s) const {
    const Shared z = shared_at(s);
    const Index unknowns = turns_ + width_;
    Linear l;
    l.residual = residuals_at(s);
    l.omega = l.residual.squaredNorm();
    l.jacobian = Jacobian::Zero(weight_.size(), unknowns);
    Square second = Square::Zero(unknowns, unknowns);  // sum of residuals times second derivatives
    const double sine = std::sin(z[2]), cosine = std::cos(z[2]);
    for (Index k = 0; k < stations_; ++k) {
      const Matrix3d& f = s.frames[static_cast<std::size_t>(k)];
      const Vector3d u = f.col(2), h = cosine * f.col(0) + sine * u, m = cosine * u - sine * f.col(0);
      const Vector3d g = z[0] * u, b = z[1] * h;
      Matrix63 by_turn;
      by_turn << -survey::cross_matrix(g), -survey::cross_matrix(b);  // phi x v
      Matrix63 by_reference = Matrix63::Zero();
      by_reference.col(0).head<3>() = u;
      by_reference.col(1).tail<3>() = h;
      by_reference.col(2).tail<3>() = z[1] * m;
      const Vector6 w = weight_.template segment<6>(6 * k);
      Vector6 gain = Vector6::Ones();
      if (systematic()) gain = (1 - z.template segment<6>(9).array()).inverse();
      const Vector6 rho = w.cwiseProduct(gain).cwiseProduct(l.residual.template segment<6>(6 * k));
      const Vector3d rg = rho.head<3>(), rb = rho.tail<3>();

      Matrix3d turn_turn = -(rg.dot(g) + rb.dot(b)) * Matrix3d::Identity();
      turn_turn += (rg * g.transpose() + g * rg.transpose() + rb * b.transpose() + b * rb.transpose()) / 2;
      Matrix3d turn_reference, reference_reference = Matrix3d::Zero();
      turn_reference << u.cross(rg), h.cross(rb), z[1] * m.cross(rb);
      reference_reference(1, 2) = reference_reference(2, 1) = rb.dot(m);
      reference_reference(2, 2) = -rb.dot(b);

      // By the unknowns that turn this station
      Eigen::Matrix<double, 3, Dynamic, 0, 3, 4> chain = Matrix3d::Identity();
      Index at = 3 * k, extra = -1;
      if (rotational_) {
        at = 0;
        if (k > 0) {
          extra = 2 + k;
          chain.resize(3, 4);
          chain << turn(Vector3d(0, 0, s.turned[static_cast<std::size_t>(k)])), Vector3d::UnitZ();
        }
      }
      const auto weighted = w.cwiseProduct(gain).asDiagonal();
      const Eigen::Matrix<double, 6, Dynamic, 0, 6, 4> own = weighted * by_turn * chain;
      l.jacobian.template block<6, 3>(6 * k, at) = own.template leftCols<3>();
      const Eigen::Matrix<double, Dynamic, Dynamic, 0, 4, 4> own_second = chain.transpose() * turn_turn * chain;
      second.template block<3, 3>(at, at) += own_second.template topLeftCorner<3, 3>();
      if (extra >= 0) {
        l.jacobian.template block<6, 1>(6 * k, extra) = own.col(3);
        second(extra, extra) += own_second(3, 3);
        second.template block<3, 1>(at, extra) += own_second.template block<3, 1>(0, 3);
        second.template block<1, 3>(extra, at) += own_second.template block<1, 3>(3, 0);
      }
      if (width_ == 0) continue;
      Eigen::Matrix<double, 6, Dynamic, 0, 6, kMostShared> by_shared(6, width_);
      by_shared.template leftCols<3>() = gain.asDiagonal() * by_reference;
      if (systematic()) {
        by_shared.template middleCols<6>(3) = Matrix6(gain.asDiagonal());
        by_shared.template middleCols<6>(9) = Matrix6(gain.cwiseProduct(readings_at(f, z)).asDiagonal());
      }
      l.jacobian.block(6 * k, turns_, 6, width_) = w.asDiagonal() * by_shared * spread_;
      const auto of_references = spread_.template topRows<3>();
      const Eigen::Matrix<double, Dynamic, Dynamic, 0, 4, kMostShared> mixed =
          chain.transpose() * turn_reference * of_references;
      second.block(at, turns_, 3, width_) += mixed.template topRows<3>();
      second.block(turns_, at, width_, 3) += mixed.template topRows<3>().transpose();
      if (extra >= 0) {
        second.block(extra, turns_, 1, width_) += mixed.row(3);
        second.block(turns_, extra, width_, 1) += mixed.row(3).transpose();
      }
      second.bottomRightCorner(width_, width_) += of_references.transpose() * reference_reference * of_references;
    }
    for (Index j = 0; j < width_; ++j) l.jacobian(6 * stations_ + j, turns_ + j) = weight_[6 * stations_ + j];
    l.gradient = l.jacobian.transpose() * l.residual;  // down the slope of Omega / 2
    l.hessian = l.jacobian.transpose() * l.jacobian - second;
    return l;
  }

  /// 1 / |column of J|: unknowns of which one unit moves the observations by one sd.
  static Columns scale_of(const Linear& l) {
    const Columns size = l.jacobian.colwise().norm().transpose();
    double largest = 0;
    for (Eigen::Index i = 0; i < size.size(); ++i) largest = std::max(largest, size[i]);
    const double least = 1e-8 * largest;
    return size.cwiseMax(least).cwiseInverse();
  }

  /// A state with a lower Omega where the stationary point has a direction of negative curvature.
  std::optional<State> beside_saddle(const State& at, const Linear& l, const Square& h, const Columns& scale) const {
    constexpr double kLeast = 1e-7;  // curvature per sd and sd; J'J has 1
    if (stats::cholesky(h + kLeast * Square::Identity(h.rows(), h.cols())).positive_definite()) return {};
    const Columns along = scale.cwiseProduct(Columns(stats::symmetric_eigen(h).vectors.col(0)));
    for (double size = 1; size > 1e-6; size /= 4) {
      const State right = moved_by(at, size * along), left = moved_by(at, -size * along);
      const double of_right = omega_at(right), of_left = omega_at(left);
      if (std::min(of_right, of_left) < l.omega) return of_right <= of_left ? right : left;
    }
    return {};
  }

  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const StationReadings& y_;
  Index stations_, width_ = 0, turns_ = 0;
  bool rotational_ = false;
  double digits_ = 1e-14;  // rounding of a residual, in sd
  Rows weight_;
  SharedSquare spread_;
};

}  // namespace

Minimum minimum_of_omega(const AdjustmentModel& model, const StationReadings& y, const VectorXd& variances,
                         const std::vector<Index>& left_out, const std::optional<MatrixXd>& shared_covariance) {
  std::vector<Index> out = left_out;
  const auto bz = static_cast<Index>(index_of(Observation::bz));
  if (model.mode == AdjustmentMode::sse_axial && std::find(out.begin(), out.end(), bz) == out.end()) out.push_back(bz);
  if (y.readings.size() == 1 && !(model.mode == AdjustmentMode::mse_shared && model.systematic_terms))
    return Descent<9, 6>(model, y, variances, out, shared_covariance).run();
  return Descent<Dynamic, Dynamic>(model, y, variances, out, shared_covariance).run();
}

}  // namespace surveymc::reliability
