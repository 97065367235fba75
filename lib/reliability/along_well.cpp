#include "reliability/along_well.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "base/units.h"
#include "reliability/conditions.h"
#include "reliability/reliability_grid.h"
#include "stats/linear_algebra.h"
#include "survey/minimum_curvature.h"

namespace surveymc::reliability {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Six = Eigen::Matrix<double, 3, kReadings>;

/// One station, in units that make all of order one (g/G, b/B): columns B and the effect of the readings on the
/// position.
struct StationTerms {
  Six conditions;                                     ///< B_k: of misclosures by readings (relative, rad)
  Six position;                                       ///< of the last station, m per relative reading
  Eigen::Matrix<double, 6, 1> variance, bias, scale;  ///< of relative readings; variances of the systematic terms
  Six angles;                                         ///< rows: I, tau, A (rad per relative reading)
  Matrix3d weight;                                    ///< M_k^-1, without the direction of bz where that is left out
  Eigen::Matrix<double, 6, 3> residuals;  ///< of the readings, by misclosures; for a bz left out, its estimated error
  MatrixXd shared;                        ///< D_k
  MatrixXd shared_position;  ///< of the position by z: only systematic terms, which are subtracted from the readings
  Eigen::Matrix<double, 6, 1> values;          ///< relative readings
  Eigen::Matrix<double, 1, kReadings> across;  ///< tilt to the right, rad per relative reading
  bool vertical, up;                           ///< up: the hole goes up
  double lost_azimuth = 0;                     ///< infinite where bz was left out, but was all that knew the azimuth
  Vector3d lost_position = Vector3d::Zero();   ///< where a turn by that azimuth would take the last station, m per rad
};

/// z: the quantities that the stations share, relative. They are in units of the prior sd, which scales them well and
/// keeps a term with a prior of zero at zero.
struct SharedTerms {
  VectorXd sd;           ///< prior, of z
  MatrixXd information;  ///< of all stations and the prior, in units of the sd
  MatrixXd position;     ///< of the last station by z, over all stations
};

namespace {

/// Derivatives of hole direction (magnetic N frame) and angles by the readings: the tool turns by phi, whose parts are
/// phi_n = -e.du, phi_e = n.du, phi_u = (e.dh - sinD e.du)/cosD.
struct Turning {
  Six tangent, angles;
  Eigen::Matrix<double, 1, kReadings> across;  ///< of the tilt to the right
};
Turning turning(const survey::Attitude& at, double dip) {
  const Vector3d u = survey::to_eigen(survey::down_T(at)), h = survey::to_eigen(survey::magnetic_T(at, 1, dip));
  const Vector3d n = (h - std::sin(dip) * u) / std::cos(dip), e = u.cross(n);
  Six phi;
  phi << -e.transpose(), Eigen::RowVector3d::Zero(), n.transpose(), Eigen::RowVector3d::Zero(),
      -std::tan(dip) * e.transpose(), e.transpose() / std::cos(dip);
  const Vector3d t(n.z(), e.z(), u.z());
  // n, e, u turn by phi x, so the hole t = (n_z, e_z, u_z) turns by t x phi
  Turning r;
  r.tangent = survey::cross_matrix(t) * phi;
  const double si = std::sin(at.inclination), ci = std::cos(at.inclination), st = std::sin(at.toolface),
               ct = std::cos(at.toolface);
  r.angles.setZero();
  r.angles.row(0).head<3>() << -ci * st, -ci * ct, -si;
  const bool vertical = std::abs(si) < 1e-12;
  r.across << -ct, st, 0, 0, 0, 0;
  r.angles.row(1) = r.across * (vertical ? 0 : 1 / si);
  r.angles.row(2) = -phi.row(2) - ci * r.angles.row(1);
  return r;
}

std::vector<StationTerms> station_terms(const AdjustmentModel& model, const survey::Survey& survey) {
  const survey::ReferenceField& f = model.field;
  const std::vector<Matrix3d> by_tangent =
      survey::final_position_by_tangent(survey.md(), survey::true_tangents(survey));
  const Matrix3d north = survey::true_from_magnetic(f.declination);
  const bool systematic = model.mode == AdjustmentMode::mse_shared && model.systematic_terms;
  std::vector<StationTerms> all;
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Attitude at = survey::magnetic_attitude(survey.stations[k], f.declination);
    const Observations y = true_observations(at, f), v = observation_variances(model, y);
    StationTerms s;
    Observations relative = y;
    for (std::size_t i = 0; i < kReadings; ++i) {
      const double unit = relative_unit(i, f);
      const auto j = static_cast<Index>(i);
      relative[i] /= unit;
      s.variance[j] = v[i] / (unit * unit);
      s.bias[j] = variance_parts(model.sigma, i, 0).systematic / (unit * unit);
      const double scale = i < 3 ? model.sigma.accelerometer_scale : model.sigma.magnetometer_scale;
      s.scale[j] = scale * scale;
      s.values[j] = relative[i];
    }
    s.vertical = std::abs(std::sin(at.inclination)) < 1e-12;
    s.conditions = station_conditions(relative.data()).jacobian;
    const Turning turn = turning(at, f.dip);
    s.angles = turn.angles;
    s.across = turn.across;
    s.up = at.inclination > kPi / 2;
    s.position = by_tangent[k] * north * turn.tangent;

    const bool axial = model.mode == AdjustmentMode::sse_axial;
    Eigen::Matrix<double, 6, 1> used = s.variance;
    if (axial) used[kAxialMagnetometer] = 0;
    Matrix3d m = s.conditions * used.asDiagonal() * s.conditions.transpose();
    const bool own_references = model.mode == AdjustmentMode::sse || axial;
    if (own_references) m.diagonal() += Vector3d(v[6] / (f.gravity * f.gravity), v[7] / (f.total * f.total), v[8]);
    s.weight = m.inverse();
    Eigen::RowVector3d bz = Eigen::RowVector3d::Zero();
    if (axial) {
      const Vector3d z = s.conditions.col(kAxialMagnetometer), wz = s.weight * z;
      if (z.dot(wz) * s.variance[kAxialMagnetometer] >= kLeastRedundancy) {
        bz = wz.transpose() / z.dot(wz);
        s.weight -= wz * wz.transpose() / z.dot(wz);
      } else {  // horizontal, east or west; signs as in station_kernel.h
        s.lost_azimuth = std::copysign(kInfinity, -s.angles(2, kAxialMagnetometer));
        s.lost_position = -s.position.col(kAxialMagnetometer);
      }
    }
    s.residuals = used.asDiagonal() * s.conditions.transpose() * s.weight;
    s.residuals.row(kAxialMagnetometer) += bz;
    s.shared = MatrixXd::Zero(3, systematic ? 15 : 3);
    s.shared_position = MatrixXd::Zero(3, s.shared.cols());
    s.shared.leftCols<3>() = -Matrix3d::Identity();
    if (systematic) {
      s.shared.middleCols<6>(3) = s.conditions;
      s.shared.rightCols<6>() = s.conditions * s.values.asDiagonal();
      s.shared_position.middleCols<6>(3) = s.position;
      s.shared_position.rightCols<6>() = s.position * s.values.asDiagonal();
    }
    all.push_back(std::move(s));
  }
  return all;
}

/// Of one station, z in units of its sd: `columns` are the misclosures by these.
MatrixXd information_of(const StationTerms& t, const MatrixXd& columns) {
  return columns.transpose() * t.weight * columns;
}

SharedTerms shared_terms(const AdjustmentModel& model, const std::vector<StationTerms>& terms) {
  const Index width = terms.front().shared.cols();
  SharedTerms z{VectorXd(width), MatrixXd::Identity(width, width), MatrixXd::Zero(3, width)};
  z.sd.head<3>() << model.sigma.gravity / model.field.gravity, model.sigma.total_field / model.field.total,
      model.sigma.dip;
  if (width > 3) {
    z.sd.segment<6>(3) = terms.front().bias.cwiseSqrt();
    z.sd.tail<6>() = terms.front().scale.cwiseSqrt();
  }
  for (const StationTerms& t : terms) {
    const MatrixXd scaled = t.shared * z.sd.asDiagonal();
    z.information += information_of(t, scaled);
    z.position += t.position * t.residuals * t.shared - t.shared_position;
  }
  return z;
}

/// Effect of an error; 0 times infinity is 0 here, because a quantity that the error does not affect stays unchanged.
/// Size in units of the sd.
double reach(double per_unit, double sd, double detectable) {
  if (std::isfinite(detectable)) return per_unit * detectable;
  return std::abs(per_unit * sd) < 1e-12 ? 0 : std::copysign(kInfinity, per_unit);
}
Vector3d reach(const Vector3d& per_unit, double sd, double detectable) {
  return per_unit.unaryExpr([&](double x) { return reach(x, sd, detectable); });
}

}  // namespace

WellReliability reliability_along_well(const AdjustmentModel& model, const survey::Survey& survey, double lambda0) {
  const std::vector<StationTerms> terms = station_terms(model, survey);
  const bool shared = model.mode == AdjustmentMode::mse_shared;
  const survey::ReferenceField& f = model.field;
  const SigmaModel& sigma = model.sigma;
  const Index width = terms.front().shared.cols();

  // P and the position's dependence on the estimate of z, given misclosures
  MatrixXd p = MatrixXd::Zero(width, width), position_by_z = MatrixXd::Zero(3, width);
  VectorXd prior(width);
  if (shared) {
    const SharedTerms z = shared_terms(model, terms);
    prior = z.sd.cwiseAbs2();
    p = z.sd.asDiagonal() * stats::cholesky(z.information).solve(MatrixXd::Identity(width, width)) * z.sd.asDiagonal();
    position_by_z = z.position;
  }

  /// One kind of error: its effect on the sums of misclosures, and on the position.
  struct Error {
    double information = 0;
    VectorXd s;                            // sum of D' W c
    Vector3d direct = Vector3d::Zero();    // to the position, without adjustment
    Vector3d adjusted = Vector3d::Zero();  // with the residuals subtracted, but z unchanged
    Vector3d lost = Vector3d::Zero();      // by azimuths that are lost
  };
  const auto add = [&](Error& e, const StationTerms& at, const Vector3d& c, const Vector3d& direct) {
    const Vector3d wc = at.weight * c;
    e.information += c.dot(wc);
    e.s += at.shared.transpose() * wc;
    e.direct += direct;
    e.lost += at.lost_position;
    e.adjusted += direct - at.position * (at.residuals * c);
  };
  const auto information = [&](const Error& e) { return shared ? e.information - e.s.dot(p * e.s) : e.information; };
  const auto detectable = [&](const Error& e, double variance) {
    const double i = information(e);
    return i * variance >= kLeastRedundancy ? lambda0 / std::sqrt(i) : kInfinity;
  };
  const auto position = [&](const Error& e, double size, double variance) {
    const Vector3d moved = !std::isfinite(size) ? e.direct
                           : shared             ? Vector3d(e.adjusted + position_by_z * (p * e.s))
                                                : e.adjusted;
    const Vector3d lost = reach(e.lost, 1, kInfinity);
    return Vector3d((lost.array() == 0).select(reach(moved, std::sqrt(variance), size), lost));
  };
  const Error none{.s = VectorXd::Zero(width)};

  WellReliability r;
  r.stations.resize(terms.size());
  const std::array<double, 3> reference_variance{std::pow(sigma.gravity / f.gravity, 2),
                                                 std::pow(sigma.total_field / f.total, 2), std::pow(sigma.dip, 2)};
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const StationTerms& at = terms[k];
    for (std::size_t i = 0; i < kObservations; ++i) {
      if (!is_observed(model.mode, i) || (shared && i >= kReadings)) continue;
      const bool reading = i < kReadings;
      const auto column = static_cast<Index>(i);
      const Vector3d c = reading ? Vector3d(at.conditions.col(column)) : -Vector3d::Unit(column - 6);
      const double variance = reading ? at.variance[column] : reference_variance[i - kReadings];
      Error e = none;
      add(e, at, c, reading ? Vector3d(at.position.col(column)) : Vector3d(Vector3d::Zero()));
      StationEffect& out = r.stations[k][i];
      const double size = detectable(e, variance), sd = std::sqrt(variance);
      out.redundancy = std::isfinite(size) ? information(e) * variance : 0;
      out.detectable = size * relative_unit(i, f);
      out.position = position(e, size, variance);
      Eigen::Matrix<double, 6, 1> left = Eigen::Matrix<double, 6, 1>::Zero();  // of the error, in the readings
      if (reading) left[column] = 1;
      if (std::isfinite(size)) {
        const VectorXd z = shared ? VectorXd(p * e.s) : VectorXd(VectorXd::Zero(width));
        left -= at.residuals * (c - at.shared * z);
        if (width > 3) left -= z.segment<6>(3) + z.tail<6>().cwiseProduct(at.values);
      }
      const Vector3d angles = reach(at.angles * left, sd, size);
      out.inclination = angles[0];
      if (at.vertical) {  // by its tilt, to whichever side
        const double tilt = std::hypot(angles[0], reach(at.across.dot(left), sd, size));
        out.inclination = at.up ? -tilt : tilt;
      }
      out.toolface = at.vertical ? kInfinity : angles[1];
      out.azimuth = at.vertical ? kInfinity : at.lost_azimuth != 0 ? at.lost_azimuth : angles[2];
    }
  }
  for (std::size_t i = 0; i < kReadings; ++i) {
    const auto column = static_cast<Index>(i);
    Error e = none;
    for (const StationTerms& at : terms) add(e, at, at.conditions.col(column), at.position.col(column));
    const double variance = terms.front().variance[column];
    if (!is_observed(model.mode, i)) {
      r.common[i].detectable = kNaN;
      continue;
    }
    const double size = detectable(e, variance);
    r.common[i] = {size * relative_unit(i, f), position(e, size, variance)};
  }
  if (shared)
    for (std::size_t j = 0; j < 3; ++j) {
      Error e = none;
      for (const StationTerms& at : terms) add(e, at, -Vector3d::Unit(static_cast<Index>(j)), Vector3d::Zero());
      const double size = detectable(e, reference_variance[j]);
      StationEffect& out = r.references[j];
      out.redundancy = std::isfinite(size) ? information(e) * reference_variance[j] : 0;
      out.detectable = size * relative_unit(kReadings + j, f);
      out.position = position(e, size, reference_variance[j]);
    }
  return r;
}

struct WellErrors::Shared {
  std::vector<StationTerms> terms;
  SharedTerms z;
  VectorXd unit;  ///< of z: internal per relative
};

WellErrors::~WellErrors() = default;

WellErrors::WellErrors(const AdjustmentModel& model, const survey::Survey& survey, double lambda0, DetectedBy test)
    : model_(model), survey_(survey), lambda0_(lambda0), test_(test) {
  if (model.mode != AdjustmentMode::mse_shared) return;
  std::vector<StationTerms> terms = station_terms(model, survey);
  SharedTerms z = shared_terms(model, terms);
  VectorXd unit = VectorXd::Ones(z.sd.size());
  unit.head<2>() << model.field.gravity, model.field.total;
  if (unit.size() > 3) {
    unit.segment<3>(3).setConstant(model.field.gravity);
    unit.segment<3>(6).setConstant(model.field.total);
  }
  shared_ = std::make_unique<Shared>(Shared{std::move(terms), std::move(z), std::move(unit)});
}

FoundError WellErrors::of(std::size_t k, std::size_t observation, int sign) const {
  if (shared_ && observation >= kReadings)
    throw std::invalid_argument("a reference that all stations share is no error of one");
  const double nan = kNaN;
  const survey::Station& station = survey_.stations[k];
  StationInWell in{model_, survey::magnetic_attitude(station, model_.field.declination), {}};
  if (shared_) {
    const StationTerms& own = shared_->terms[k];
    const MatrixXd scaled = own.shared * shared_->z.sd.asDiagonal();
    const MatrixXd others = shared_->z.information - information_of(own, scaled);
    VectorXd size = shared_->z.sd.cwiseProduct(shared_->unit);
    // The error of an observed reference has this sign. Systematic terms are observed as 0, so their error is 0 less
    // the true value.
    size.tail(size.size() - 3) *= -1;
    in.shared = size.asDiagonal() * stats::cholesky(others).solve(MatrixXd::Identity(others.rows(), others.cols())) *
                size.asDiagonal();
  }
  const DetectedError e = detected_error(in, observation, lambda0_, sign, test_);
  FoundError found{e.size, nan, nan, nan, Vector3d::Constant(sign * kInfinity)};
  if (!std::isfinite(e.size)) return found;

  const AngleEffects angles = angle_effects(in.at, e);
  found.inclination = angles.inclination;
  found.toolface = angles.toolface;
  found.azimuth = angles.azimuth;
  const survey::Vec3<double> moved = survey::magnetic_to_true(
      survey::tangent_from_fields(survey::from_eigen(e.down.normalized()), survey::from_eigen(e.field)),
      std::sin(model_.field.declination), std::cos(model_.field.declination));
  const auto tangent = [&](std::size_t j) {
    const survey::Station& s = survey_.stations[j];
    return survey::tangent_N({s.inclination, s.azimuth, s.toolface});
  };
  found.position.setZero();
  const auto interval = [&](std::size_t from, const survey::Vec3<double>& a, const survey::Vec3<double>& b) {
    return survey::to_eigen(
        survey::minimum_curvature_interval(survey_.stations[from + 1].md - survey_.stations[from].md, a, b));
  };
  const survey::Vec3<double> here = tangent(k);
  if (k > 0) found.position += interval(k - 1, tangent(k - 1), moved) - interval(k - 1, tangent(k - 1), here);
  if (k + 1 < survey_.stations.size())
    found.position += interval(k, moved, tangent(k + 1)) - interval(k, here, tangent(k + 1));
  if (shared_) {
    const StationTerms& own = shared_->terms[k];
    const MatrixXd by_shared = shared_->z.position - (own.position * own.residuals * own.shared - own.shared_position);
    found.position += by_shared * e.shared_errors.cwiseQuotient(shared_->unit);
  }
  return found;
}

}  // namespace surveymc::reliability
