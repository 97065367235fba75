#include "analysis/msa_chain.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "base/units.h"
#include "simd/dual.h"
#include "simd/jet.h"
#include "stats/linear_algebra.h"
#include "survey/corrected_position.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using estimate::FieldFitPoint;
using estimate::Matrix6d;
using estimate::Matrix83d;
using estimate::Matrix8d;
using estimate::Vector6d;
using estimate::Vector8d;

namespace {

/// Unknowns x: p, q / total, z. Variables of a station: corrected field b (in total fields), down direction u, total
/// field, dip of the reference that is fitted. Its inputs y: magnetometer (in total fields), gravity (in its own size),
/// total field, dip that were given.
constexpr int kUnknowns = 8, kLocals = 8, kInputs = 8, kGivenTotal = 6, kGivenDip = 7;
using Jet8 = simd::Jet<kLocals>;
using Matrix38d = Eigen::Matrix<double, 3, 8>;
/// By the normals of the whole run: at most two of the reference and six of the tool.
using MatrixOfRun = Eigen::Matrix<double, 8, Eigen::Dynamic, 0, 8, 8>;

Vector8d gradient(const Jet8& x) { return Vector8d(x.g.data()); }
void add_hessian(double factor, const Jet8& x, Matrix8d& sum) {
  for (int i = 0; i < kLocals * kLocals; ++i) sum.data()[i] += factor * x.h[static_cast<std::size_t>(i)];
}

struct LegBends {
  double factor, slope, bend;  ///< RF(s), its first and second derivative
};
LegBends leg_bends(double s) {
  using D = simd::Dual<double, 1>;
  using D2 = simd::Dual<D, 1>;
  const D2 r = survey::ratio_factor(D2::variable(D::variable(s, 0), 0));
  return {r.a.a, r.a.d[0], r.d[0].d[0]};
}

/// Second derivatives of a leg's displacement, component a, by the tangents of both its ends:
///   f = L / 2 RF(s) (t1 + t2),  s = |t2 - t1|^2 / 4
std::array<Matrix6d, 3> leg_hessian(double length, const Vector3d& from, const Vector3d& to) {
  const Vector3d chord = to - from, sum = from + to;
  const LegBends rf = leg_bends(chord.squaredNorm() / 4);
  Vector6d ds;
  ds << -chord / 2, chord / 2;
  Matrix6d dds = Matrix6d::Identity() / 2;
  dds.topRightCorner<3, 3>() = dds.bottomLeftCorner<3, 3>() = -Matrix3d::Identity() / 2;
  std::array<Matrix6d, 3> h;
  for (int a = 0; a < 3; ++a) {
    Matrix6d& m = h[static_cast<std::size_t>(a)];
    m = sum[a] * (rf.bend * ds * ds.transpose() + rf.slope * dds);
    for (const int i : {a, 3 + a}) {
      m.col(i) += rf.slope * ds;
      m.row(i) += rf.slope * ds.transpose();
    }
    m *= length / 2;
  }
  return h;
}

template <class A, class B>
double inner(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return a.cwiseProduct(b).sum();
}

}  // namespace

/// One station of an expansion.
struct MsaChain::Station {
  Vector8d y;                          ///< inputs
  Vector8d size;                       ///< of the station's own normals: dy of each input by its normal
  std::array<int, 8> row;              ///< of these normals in z; -1: none
  MatrixOfRun of_run;                  ///< dy by the normals of the run
  std::array<Jet8, 3> tangent, slope;  ///< t (true north); d phi/db, phi = r'W r / 2
  Jet8 by_total, by_dip;               ///< d phi by the reference
  std::array<Jet8, 3> fitted;          ///< what the derivative at the fitted field takes off, times p (field_fit.h)
  Matrix3d tilt;                       ///< du by gravity
  double gravity;                      ///< length of the gravity that is read
  /// Unknown i moves the variable moved[i] alone, by factor[i].
  static constexpr std::array<int, 8> moved{0, 1, 2, 0, 1, 2, kGivenTotal, kGivenDip};
  Vector8d factor;
  Matrix8d residual_by_inputs;  ///< dg/dy
  Matrix38d tangent_by_unknowns, tangent_by_inputs;
  Matrix8d unknowns_by_inputs;  ///< X of the station's inputs

  /// A gradient by the variables as one by inputs, p being the inverse gains.
  template <class Derived>
  Eigen::Matrix<double, Derived::RowsAtCompileTime, 8> by_inputs(const Eigen::MatrixBase<Derived>& by_locals,
                                                                 const FieldFitPoint& at) const {
    Eigen::Matrix<double, Derived::RowsAtCompileTime, 8> out = by_locals;
    for (int i = 0; i < 3; ++i) out.col(i) *= at.x[static_cast<std::size_t>(i)];
    out.template middleCols<3>(3) = by_locals.template middleCols<3>(3).lazyProduct(tilt);
    return out;
  }
};

/// Everything at one point.
struct MsaChain::Linearised {
  FieldFitPoint at;
  std::vector<Station> stations;
  std::vector<int> rows_of_run;  ///< of the normals of the run in z
  std::vector<Vector3d> tangents;
  std::vector<Matrix3d> position_by_tangent;
  Matrix83d multipliers;        ///< lambda_a: columns
  MatrixOfRun unknowns_of_run;  ///< X of the run's normals
  Matrix8d covariance;          ///< of the unknowns, X X'
  Eigen::Matrix3Xd first;       ///< J
};

namespace {

/// The unknowns at the nominal tool, whose readings the clean ones are.
FieldFitPoint point_of_tool(const sensor::MagnetometerErrors& errors, double total) {
  FieldFitPoint p;
  for (std::size_t i = 0; i < 3; ++i) {
    p.x[i] = 1 / errors.gain[i];
    p.x[3 + i] = errors.bias[i] / (errors.gain[i] * total);
  }
  return p;
}

}  // namespace

MsaChain::MsaChain(MsaTrials trials, const estimate::EstimatorOptions& options)
    : trials_(std::move(trials)),
      model_(estimate::field_fit_model(options, trials_.field)),
      normals_(sensor::reading_normals(trials_.survey.size(), trials_.noise, trials_.spread)),
      estimator_(estimate::make_estimator(options, trials_.field, sensor::station_fields(trials_.clean),
                                          trials_.clean.magnetic_T)),
      at_truth_(point_of_tool(trials_.errors, model_.total)),
      md_(trials_.survey.md()),
      truth_(survey::minimum_curvature_positions(trials_.survey).back()) {}

// ------------------------------------------------------------------------------------------------ values

survey::ReadingBlock MsaChain::readings_of(const MatrixXd& z) const {
  const int count = static_cast<int>(z.cols());
  survey::ReadingBlock readings = sensor::make_reading_block(count, trials_.survey.size(), trials_.noise);
  survey::LaneArray lanes(readings.groups(), static_cast<int>(z.rows()));
  for (int t = 0; t < count; ++t)
    for (Eigen::Index r = 0; r < z.rows(); ++r)
      lanes.row(t / simd::kGroup, static_cast<int>(r))[t % simd::kGroup] = z(r, t);
  sensor::readings_of_normals(trials_.clean, trials_.field, trials_.noise, trials_.spread, normals_, lanes,
                              readings.groups(), readings);
  return readings;
}

Eigen::Matrix3Xd MsaChain::positions_of(const survey::ReadingBlock& readings,
                                        const std::vector<FieldFitPoint>& estimates) const {
  survey::LaneArray parameters(readings.groups(), 6), position(readings.groups(), 3);
  for (int t = 0; t < readings.groups() * simd::kGroup; ++t) {
    const FieldFitPoint& e = estimates[std::min(static_cast<std::size_t>(t), estimates.size() - 1)];
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(i);
      parameters.row(t / simd::kGroup, i)[t % simd::kGroup] = 1 / e.x[a];
      parameters.row(t / simd::kGroup, 3 + i)[t % simd::kGroup] = e.x[3 + a] / e.x[a] * model_.total;
    }
  }
  survey::corrected_final_positions(readings, parameters, md_, trials_.field.declination, position);
  Eigen::Matrix3Xd out(3, readings.trials);
  for (int t = 0; t < readings.trials; ++t)
    for (int i = 0; i < 3; ++i)
      out(i, t) = estimates[static_cast<std::size_t>(t)].converged ? position.value(t, i) - truth_[i] : kNaN;
  return out;
}

Eigen::Matrix3Xd MsaChain::values(const MatrixXd& z) const {
  const survey::ReadingBlock readings = readings_of(z);
  estimate::EstimateBlock estimates(readings.trials);
  estimator_->solve(readings, estimates);
  std::vector<FieldFitPoint> points;
  for (int t = 0; t < readings.trials; ++t) points.push_back(estimate::field_fit_point(model_, estimates, readings, t));
  return positions_of(readings, points);
}

namespace {

constexpr double kStepTolerance = 1e-9, kSamePoint = 1e-6;

double distance(const FieldFitPoint& a, const FieldFitPoint& b) {
  double d = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) d = std::max(d, std::abs(a.x[i] - b.x[i]));
  return d;
}

/// Goes along the points of a path outward from the centre. Where the next point does not continue the line of the last
/// two, its estimate is sought by Newton's steps from the truth and from the point before, and the lower cost holds;
/// and so on for as long as that is another estimate than the first one.
void follow_branch(const std::vector<int>& order, const estimate::FieldFitModel& model,
                   const survey::ReadingBlock& readings, const FieldFitPoint& truth,
                   std::vector<FieldFitPoint>& points) {
  constexpr double kBend = 0.25;  // of the last step: at a step of 0.05 of a normal a smooth path bends less
  bool is_sought = false;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const FieldFitPoint& last = points[static_cast<std::size_t>(order[i - 1])];
    FieldFitPoint& next = points[static_cast<std::size_t>(order[i])];
    if (!last.converged || !next.converged) {
      is_sought = true;
    } else if (i >= 2) {
      const double before = distance(points[static_cast<std::size_t>(order[i - 2])], last);
      is_sought = is_sought || distance(last, next) > (1 + kBend) * before;
    }
    if (!is_sought) continue;
    FieldFitPoint best = estimate::field_fit_from(model, readings, order[i], truth, kStepTolerance);
    if (last.converged) {
      const FieldFitPoint near = estimate::field_fit_from(model, readings, order[i], last, kStepTolerance);
      if (near.converged && !(best.converged && best.cost <= near.cost)) best = near;
    }
    is_sought = best.converged && distance(best, next) > kSamePoint;
    if (best.converged) next = best;
  }
}

}  // namespace

orders::Path MsaChain::path(const VectorXd& v, const std::vector<double>& t) const {
  const int count = static_cast<int>(t.size());
  MatrixXd z(v.size(), count);
  for (int i = 0; i < count; ++i) z.col(i) = t[static_cast<std::size_t>(i)] * v;
  const survey::ReadingBlock readings = readings_of(z);
  estimate::EstimateBlock estimates(count);
  estimator_->solve(readings, estimates);
  std::vector<FieldFitPoint> points;
  int centre = 0;
  for (int i = 0; i < count; ++i) {
    points.push_back(estimate::field_fit_point(model_, estimates, readings, i));
    if (std::abs(t[static_cast<std::size_t>(i)]) < std::abs(t[static_cast<std::size_t>(centre)])) centre = i;
  }
  for (const int step : {1, -1}) {
    std::vector<int> order;
    for (int i = centre; i >= 0 && i < count; i += step) order.push_back(i);
    follow_branch(order, model_, readings, at_truth_, points);
  }
  orders::Path out{positions_of(readings, points), MatrixXd(kUnknowns, count)};
  for (int i = 0; i < count; ++i) out.states.col(i) = Vector8d(points[static_cast<std::size_t>(i)].x.data());
  return out;
}

// ------------------------------------------------------------------------------------------------ derivatives

MsaChain::Linearised MsaChain::linearise(const VectorXd& z, const VectorXd& state) const {
  const auto n = static_cast<std::size_t>(trials_.survey.size());
  const sensor::NoiseModel& noise = trials_.noise;
  const double total = model_.total, gravity = trials_.field.gravity;
  const bool is_of_run = noise.reference == sensor::ReferenceNoise::per_run;
  Linearised l;
  // The estimate at z, on the branch of the state, to the last digits: differences of derivatives are taken.
  FieldFitPoint start;
  std::copy_n(state.data(), kUnknowns, start.x.begin());
  constexpr double kExact = 1e-12;
  l.at = estimate::field_fit_from(model_, readings_of(z), 0, start, kExact);
  const std::array<double, 8>& x = l.at.x;

  if (is_of_run) l.rows_of_run = {normals_.reference, normals_.reference + 1};
  if (normals_.tool >= 0)
    for (int i = 0; i < 6; ++i) l.rows_of_run.push_back(normals_.tool + i);
  const auto of_run = static_cast<Eigen::Index>(l.rows_of_run.size());
  VectorXd z_of_run(of_run);
  for (Eigen::Index i = 0; i < of_run; ++i) z_of_run[i] = z[l.rows_of_run[static_cast<std::size_t>(i)]];

  const double sin_dec = std::sin(trials_.field.declination), cos_dec = std::cos(trials_.field.declination);
  const Vector8d unknown_sizes = [&] {  // of z
    Vector8d s = Vector8d::Zero();
    if (model_.joint) s.tail<2>() << model_.total_sd, model_.dip_sd;
    return s;
  }();
  l.stations.resize(n);
  Matrix8d normal = Matrix8d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    Station& s = l.stations[k];
    s.y << survey::to_eigen(trials_.clean.magnetic_T[k]) / total,
        survey::to_eigen(trials_.clean.gravity_T[k]) / gravity, trials_.field.total / total, trials_.field.dip;
    s.size.setZero();
    s.row.fill(-1);
    const auto draw = [&](int first, int row, int count, double size) {
      for (int i = 0; i < count; ++i) {
        s.row[static_cast<std::size_t>(first + i)] = row + i;
        s.size[first + i] = size;
        s.y[first + i] += size * z[row + i];
      }
    };
    const int station = static_cast<int>(k);
    draw(0, normals_.magnetometer + 3 * station, 3, noise.magnetometer / total);
    if (normals_.accelerometer >= 0) draw(3, normals_.accelerometer + 3 * station, 3, noise.accelerometer / gravity);
    if (noise.reference == sensor::ReferenceNoise::per_station) {
      draw(kGivenTotal, normals_.reference + 2 * station, 1, noise.reference_total / total);
      draw(kGivenDip, normals_.reference + 2 * station + 1, 1, noise.reference_dip);
    }
    s.of_run = MatrixOfRun::Zero(8, of_run);
    Eigen::Index at = 0;
    if (is_of_run) {
      s.of_run(kGivenTotal, at++) = noise.reference_total / total;
      s.of_run(kGivenDip, at++) = noise.reference_dip;
    }
    if (normals_.tool >= 0)
      for (int i = 0; i < 6; ++i) {
        const double sd = trials_.spread.sd(static_cast<std::size_t>(i));
        s.of_run(i % 3, at++) = (i < 3 ? sd * survey::to_eigen(trials_.clean.field_T[k])[i] : sd) / total;
      }
    s.y += s.of_run * z_of_run;

    // The station's variables and functions.
    const Vector3d read = s.y.segment<3>(3), down = read.normalized();
    s.gravity = read.norm();
    s.tilt = (Matrix3d::Identity() - down * down.transpose()) / s.gravity;
    std::array<Jet8, 3> b, u, north, h;
    for (std::size_t i = 0; i < 3; ++i) {
      b[i] = Jet8::variable(x[i] * s.y[static_cast<Eigen::Index>(i)] - x[3 + i], i);
      u[i] = Jet8::variable(down[static_cast<Eigen::Index>(i)], 3 + i);
    }
    const Jet8 fitted_total = Jet8::variable(s.y[kGivenTotal] + unknown_sizes[kGivenTotal] * x[6], kGivenTotal),
               dip = Jet8::variable(s.y[kGivenDip] + unknown_sizes[kGivenDip] * x[7], kGivenDip);
    const auto [sine, cosine] = sincos(dip);
    const Jet8 bv = u[0] * b[0] + u[1] * b[1] + u[2] * b[2];
    for (std::size_t i = 0; i < 3; ++i) h[i] = b[i] - bv * u[i];
    const Jet8 bh = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]), per_bh = reciprocal(bh);
    const Jet8 rh = bh - fitted_total * cosine, rv = bv - fitted_total * sine;
    const Jet8 fh = model_.w_hh * rh + model_.w_hv * rv, fv = model_.w_hv * rh + model_.w_vv * rv;
    for (std::size_t i = 0; i < 3; ++i) {
      north[i] = per_bh * h[i];
      s.slope[i] = fh * north[i] + fv * u[i];
      if (model_.fitted_derivative) s.fitted[i] = s.slope[i] * (rh * north[i] + rv * u[i]);
    }
    if (model_.joint) {
      s.by_total = -(fh * cosine + fv * sine);
      s.by_dip = fitted_total * (fh * sine - fv * cosine);
    }
    const Jet8 east = per_bh * (u[0] * b[1] - u[1] * b[0]);
    s.tangent = {cos_dec * north[2] - sin_dec * east, sin_dec * north[2] + cos_dec * east, u[2]};

    s.factor << s.y.head<3>(), -1, -1, -1, unknown_sizes.tail<2>();
    // g and its derivatives: rows of p, q are y_i d phi/db_i (less `fitted` / p_i) and -d phi/db_i.
    Matrix8d by_locals = Matrix8d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const Vector8d d = gradient(s.slope[i]);
      by_locals.row(row) = s.y[row] * d.transpose();
      by_locals.row(3 + row) = -d.transpose();
      if (model_.fitted_derivative) by_locals.row(row) -= gradient(s.fitted[i]).transpose() / x[i];
    }
    if (model_.joint) {
      by_locals.row(6) = unknown_sizes[6] * gradient(s.by_total).transpose();
      by_locals.row(7) = unknown_sizes[7] * gradient(s.by_dip).transpose();
    }
    for (int i = 0; i < kUnknowns; ++i)
      normal.col(i) += s.factor[i] * by_locals.col(Station::moved[static_cast<std::size_t>(i)]);
    s.residual_by_inputs = s.by_inputs(by_locals, l.at);
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(i);
      s.residual_by_inputs(i, i) += s.slope[a].a;
      if (model_.fitted_derivative) normal(i, i) += s.fitted[a].a / (x[a] * x[a]);
    }
    Matrix38d tangent_by_locals;
    for (int i = 0; i < 3; ++i) tangent_by_locals.row(i) = gradient(s.tangent[static_cast<std::size_t>(i)]).transpose();
    for (int i = 0; i < kUnknowns; ++i)
      s.tangent_by_unknowns.col(i) = s.factor[i] * tangent_by_locals.col(Station::moved[static_cast<std::size_t>(i)]);
    s.tangent_by_inputs = s.by_inputs(tangent_by_locals, l.at);
    l.tangents.emplace_back(s.tangent[0].a, s.tangent[1].a, s.tangent[2].a);
  }
  for (int i = 0; i < 3; ++i) {
    normal(i, i) += model_.gain_prior;
    normal(3 + i, 3 + i) += model_.bias_prior[static_cast<std::size_t>(i)];
  }
  if (model_.joint) normal.diagonal().tail<2>().array() += model_.unit_weight;
  std::array<bool, 8> is_unknown{};
  for (int i = 0; i < kUnknowns; ++i) {
    const auto a = static_cast<std::size_t>(i);
    is_unknown[a] = i < 6 ? model_.estimated[a] : model_.joint;
    if (is_unknown[a]) continue;
    normal.row(i).setZero();
    normal.col(i).setZero();
    normal(i, i) = 1;
    for (Station& s : l.stations) s.residual_by_inputs.row(i).setZero();
  }
  const Matrix8d inverse = normal.inverse();

  std::vector<survey::Vec3<double>> tangents;
  for (const Vector3d& t : l.tangents) tangents.push_back(survey::from_eigen(t));
  l.position_by_tangent = survey::final_position_by_tangent(md_, tangents);
  Matrix38d position_by_unknowns = Matrix38d::Zero();
  for (std::size_t k = 0; k < n; ++k)
    position_by_unknowns += l.position_by_tangent[k] * l.stations[k].tangent_by_unknowns;
  l.multipliers = -(position_by_unknowns * inverse).transpose();
  for (int i = 0; i < kUnknowns; ++i)
    if (!is_unknown[static_cast<std::size_t>(i)]) l.multipliers.row(i).setZero();

  l.unknowns_of_run = MatrixOfRun::Zero(8, of_run);
  l.covariance.setZero();
  l.first = Eigen::Matrix3Xd::Zero(3, z.size());
  Eigen::Matrix3Xd first_of_run = Eigen::Matrix3Xd::Zero(3, of_run);
  for (std::size_t k = 0; k < n; ++k) {
    Station& s = l.stations[k];
    s.unknowns_by_inputs = -inverse.lazyProduct(s.residual_by_inputs);
    l.unknowns_of_run += s.unknowns_by_inputs.lazyProduct(s.of_run);
    const Matrix8d own = s.unknowns_by_inputs * s.size.asDiagonal();
    l.covariance += own.lazyProduct(own.transpose());
    const Matrix38d by_inputs = l.position_by_tangent[k].lazyProduct(s.tangent_by_inputs) +
                                l.multipliers.transpose().lazyProduct(s.residual_by_inputs);
    first_of_run += by_inputs.lazyProduct(s.of_run);
    for (int i = 0; i < kInputs; ++i)
      if (const int row = s.row[static_cast<std::size_t>(i)]; row >= 0) l.first.col(row) = s.size[i] * by_inputs.col(i);
  }
  for (Eigen::Index i = 0; i < of_run; ++i)
    l.first.col(l.rows_of_run[static_cast<std::size_t>(i)]) = first_of_run.col(i);
  l.covariance += l.unknowns_of_run * l.unknowns_of_run.transpose();
  return l;
}

namespace {

/// L_a'' of one station, without the legs: by unknowns, by unknowns and inputs, by inputs.
struct StationBend {
  Matrix8d xx, xy, yy;
};

/// Covariances of a station's inputs y and its tangent t with the unknowns x and each other.
struct StationCovariance {
  Matrix8d xy, yy;
  Matrix83d xt;
  Matrix3d tt;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 8> tangent_of_run;  ///< dt by the run's normals, x held
};

/// The matrices by which tr(H_a H_b) is summed: H = A'Z + Z'A + D (A: the unknowns and the run's normals by all
/// normals; D: blocks of a station and of neighbours).
struct SquareSums {
  std::array<std::vector<Matrix8d>, 3> xy, yy, before;  ///< of L'': station and station; station before and station
  std::array<Matrix8d, 3> xx;
};

}  // namespace

orders::Expansion MsaChain::expand(const VectorXd& z, const VectorXd& state,
                                   const orders::ExpansionParts& parts) const {
  const Linearised l = linearise(z, state);
  const std::size_t n = l.stations.size();
  const std::array<double, 8>& x = l.at.x;
  const auto of_run = static_cast<Eigen::Index>(l.rows_of_run.size());
  orders::Expansion e;
  e.first = l.first;
  if (!l.at.converged) {
    e.first.setConstant(kNaN);
    e.trace.setConstant(kNaN);
    for (MatrixXd& m : e.along) m = MatrixXd::Constant(z.size(), parts.directions.cols(), kNaN);
    e.squares.setConstant(kNaN);
    return e;
  }
  e.trace.setZero();

  // What the directions do to the unknowns and the stations.
  const Eigen::Index directions = parts.directions.cols();
  MatrixXd v_of_run(of_run, directions);
  for (Eigen::Index i = 0; i < of_run; ++i)
    v_of_run.row(i) = parts.directions.row(l.rows_of_run[static_cast<std::size_t>(i)]);
  MatrixXd dx = l.unknowns_of_run * v_of_run;
  std::vector<MatrixXd> dy(directions > 0 ? n : 0);
  for (std::size_t k = 0; k < dy.size(); ++k) {
    const Station& s = l.stations[k];
    MatrixXd own = MatrixXd::Zero(kInputs, directions);
    for (int i = 0; i < kInputs; ++i)
      if (const int row = s.row[static_cast<std::size_t>(i)]; row >= 0)
        own.row(i) = s.size[i] * parts.directions.row(row);
    dx += s.unknowns_by_inputs * own;
    dy[k] = own + s.of_run * v_of_run;
  }
  std::array<MatrixXd, 3> bend_x;               // L'' v, by unknowns
  std::array<std::vector<MatrixXd>, 3> bend_y;  // and by the inputs of every station
  for (std::size_t a = 0; a < 3; ++a) {
    bend_x[a] = MatrixXd::Zero(kUnknowns, directions);
    bend_y[a].assign(dy.size(), MatrixXd::Zero(kInputs, directions));
  }
  SquareSums squares;
  if (parts.squares)
    for (std::size_t a = 0; a < 3; ++a) {
      squares.xx[a].setZero();
      squares.xy[a].assign(n, Matrix8d::Zero());
      squares.yy[a].assign(n, Matrix8d::Zero());
      squares.before[a].assign(n, Matrix8d::Zero());
    }

  StationCovariance before{};
  for (std::size_t k = 0; k < n; ++k) {
    const Station& s = l.stations[k];
    StationCovariance c;
    c.xy = s.unknowns_by_inputs * s.size.cwiseAbs2().asDiagonal();
    c.xy += l.unknowns_of_run.lazyProduct(s.of_run.transpose());
    c.yy = s.of_run.lazyProduct(s.of_run.transpose());
    c.yy.diagonal() += s.size.cwiseAbs2();
    c.xt = l.covariance.lazyProduct(s.tangent_by_unknowns.transpose());
    c.xt += c.xy.lazyProduct(s.tangent_by_inputs.transpose());
    Matrix83d yt = c.xy.transpose().lazyProduct(s.tangent_by_unknowns.transpose());
    yt += c.yy.lazyProduct(s.tangent_by_inputs.transpose());
    c.tt = s.tangent_by_unknowns.lazyProduct(c.xt);
    c.tt += s.tangent_by_inputs.lazyProduct(yt);
    c.tangent_of_run = s.tangent_by_inputs.lazyProduct(s.of_run);
    const Vector3d down = s.y.segment<3>(3) / s.gravity;
    const Matrix3d across = s.tilt * s.gravity;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto column = static_cast<Eigen::Index>(a);
      const Vector8d lambda = l.multipliers.col(column);
      // The function's gradient and second derivatives by the variables: a sum of the station's functions.
      Vector8d g = Vector8d::Zero();
      Matrix8d p = Matrix8d::Zero();
      const auto add = [&](double factor, const Jet8& f) {
        g += factor * gradient(f);
        add_hessian(factor, f, p);
      };
      for (std::size_t i = 0; i < 3; ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        add(l.position_by_tangent[k](column, at), s.tangent[i]);
        add(lambda[at] * s.y[at] - lambda[3 + at], s.slope[i]);
        if (model_.fitted_derivative) add(-lambda[at] / x[i], s.fitted[i]);
      }
      if (model_.joint) {
        add(lambda[6] * s.factor[6], s.by_total);
        add(lambda[7] * s.factor[7], s.by_dip);
      }
      StationBend m;
      const Matrix8d by_inputs = s.by_inputs(p, l.at);
      m.yy = s.by_inputs(by_inputs.transpose(), l.at);
      for (int i = 0; i < kUnknowns; ++i) {
        const int at = Station::moved[static_cast<std::size_t>(i)];
        m.xy.row(i) = s.factor[i] * by_inputs.row(at);
        for (int j = 0; j < kUnknowns; ++j)
          m.xx(i, j) = s.factor[i] * s.factor[j] * p(at, Station::moved[static_cast<std::size_t>(j)]);
      }
      // b = p y - q is bilinear; lambda'g has y before d phi/db, and `fitted` / p.
      for (int i = 0; i < 3; ++i) {
        const auto at = static_cast<std::size_t>(i);
        m.xy(i, i) += g[i];
        const auto add_product = [&](double factor, const Vector8d& by_locals, auto&& to_unknowns, auto&& to_inputs) {
          for (int j = 0; j < kUnknowns; ++j)
            to_unknowns(j, factor * s.factor[j] * by_locals[Station::moved[static_cast<std::size_t>(j)]]);
          to_inputs(factor * s.by_inputs(Eigen::Matrix<double, 1, 8>(by_locals.transpose()), l.at));
        };
        add_product(
            lambda[i], gradient(s.slope[at]), [&](int j, double value) { m.xy(j, i) += value; },
            [&](const Eigen::Matrix<double, 1, 8>& row) {
              m.yy.row(i) += row;
              m.yy.col(i) += row.transpose();
            });
        if (!model_.fitted_derivative) continue;
        add_product(
            lambda[i] / (x[at] * x[at]), gradient(s.fitted[at]),
            [&](int j, double value) {
              m.xx(i, j) += value;
              m.xx(j, i) += value;
            },
            [&](const Eigen::Matrix<double, 1, 8>& row) { m.xy.row(i) += row; });
        m.xx(i, i) -= 2 * lambda[i] * s.fitted[at].a / (x[at] * x[at] * x[at]);
      }
      // u = a / |a|: u'' = -(2 (u.da) da_across + u |da_across|^2) / |a|^2
      const Vector3d gu = g.segment<3>(3), gu_across = across * gu;
      m.yy.block<3, 3>(3, 3) -= (gu_across * down.transpose() + down * gu_across.transpose() + gu.dot(down) * across) /
                                (s.gravity * s.gravity);

      e.trace[column] += inner(m.xx, l.covariance) + 2 * inner(m.xy, c.xy) + inner(m.yy, c.yy);
      if (directions > 0) {
        bend_x[a] += m.xx.lazyProduct(dx) + m.xy.lazyProduct(dy[k]);
        bend_y[a][k] += m.xy.transpose().lazyProduct(dx) + m.yy.lazyProduct(dy[k]);
      }
      if (parts.squares) {
        squares.xx[a] += m.xx;
        squares.xy[a][k] += m.xy;
        squares.yy[a][k] += m.yy;
      }
    }
    if (k > 0) {
      const Station& last = l.stations[k - 1];
      const auto h = leg_hessian(md_[k] - md_[k - 1], l.tangents[k - 1], l.tangents[k]);
      // Covariance of both tangents. Those of two stations have the unknowns and the run's normals in common.
      Matrix83d y_last = before.xy.transpose().lazyProduct(s.tangent_by_unknowns.transpose());
      y_last += last.of_run.lazyProduct(c.tangent_of_run.transpose());
      Matrix3d between = last.tangent_by_unknowns.lazyProduct(c.xt);
      between += last.tangent_by_inputs.lazyProduct(y_last);
      Matrix6d tangents;
      tangents << before.tt, between, between.transpose(), c.tt;
      for (std::size_t a = 0; a < 3; ++a) {
        e.trace[static_cast<Eigen::Index>(a)] += inner(h[a], tangents);
        const Matrix3d h00 = h[a].topLeftCorner<3, 3>(), h01 = h[a].topRightCorner<3, 3>(),
                       h11 = h[a].bottomRightCorner<3, 3>();
        if (directions > 0) {
          const Eigen::Matrix3Xd d0 = last.tangent_by_unknowns * dx + last.tangent_by_inputs * dy[k - 1],
                                 d1 = s.tangent_by_unknowns * dx + s.tangent_by_inputs * dy[k],
                                 f0 = h00 * d0 + h01 * d1, f1 = h01.transpose() * d0 + h11 * d1;
          bend_x[a] += last.tangent_by_unknowns.transpose() * f0 + s.tangent_by_unknowns.transpose() * f1;
          bend_y[a][k - 1] += last.tangent_by_inputs.transpose() * f0;
          bend_y[a][k] += s.tangent_by_inputs.transpose() * f1;
        }
        if (parts.squares) {
          const Matrix38d x0 = h00.lazyProduct(last.tangent_by_unknowns) + h01.lazyProduct(s.tangent_by_unknowns),
                          x1 = h01.transpose().lazyProduct(last.tangent_by_unknowns) +
                               h11.lazyProduct(s.tangent_by_unknowns),
                          y0 = h00.lazyProduct(last.tangent_by_inputs), y1 = h11.lazyProduct(s.tangent_by_inputs),
                          y01 = h01.lazyProduct(s.tangent_by_inputs);
          squares.xx[a] += last.tangent_by_unknowns.transpose().lazyProduct(x0);
          squares.xx[a] += s.tangent_by_unknowns.transpose().lazyProduct(x1);
          squares.xy[a][k - 1] += x0.transpose().lazyProduct(last.tangent_by_inputs);
          squares.xy[a][k] += x1.transpose().lazyProduct(s.tangent_by_inputs);
          squares.yy[a][k - 1] += last.tangent_by_inputs.transpose().lazyProduct(y0);
          squares.yy[a][k] += s.tangent_by_inputs.transpose().lazyProduct(y1);
          squares.before[a][k] += last.tangent_by_inputs.transpose().lazyProduct(y01);
        }
      }
    }
    before = c;
  }

  for (std::size_t a = 0; a < 3; ++a) {
    e.along[a] = MatrixXd::Zero(z.size(), directions);
    if (directions == 0) continue;
    MatrixXd along_run = l.unknowns_of_run.transpose() * bend_x[a];
    for (std::size_t k = 0; k < n; ++k) {
      const Station& s = l.stations[k];
      const MatrixXd by_inputs = s.unknowns_by_inputs.transpose() * bend_x[a] + bend_y[a][k];
      along_run += s.of_run.transpose() * bend_y[a][k];
      for (int i = 0; i < kInputs; ++i)
        if (const int row = s.row[static_cast<std::size_t>(i)]; row >= 0)
          e.along[a].row(row) = s.size[i] * by_inputs.row(i);
    }
    for (Eigen::Index i = 0; i < of_run; ++i)
      e.along[a].row(l.rows_of_run[static_cast<std::size_t>(i)]) = along_run.row(i);
  }
  if (!parts.squares) return e;

  // H = A'Z + Z'A + D with A = dx/dz of the unknowns and the run's normals, Z = L_xy + L_xx A / 2, D the stations' own:
  //   tr(H_a H_b) = 2 tr(Z_a A' Z_b A') + 2 tr(Z_a Z_b' A A') + 2 tr(Z_a D_b A') + 2 tr(Z_b D_a A') + tr(D_a D_b)
  const Eigen::Index wide = kUnknowns + of_run;
  using Wide = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 16, 16>;
  using WideStation = Eigen::Matrix<double, Eigen::Dynamic, 8, 0, 16, 8>;
  std::vector<Matrix8d> own(n);  // rows of A: of a station's normals the others are zero
  Wide of_normals(wide, of_run);
  of_normals << l.unknowns_of_run, MatrixXd::Identity(of_run, of_run);
  Wide aa = of_normals * of_normals.transpose();
  for (std::size_t k = 0; k < n; ++k) {
    own[k] = l.stations[k].unknowns_by_inputs * l.stations[k].size.asDiagonal();
    aa.topLeftCorner<8, 8>() += own[k].lazyProduct(own[k].transpose());
  }
  struct Factors {
    Wide z_run, za;                       // Z of the run's normals; Z A'
    std::vector<WideStation> z, az;       // Z of the stations; A A' Z
    std::vector<Matrix8d> d, before, ad;  // D; A D, its first rows
  };
  std::array<Factors, 3> factors;
  for (std::size_t a = 0; a < 3; ++a) {
    Factors& f = factors[a];
    Wide xx = Wide::Zero(wide, wide);
    xx.topLeftCorner<8, 8>() = squares.xx[a];
    for (std::size_t k = 0; k < n; ++k) {
      const Station& s = l.stations[k];
      WideStation xy(wide, 8);  // what the station bends, by unknowns and the run's normals
      xy.topRows<8>() = squares.xy[a][k];
      xy.bottomRows(of_run) = s.of_run.transpose().lazyProduct(squares.yy[a][k]);
      if (k > 0) xy.bottomRows(of_run) += l.stations[k - 1].of_run.transpose().lazyProduct(squares.before[a][k]);
      if (k + 1 < n)
        xy.bottomRows(of_run) += l.stations[k + 1].of_run.transpose().lazyProduct(squares.before[a][k + 1].transpose());
      const Wide by_run = xy.lazyProduct(s.of_run);
      xx.topRightCorner(8, of_run) += by_run.topRows(8);
      xx.bottomRightCorner(of_run, of_run) += by_run.bottomRows(of_run);
      f.z.push_back(xy * s.size.asDiagonal());
      f.d.push_back(s.size.asDiagonal() * squares.yy[a][k] * s.size.asDiagonal());
      f.before.push_back(
          k == 0 ? Matrix8d(Matrix8d::Zero())
                 : Matrix8d(l.stations[k - 1].size.asDiagonal() * squares.before[a][k] * s.size.asDiagonal()));
    }
    xx.bottomLeftCorner(of_run, 8) = xx.topRightCorner(8, of_run).transpose();
    f.z_run = 0.5 * xx * of_normals;
    f.za = f.z_run * of_normals.transpose();
    for (std::size_t k = 0; k < n; ++k) {
      f.z[k] += 0.5 * xx.leftCols<8>().lazyProduct(own[k]);
      f.za.leftCols<8>() += f.z[k].lazyProduct(own[k].transpose());
      f.az.push_back(aa.lazyProduct(f.z[k]));
      f.ad.push_back(own[k].lazyProduct(f.d[k]));
      if (k > 0) f.ad[k] += own[k - 1].lazyProduct(f.before[k]);
      if (k + 1 < n) f.ad[k] += own[k + 1].lazyProduct(f.before[k + 1].transpose());
    }
  }
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      const Factors &fa = factors[a], &fb = factors[b];
      double sum = 2 * (fa.za * fb.za).trace() + 2 * inner(fa.z_run, aa * fb.z_run);
      for (std::size_t k = 0; k < n; ++k)
        sum += 2 * (inner(fa.z[k], fb.az[k]) + inner(fa.z[k].topRows<8>(), fb.ad[k]) +
                    inner(fb.z[k].topRows<8>(), fa.ad[k]) + inner(fa.before[k], fb.before[k])) +
               inner(fa.d[k], fb.d[k]);
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      e.squares(i, j) = e.squares(j, i) = sum;
    }
  return e;
}

MatrixXd MsaChain::unknowns_by_own_normals(const Linearised& l) const {
  MatrixXd by_own = MatrixXd::Zero(kUnknowns, dimension());
  for (const Station& s : l.stations)
    for (int i = 0; i < kInputs; ++i)
      if (const int row = s.row[static_cast<std::size_t>(i)]; row >= 0)
        by_own.col(row) = s.size[i] * s.unknowns_by_inputs.col(i);
  return by_own;
}

Vector6d MsaChain::parameters(const VectorXd& state) const {
  const Eigen::Array3d gain = state.head<3>().array().inverse();
  Vector6d x;
  x << gain, state.segment<3>(3).array() * gain * model_.total;
  return x;
}

MatrixXd MsaChain::parameters_by_normals(const VectorXd& z, const VectorXd& state) const {
  const Linearised l = linearise(z, state);
  if (!l.at.converged) return MatrixXd::Constant(6, z.size(), kNaN);
  MatrixXd unknowns = unknowns_by_own_normals(l);
  for (std::size_t i = 0; i < l.rows_of_run.size(); ++i)
    unknowns.col(l.rows_of_run[i]) = l.unknowns_of_run.col(static_cast<Eigen::Index>(i));
  MatrixXd out(6, z.size());
  for (int i = 0; i < 3; ++i) {  // gain = 1 / p, bias = total q / p
    const double p = l.at.x[static_cast<std::size_t>(i)], q = l.at.x[static_cast<std::size_t>(3 + i)];
    out.row(i) = -unknowns.row(i) / (p * p);
    out.row(3 + i) = model_.total * (unknowns.row(3 + i) / p - unknowns.row(i) * q / (p * p));
  }
  return out;
}

MatrixXd MsaChain::directions(const VectorXd& state) const {
  const Linearised l = linearise(VectorXd::Zero(dimension()), state);
  MatrixXd by_own = unknowns_by_own_normals(l);
  // In units of each unknown's sd: which are then told from rounding.
  std::vector<VectorXd> basis;
  for (const int row : l.rows_of_run) basis.push_back(VectorXd::Unit(dimension(), row));
  std::vector<int> moving;
  for (int i = 0; i < kUnknowns; ++i)
    if (const double sd = by_own.row(i).norm(); sd > 0) {
      by_own.row(i) /= sd;
      moving.push_back(i);
    }
  const stats::SingularValues svd = stats::singular_values(by_own(moving, Eigen::all));
  for (Eigen::Index i = 0; i < svd.values.size(); ++i)
    if (svd.values[i] > 1e-9 * svd.values[0]) basis.push_back(svd.right.col(i));
  MatrixXd out(dimension(), static_cast<Eigen::Index>(basis.size()));
  for (std::size_t i = 0; i < basis.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = basis[i];
  return out;
}

}  // namespace surveymc::analysis
