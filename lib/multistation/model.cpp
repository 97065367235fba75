#include "multistation/model.h"

#include <cmath>

#include <Eigen/LU>

namespace surveymc::multistation {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::array<std::array<int, 2>, 3> kPairs{{{0, 1}, {0, 2}, {1, 2}}};  // of a skew

double of(const PerParameter<double>& p, int index) { return p[static_cast<std::size_t>(index)]; }
Vector3d three(const PerParameter<double>& p, int kind) { return {of(p, kind), of(p, kind + 1), of(p, kind + 2)}; }

Matrix3d skew_matrix(const Vector3d& n) {
  Matrix3d m = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const auto [a, b] = kPairs[static_cast<std::size_t>(i)];
    m(a, b) = m(b, a) = n[i];
  }
  return m;
}

/// d(matrix value + bias) by the parameters of each kind, a column a parameter.
Matrix3d by_scale(const Vector3d& v) { return v.asDiagonal(); }
Matrix3d by_rotation(const Vector3d& v) { return -survey::cross_matrix(v); }  // r x v = -v x r
Matrix3d by_skew(const Vector3d& v) {
  Matrix3d m = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const auto [a, b] = kPairs[static_cast<std::size_t>(i)];
    m(a, i) = v[b];
    m(b, i) = v[a];
  }
  return m;
}

/// Corrected readings, and the residuals' gradients by them: rows.
struct Gradients {
  Vector3d residual;
  Matrix3d by_gravity, by_field;
};
Gradients gradients(const Vector3d& g, const Vector3d& b, const Reference& ref, ResidualKind kind) {
  const double gravity = g.norm();
  const Vector3d u = g / gravity;
  const double bv = u.dot(b);
  Gradients out;
  out.by_gravity.row(0) = u.transpose();
  out.by_field.row(0).setZero();
  if (kind == ResidualKind::survey) {
    const Vector3d across = b - bv * u;
    const double bh = across.norm();
    const Vector3d h = across / bh;
    out.residual = {gravity - ref.gravity, bh - ref.first, bv - ref.second};
    out.by_field.row(1) = h.transpose();
    out.by_field.row(2) = u.transpose();
    out.by_gravity.row(1) = -bv / gravity * h.transpose();
    out.by_gravity.row(2) = bh / gravity * h.transpose();
  } else {
    const double total = b.norm(), sine = bv / total;
    const Vector3d direction = b / total;
    out.residual = {gravity - ref.gravity, total - ref.first, sine - ref.second};
    out.by_field.row(1) = direction.transpose();
    out.by_field.row(2) = (u - sine * direction).transpose() / total;
    out.by_gravity.row(1).setZero();
    out.by_gravity.row(2) = (direction - sine * u).transpose() / gravity;
  }
  return out;
}

}  // namespace

Reference reference_of(ResidualKind kind, double gravity, double total, double dip) {
  if (kind == ResidualKind::survey) return {gravity, total * std::cos(dip), total * std::sin(dip)};
  return {gravity, total, std::sin(dip)};
}

TriadErrors accelerometer_errors(const PerParameter<double>& p) {
  return {Matrix3d::Identity() + skew_matrix(three(p, kAccelerometerSkew)) +
              Matrix3d(three(p, kAccelerometerScale).asDiagonal()),
          three(p, kAccelerometerBias)};
}

TriadErrors magnetometer_errors(const PerParameter<double>& p) {
  return {Matrix3d::Identity() + survey::cross_matrix(three(p, kRotation)) + skew_matrix(three(p, kMagnetometerSkew)) +
              Matrix3d(three(p, kMagnetometerScale).asDiagonal()),
          three(p, kMagnetometerBias)};
}

StationReadings readings_of(const PerParameter<double>& tool, const Vector3d& gravity_T, const Vector3d& field_T,
                            const Reference& reference) {
  const TriadErrors a = accelerometer_errors(tool), m = magnetometer_errors(tool);
  return {survey::from_eigen(a.matrix * gravity_T + a.bias), survey::from_eigen(m.matrix * field_T + m.bias),
          reference};
}

StationModel station_model(const StationReadings& station, const PerParameter<double>& parameters, ResidualKind kind,
                           const ResidualSizes& sizes) {
  const TriadErrors a = accelerometer_errors(parameters), m = magnetometer_errors(parameters);
  StationModel out;
  out.gravity_by_reading = a.matrix.inverse();
  out.field_by_reading = m.matrix.inverse();
  out.gravity_T = out.gravity_by_reading * (survey::to_eigen(station.gravity_T) - a.bias);
  out.field_T = out.field_by_reading * (survey::to_eigen(station.magnetic_T) - m.bias);
  const auto put = [](auto& by_parameter, int kind, const Matrix3d& by_reading, const Matrix3d& of_reading) {
    by_parameter.template middleCols<3>(kind) = -by_reading * of_reading;
  };
  out.gravity_by_parameter.setZero();
  put(out.gravity_by_parameter, kAccelerometerBias, out.gravity_by_reading, Matrix3d::Identity());
  put(out.gravity_by_parameter, kAccelerometerScale, out.gravity_by_reading, by_scale(out.gravity_T));
  put(out.gravity_by_parameter, kAccelerometerSkew, out.gravity_by_reading, by_skew(out.gravity_T));
  out.field_by_parameter.setZero();
  put(out.field_by_parameter, kMagnetometerBias, out.field_by_reading, Matrix3d::Identity());
  put(out.field_by_parameter, kMagnetometerScale, out.field_by_reading, by_scale(out.field_T));
  put(out.field_by_parameter, kRotation, out.field_by_reading, by_rotation(out.field_T));
  put(out.field_by_parameter, kMagnetometerSkew, out.field_by_reading, by_skew(out.field_T));
  const Gradients d = gradients(out.gravity_T, out.field_T, station.reference, kind);
  const Vector3d per_size(1 / sizes[0], 1 / sizes[1], 1 / sizes[2]);
  out.residual = per_size.cwiseProduct(d.residual);
  const Matrix3d by_gravity = per_size.asDiagonal() * d.by_gravity, by_field = per_size.asDiagonal() * d.by_field;
  out.by_gravity = by_gravity * out.gravity_by_reading;
  out.by_magnetic = by_field * out.field_by_reading;
  out.by_parameter = by_gravity * out.gravity_by_parameter + by_field * out.field_by_parameter;
  out.by_reference = -Matrix3d(per_size.asDiagonal());
  return out;
}

Vector3d station_residual(const StationReadings& station, const PerParameter<double>& parameters, ResidualKind kind,
                          const ResidualSizes& sizes) {
  return station_model(station, parameters, kind, sizes).residual;
}

Eigen::MatrixXd jacobian(const std::vector<StationReadings>& stations, const PerParameter<double>& parameters,
                         const ParameterSet& set, ResidualKind kind, const ResidualSizes& sizes) {
  Eigen::MatrixXd j(kResiduals * static_cast<Eigen::Index>(stations.size()), set.size());
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const StationModel m = station_model(stations[k], parameters, kind, sizes);
    for (int i = 0; i < set.size(); ++i)
      j.block<kResiduals, 1>(kResiduals * static_cast<Eigen::Index>(k), i) = m.by_parameter.col(set.index(i));
  }
  return j;
}

}  // namespace surveymc::multistation
