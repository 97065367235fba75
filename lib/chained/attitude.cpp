#include "chained/attitude.h"

#include <cmath>

#include <Eigen/Geometry>

#include "base/units.h"

namespace surveymc::chained {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d frame_of(const survey::Attitude& at) {
  Matrix3d m;
  m.col(0) = survey::to_eigen(survey::magnetic_T(at, 1, 0));
  m.col(2) = survey::to_eigen(survey::down_T(at));
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

survey::Attitude attitude_of(const Matrix3d& m) {
  return survey::attitude_from_fields(survey::from_eigen(m.col(2)), survey::from_eigen(m.col(0)));
}

Matrix3d attitude_derivatives(const Matrix3d& m) {
  // d = (-sinI sin tau, -sinI cos tau, cosI); n_z = sinI cosA, e_z = sinI sinA; dv = delta x v for each column of M.
  const Vector3d n = m.col(0), e = m.col(1), d = m.col(2);
  const double s = std::hypot(d.x(), d.y()), s2 = s * s;
  const auto by_delta = [](const Vector3d& v, int i) -> Vector3d { return Vector3d::Unit(i).cross(v); };
  const double sine = s > 0 ? -d.x() / s : 0, cosine = s > 0 ? -d.y() / s : 1;  // of tau
  Matrix3d g;
  for (int i = 0; i < 3; ++i) {
    const Vector3d dn = by_delta(n, i), de = by_delta(e, i), dd = by_delta(d, i);
    g(0, i) = -(sine * dd.x() + cosine * dd.y()) * d.z() - s * dd.z();  // I = atan2(s, d_z)
    g(1, i) = (n.z() * de.z() - e.z() * dn.z()) / s2;
    g(2, i) = (d.y() * dd.x() - d.x() * dd.y()) / s2;
  }
  return g;
}

Vector3d attitude_sd(const Matrix3d& m, const Matrix3d& covariance) {
  const Matrix3d g = attitude_derivatives(m);
  Vector3d sd;
  for (int i = 0; i < 3; ++i) sd[i] = std::sqrt(g.row(i).dot(covariance * g.row(i).transpose()));
  if (std::hypot(m(0, 2), m(1, 2)) < 1e-6) sd[1] = sd[2] = kNaN;
  return sd;
}

Vector3d rotation_between(const Matrix3d& from, const Matrix3d& to) {
  const Eigen::AngleAxisd turn(Matrix3d(to * from.transpose()));
  return turn.angle() * turn.axis();
}

}  // namespace surveymc::chained
