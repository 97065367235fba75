#include "propagate/well_chain.h"

#include <array>

#include "orders/second.h"
#include "simd/dual.h"

namespace surveymc::propagate {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

/// First and second derivatives of the point at `share` of a leg by the errors of both its stations, at the errors x.
struct LegBend {
  Eigen::Matrix<double, 3, 8> slope;
  std::array<Matrix8d, 3> hessian;
};
LegBend leg_bend(const LegGeometry& leg, double share, const Vector8d& x) {
  using D = simd::Dual<double, 8>;
  using D2 = simd::Dual<D, 8>;
  std::array<D2, 8> v;
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = D2::variable(D::variable(x[static_cast<Eigen::Index>(i)], i), i);
  const survey::Vec3<D2> r = drawn_leg_point<D2>(leg, {v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]}, share);
  LegBend b;
  const std::array<const D2*, 3> axes{&r.x, &r.y, &r.z};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 8; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      b.slope(static_cast<Eigen::Index>(a), row) = axes[a]->d[i].a;
      for (std::size_t j = 0; j < 8; ++j) b.hessian[a](row, static_cast<Eigen::Index>(j)) = axes[a]->d[i].d[j];
    }
  return b;
}

Eigen::Vector4d numbers_of(const DrawEffect& e) { return {e.depth, e.inclination, e.azimuth, e.tilt}; }

Eigen::Index row_of(std::size_t station) { return 4 * static_cast<Eigen::Index>(station); }

}  // namespace

WellChain::WellChain(const WellErrors& errors, const WellPoint& point) : errors_(errors), point_(point) {
  const std::size_t n = point.station + 1;
  lasting_ = Eigen::MatrixXd::Zero(row_of(n), static_cast<Eigen::Index>(errors.station_draws));
  own_.assign(n, Eigen::Matrix4d::Zero());
  legs_.resize(n);
  true_leg_.assign(n, Eigen::Vector3d::Zero());
  const DrawnErrors<double> none{0, 0, 0, 0};
  for (std::size_t k = 1; k < n; ++k) {
    legs_[k] = leg_geometry(errors, k);
    true_leg_[k] = survey::to_eigen(drawn_leg_point(legs_[k], none, none, share(k)));
    for (const DrawEffect& e : errors.at[k]) {
      const Eigen::Vector4d w = numbers_of(e);
      if (e.draw < errors.station_draws)
        lasting_.col(e.draw).segment<4>(row_of(k)) += w;
      else
        own_[k] += w * w.transpose();
    }
  }
}

Eigen::VectorXd WellChain::numbers(const Eigen::VectorXd& z) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(lasting_.rows());
  for (std::size_t k = 1; k <= point_.station; ++k)
    for (const DrawEffect& e : errors_.at[k]) x.segment<4>(row_of(k)) += z[e.draw] * numbers_of(e);
  return x;
}

Eigen::Vector3d WellChain::course(const Eigen::VectorXd& z) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k <= point_.station; ++k)
    for (const DrawEffect& e : errors_.at[k]) sum += z[e.draw] * share(k) * e.course;
  return sum;
}

Eigen::Vector3d WellChain::displacement(const Eigen::VectorXd& x) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k <= point_.station; ++k) {
    const auto at = [&x](std::size_t station) {
      const auto v = x.segment<4>(row_of(station));
      return DrawnErrors<double>{v[0], v[1], v[2], v[3]};
    };
    sum += survey::to_eigen(drawn_leg_point(legs_[k], at(k - 1), at(k), share(k))) - true_leg_[k];
  }
  return sum;
}

Matrix8d WellChain::pair(std::size_t k) const {
  const auto rows = lasting_.middleRows(row_of(k - 1), 8);
  Matrix8d s = rows * rows.transpose();
  s.topLeftCorner<4, 4>() += own_[k - 1];
  s.bottomRightCorner<4, 4>() += own_[k];
  return s;
}

Eigen::Matrix3Xd WellChain::values(const Eigen::MatrixXd& z) const {
  Eigen::Matrix3Xd out(3, z.cols());
  for (Eigen::Index i = 0; i < z.cols(); ++i) out.col(i) = displacement(numbers(z.col(i))) + course(z.col(i));
  return out;
}

orders::Path WellChain::path(const Eigen::VectorXd& v, const std::vector<double>& t) const {
  const Eigen::VectorXd x = numbers(v);
  const Eigen::Vector3d straight = course(v);
  orders::Path out{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(t.size())), {}};
  for (std::size_t i = 0; i < t.size(); ++i)
    out.at.col(static_cast<Eigen::Index>(i)) = displacement(t[i] * x) + t[i] * straight;
  return out;
}

orders::Expansion WellChain::expand(const Eigen::VectorXd& z, const Eigen::VectorXd&,
                                    const orders::ExpansionParts& parts) const {
  const std::size_t n = point_.station + 1;
  const Eigen::VectorXd x = numbers(z);
  const Eigen::Index directions = parts.directions.cols();
  orders::Expansion e;
  e.first = Eigen::Matrix3Xd::Zero(3, dimension());
  e.trace.setZero();
  Eigen::MatrixXd dx(x.size(), directions);
  for (Eigen::Index i = 0; i < directions; ++i) dx.col(i) = numbers(parts.directions.col(i));
  std::array<Eigen::MatrixXd, 3> bend;
  for (auto& b : bend) b = Eigen::MatrixXd::Zero(x.size(), directions);
  // H by the numbers, in blocks: at a station, and with the station before.
  std::array<std::vector<Eigen::Matrix4d>, 3> at, before;
  for (std::size_t a = 0; a < 3 && parts.squares; ++a) {
    at[a].assign(n, Eigen::Matrix4d::Zero());
    before[a].assign(n, Eigen::Matrix4d::Zero());
  }
  for (std::size_t k = 1; k < n; ++k) {
    const Eigen::Index row = row_of(k - 1);
    const LegBend leg = leg_bend(legs_[k], share(k), x.segment<8>(row));
    for (const DrawEffect& d : errors_.at[k - 1]) e.first.col(d.draw) += leg.slope.leftCols<4>() * numbers_of(d);
    for (const DrawEffect& d : errors_.at[k])
      e.first.col(d.draw) += leg.slope.rightCols<4>() * numbers_of(d) + share(k) * d.course;
    const Matrix8d covariance = pair(k);
    for (std::size_t a = 0; a < 3; ++a) {
      const Matrix8d& h = leg.hessian[a];
      e.trace[static_cast<Eigen::Index>(a)] += h.cwiseProduct(covariance).sum();
      if (directions > 0) bend[a].middleRows<8>(row) += h * dx.middleRows<8>(row);
      if (!parts.squares) continue;
      at[a][k - 1] += h.topLeftCorner<4, 4>();
      at[a][k] += h.bottomRightCorner<4, 4>();
      before[a][k] += h.bottomLeftCorner<4, 4>();
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    e.along[a] = Eigen::MatrixXd::Zero(dimension(), directions);
    for (std::size_t k = 1; k < n && directions > 0; ++k)
      for (const DrawEffect& d : errors_.at[k])
        e.along[a].row(d.draw) += numbers_of(d).transpose() * bend[a].middleRows<4>(row_of(k));
  }
  if (!parts.squares) return e;

  // tr(H_a S H_b S) with S = U U' + D
  std::array<Eigen::MatrixXd, 3> hu, uhu;
  for (std::size_t a = 0; a < 3; ++a) {
    hu[a] = Eigen::MatrixXd::Zero(x.size(), lasting_.cols());
    for (std::size_t k = 0; k < n; ++k) {
      hu[a].middleRows<4>(row_of(k)) += at[a][k] * lasting_.middleRows<4>(row_of(k));
      if (k == 0) continue;
      hu[a].middleRows<4>(row_of(k)) += before[a][k] * lasting_.middleRows<4>(row_of(k - 1));
      hu[a].middleRows<4>(row_of(k - 1)) += before[a][k].transpose() * lasting_.middleRows<4>(row_of(k));
    }
    uhu[a] = lasting_.transpose() * hu[a];
  }
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      double sum = uhu[a].cwiseProduct(uhu[b].transpose()).sum();
      for (std::size_t k = 0; k < n; ++k) {
        const Eigen::Matrix4d& d = own_[k];
        sum += 2 * hu[a].middleRows<4>(row_of(k)).cwiseProduct(d * hu[b].middleRows<4>(row_of(k))).sum();
        sum += (at[a][k] * d * at[b][k] * d).trace();
        if (k > 0) sum += 2 * (before[a][k] * own_[k - 1] * before[b][k].transpose() * d).trace();
      }
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      e.squares(i, j) = e.squares(j, i) = sum;
    }
  return e;
}

PointMoments second_order_moments(const WellErrors& errors, const WellPoint& point) {
  return orders::second_order(WellChain(errors, point));
}

}  // namespace surveymc::propagate
