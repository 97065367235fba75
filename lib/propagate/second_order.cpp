#include "propagate/second_order.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simd/dual.h"

namespace surveymc::propagate {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

/// Second derivatives of the point at `share` of a leg by the errors of both its stations, at the errors x; N, E, V.
std::array<Matrix8d, 3> leg_hessian(const LegGeometry& leg, double share, const Vector8d& x) {
  using D = simd::Dual<double, 8>;
  using D2 = simd::Dual<D, 8>;
  std::array<D2, 8> v;
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = D2::variable(D::variable(x[static_cast<Eigen::Index>(i)], i), i);
  const survey::Vec3<D2> r = drawn_leg_point<D2>(leg, {v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]}, share);
  std::array<Matrix8d, 3> h;
  const std::array<const D2*, 3> axes{&r.x, &r.y, &r.z};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t j = 0; j < 8; ++j)
        h[a](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = axes[a]->d[i].d[j];
  return h;
}

/// The four numbers of all stations as sums of draws.
struct StationSums {
  Eigen::MatrixXd lasting;              ///< 4 stations x draws of several stations
  std::vector<Eigen::Matrix4d> blocks;  ///< covariance by the draws of one station
  Eigen::MatrixX3d with_first_order;    ///< cov(x, l): 4 stations x 3

  /// Covariance of the stations k - 1 and k.
  Matrix8d pair(std::size_t k) const {
    const auto rows = lasting.middleRows(4 * static_cast<Eigen::Index>(k - 1), 8);
    Matrix8d s = rows * rows.transpose();
    s.topLeftCorner<4, 4>() += blocks[k - 1];
    s.bottomRightCorner<4, 4>() += blocks[k];
    return s;
  }
};

StationSums station_sums(const WellErrors& errors, const WellPoint& point) {
  const auto n = static_cast<Eigen::Index>(point.station + 1);
  const Eigen::Matrix3Xd first = draw_effects(errors, point, FirstOrder::minimum_curvature);
  StationSums s;
  s.lasting = Eigen::MatrixXd::Zero(4 * n, static_cast<Eigen::Index>(errors.station_draws));
  s.blocks.assign(point.station + 1, Eigen::Matrix4d::Zero());
  s.with_first_order = Eigen::MatrixX3d::Zero(4 * n, 3);
  for (std::size_t k = 1; k <= point.station; ++k)
    for (const DrawEffect& e : errors.at[k]) {
      const Eigen::Vector4d w(e.depth, e.inclination, e.azimuth, e.tilt);
      const auto row = 4 * static_cast<Eigen::Index>(k);
      if (e.draw < errors.station_draws)
        s.lasting.col(e.draw).segment<4>(row) += w;
      else
        s.blocks[k] += w * w.transpose();
      s.with_first_order.middleRows<4>(row) += w * first.col(e.draw).transpose();
    }
  return s;
}

/// T_b[v, S] of one leg: how tr(H_b S) changes along v.
Eigen::Vector3d third_order(const LegGeometry& leg, double share, const Vector8d& v, const Matrix8d& s) {
  // Central differences, at errors of a thousandth of a radian: right to 1e-6. The point is linear in the depths, so
  // that a step of any length is right for them; it is of a thousand kilometres where there are no angles.
  double largest = 0;
  for (const Eigen::Index i : {1, 2, 3, 5, 6, 7}) largest = std::max(largest, std::abs(v[i]));
  for (const Eigen::Index i : {0, 4}) largest = std::max(largest, 1e-9 * std::abs(v[i]));
  if (largest == 0) return Eigen::Vector3d::Zero();
  const double h = 1e-3 / largest;
  const auto plus = leg_hessian(leg, share, h * v), minus = leg_hessian(leg, share, -h * v);
  Eigen::Vector3d t;
  for (std::size_t b = 0; b < 3; ++b)
    t[static_cast<Eigen::Index>(b)] = ((plus[b] - minus[b]).cwiseProduct(s)).sum() / (2 * h);
  return t;
}

}  // namespace

PointMoments second_order_moments(const WellErrors& errors, const WellPoint& point) {
  const StationSums s = station_sums(errors, point);
  const auto n = static_cast<Eigen::Index>(point.station + 1);
  const auto zero = Eigen::Matrix4d::Zero();
  // H in blocks: at a station, and with the station before.
  std::array<std::vector<Eigen::Matrix4d>, 3> at, before;
  for (std::size_t a = 0; a < 3; ++a) {
    at[a].assign(point.station + 1, zero);
    before[a].assign(point.station + 1, zero);
  }
  PointMoments m;
  const Eigen::Matrix3Xd first = draw_effects(errors, point, FirstOrder::minimum_curvature);
  m.covariance = covariance_of(first);
  for (std::size_t k = 1; k <= point.station; ++k) {
    const double share = k == point.station ? point.share : 1;
    const LegGeometry leg = leg_geometry(errors, k);
    const auto h = leg_hessian(leg, share, Vector8d::Zero());
    const Matrix8d pair = s.pair(k);
    const Eigen::Matrix<double, 8, 3> v = s.with_first_order.middleRows<8>(4 * static_cast<Eigen::Index>(k - 1));
    Eigen::Matrix3d mixed;
    for (Eigen::Index a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      m.mean[a] += 0.5 * h[i].cwiseProduct(pair).sum();
      at[i][k - 1] += h[i].topLeftCorner<4, 4>();
      at[i][k] += h[i].bottomRightCorner<4, 4>();
      before[i][k] += h[i].bottomLeftCorner<4, 4>();
      mixed.row(a) = 0.5 * third_order(leg, share, v.col(a), pair).transpose();
    }
    m.covariance += mixed + mixed.transpose();
  }
  // tr(H_a S H_b S) / 2 with S = U U' + D
  std::array<Eigen::MatrixXd, 3> hu, uhu;
  for (std::size_t a = 0; a < 3; ++a) {
    hu[a] = Eigen::MatrixXd::Zero(4 * n, s.lasting.cols());
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto i = static_cast<std::size_t>(k);
      hu[a].middleRows<4>(4 * k) += at[a][i] * s.lasting.middleRows<4>(4 * k);
      if (k == 0) continue;
      hu[a].middleRows<4>(4 * k) += before[a][i] * s.lasting.middleRows<4>(4 * k - 4);
      hu[a].middleRows<4>(4 * k - 4) += before[a][i].transpose() * s.lasting.middleRows<4>(4 * k);
    }
    uhu[a] = s.lasting.transpose() * hu[a];
  }
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      double sum = uhu[a].cwiseProduct(uhu[b].transpose()).sum();
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const Eigen::Matrix4d& d = s.blocks[i];
        sum += 2 * hu[a].middleRows<4>(4 * k).cwiseProduct(d * hu[b].middleRows<4>(4 * k)).sum();
        sum += (at[a][i] * d * at[b][i] * d).trace();
        if (k > 0) {
          const Eigen::Matrix4d &down = before[a][i], &other = before[b][i], &d_before = s.blocks[i - 1];
          sum += 2 * (down * d_before * other.transpose() * d).trace();
        }
      }
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      m.covariance(i, j) += 0.5 * sum;
      if (i != j) m.covariance(j, i) += 0.5 * sum;
    }
  return m;
}

}  // namespace surveymc::propagate
