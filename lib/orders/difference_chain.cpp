#include "orders/difference_chain.h"

namespace surveymc::orders {
namespace {

/// Rounding of values that are right to 1e-9 is 1e-6 of second differences, and what is cut off 1e-5.
constexpr double kDifference = 0.05;

/// F at z and at steps along the axes.
struct Steps {
  Eigen::Vector3d at;
  Eigen::Matrix3Xd up, down, up2, down2;

  Eigen::Matrix3Xd first() const { return (8 * (up - down) - (up2 - down2)) / (12 * kDifference); }
  Eigen::Matrix3Xd curvature() const {
    return (16 * (up + down) - (up2 + down2) - 30 * at.replicate(1, up.cols())) / (12 * kDifference * kDifference);
  }
};

Steps steps_at(const Chain& chain, const Eigen::VectorXd& z) {
  const Eigen::Index d = z.size();
  Eigen::MatrixXd points = z.replicate(1, 4 * d + 1);
  for (Eigen::Index i = 0; i < d; ++i) {
    points(i, i) += kDifference;
    points(i, d + i) -= kDifference;
    points(i, 2 * d + i) += 2 * kDifference;
    points(i, 3 * d + i) -= 2 * kDifference;
  }
  const Eigen::Matrix3Xd f = chain.values(points);
  return {f.col(4 * d), f.leftCols(d), f.middleCols(d, d), f.middleCols(2 * d, d), f.middleCols(3 * d, d)};
}

}  // namespace

Path DifferenceChain::path(const Eigen::VectorXd& v, const std::vector<double>& t) const {
  Eigen::MatrixXd z(v.size(), static_cast<Eigen::Index>(t.size()));
  for (std::size_t i = 0; i < t.size(); ++i) z.col(static_cast<Eigen::Index>(i)) = t[i] * v;
  return {values_(z), {}};
}

Expansion DifferenceChain::expand(const Eigen::VectorXd& z, const Eigen::VectorXd&, const ExpansionParts& parts) const {
  const Eigen::Index d = dimension_, directions = parts.directions.cols();
  const Steps steps = steps_at(*this, z);
  Expansion e;
  e.first = steps.first();
  const Eigen::Matrix3Xd curvature = steps.curvature();
  e.trace = curvature.rowwise().sum();
  for (auto& along : e.along) along = Eigen::MatrixXd::Zero(d, directions);
  for (Eigen::Index k = 0; k < directions; ++k) {
    // H v by the curvature along v + e_i and v - e_i.
    const Eigen::VectorXd v = parts.directions.col(k);
    Eigen::MatrixXd points = z.replicate(1, 4 * d);
    for (Eigen::Index i = 0; i < d; ++i)
      for (const Eigen::Index side : {0, 1}) {
        const double sign = side == 0 ? kDifference : -kDifference;
        points.col(2 * i + side) += sign * v;
        points(i, 2 * i + side) += sign;
        points.col(2 * d + 2 * i + side) += sign * v;
        points(i, 2 * d + 2 * i + side) -= sign;
      }
    const Eigen::Matrix3Xd f = values_(points);
    for (Eigen::Index i = 0; i < d; ++i) {
      const Eigen::Vector3d same = f.col(2 * i) + f.col(2 * i + 1),
                            opposite = f.col(2 * d + 2 * i) + f.col(2 * d + 2 * i + 1);
      for (std::size_t a = 0; a < 3; ++a)
        e.along[a](i, k) = (same - opposite)[static_cast<Eigen::Index>(a)] / (4 * kDifference * kDifference);
    }
  }
  if (!parts.squares) return e;

  e.squares = curvature * curvature.transpose();
  for (Eigen::Index i = 1; i < d; ++i) {
    Eigen::MatrixXd points = z.replicate(1, 2 * i);
    for (Eigen::Index j = 0; j < i; ++j)
      for (const Eigen::Index side : {0, 1}) {
        const double step = side == 0 ? kDifference : -kDifference;
        points(i, 2 * j + side) += step;
        points(j, 2 * j + side) += step;
      }
    const Eigen::Matrix3Xd f = values_(points);
    const Eigen::Vector3d own = steps.up.col(i) + steps.down.col(i);
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::Vector3d h =
          (f.col(2 * j) + f.col(2 * j + 1) - own - steps.up.col(j) - steps.down.col(j) + 2 * steps.at) /
          (2 * kDifference * kDifference);
      e.squares += 2 * h * h.transpose();
    }
  }
  return e;
}

}  // namespace surveymc::orders
