#include "analysis/corrected_survey.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/ranges.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "analysis/robust_claim.h"
#include "base/error.h"
#include "base/units.h"
#include "multistation/model.h"
#include "propagate/station_effects.h"
#include "stats/linear_algebra.h"

namespace surveymc::analysis {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr int kGainsAndBiases = 6;  // parameters of one kind of estimate; the other has all of the table

/// `N`: how many parameters.
template <int N>
using MatrixNr = Eigen::Matrix<double, N, static_cast<int>(kRunInputs)>;
template <int N>
using VectorN = Eigen::Matrix<double, N, 1>;
template <int N>
using MatrixN = Eigen::Matrix<double, N, N>;
using Matrix3r = Eigen::Matrix<double, 3, static_cast<int>(kRunInputs)>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr std::array<bool, 6> kBiases{false, false, false, true, true, true},
    kAxialBias{false, false, false, false, false, true};

std::array<double, kRunInputs> run_sizes(const propagate::CodeDraws& d, const survey::ReferenceField& field) {
  std::array<double, kRunInputs> sizes{};
  std::copy(d.sensors.begin(), d.sensors.end(), sizes.begin());
  sizes[kInterference] = d.interference;
  sizes[kTotalField] = d.run.total;
  sizes[kDip] = d.run.dip;
  sizes[kDeclination] = d.run.declination_in(field);
  return sizes;
}

/// How the down direction of a station follows biases and scales of its accelerometers, per unit.
Matrix36d down_by_accelerometers(const Vector3d& u, double gravity) {
  const Matrix3d across = Matrix3d::Identity() - u * u.transpose();
  Matrix36d d;
  d.leftCols<3>() = across / gravity;
  d.rightCols<3>() = across * u.asDiagonal();
  return d;
}

/// Response of an estimate less the truth to the inputs of size 1.
template <int N>
struct Response {
  MatrixNr<N> run = MatrixNr<N>::Zero();
  std::vector<Eigen::Matrix<double, N, 2>> station;  ///< total field and dip of the true field; empty: no response
  std::vector<Eigen::Matrix<double, N, 3>> noise;    ///< of a reading, axes x, y, z; empty: no response
};
using SixResponse = Response<kGainsAndBiases>;
using SetResponse = Response<multistation::kParameters>;

/// Readings taken as they are: an estimate of gains 1 and biases 0, which misses the whole error.
SixResponse no_response() {
  SixResponse r;
  for (int axis = 0; axis < 3; ++axis) {
    r.run(axis, survey::kMagnetometerScale + axis) = -1;
    r.run(3 + axis, survey::kMagnetometerBias + axis) = -1;
  }
  r.run(5, static_cast<int>(kInterference)) = -1;
  return r;
}

SixResponse response_of(const estimate::Sensitivity& s, const std::vector<survey::StationFields>& fields,
                        double gravity) {
  SixResponse r;
  for (int axis = 0; axis < 3; ++axis) {
    r.run.col(survey::kMagnetometerScale + axis) = s.by_truth.col(axis).head<6>();
    r.run.col(survey::kMagnetometerBias + axis) = s.by_truth.col(3 + axis).head<6>();
  }
  r.run.col(static_cast<int>(kInterference)) = s.by_truth.col(5).head<6>();
  r.station.reserve(fields.size());
  r.noise.reserve(fields.size());
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const Eigen::Matrix<double, 6, 3> by_down = s.by_down[k].topRows<6>();
    r.run.leftCols<6>().noalias() +=
        by_down.lazyProduct(down_by_accelerometers(survey::to_eigen(fields[k].down_T), gravity));
    // A reference that is too small is a field that is too large.
    r.station.push_back(-s.by_reference[k].topRows<6>());
    r.noise.push_back(s.by_magnetometer[k].topRows<6>());
    r.run.middleCols<2>(static_cast<int>(kTotalField)) += r.station.back();
  }
  return r;
}

/// How the tangent of a station follows the estimate less the truth, and directly the inputs of the run.
template <int N>
struct StationTangent {
  Eigen::Matrix<double, 3, N> by_estimate;
  Matrix3r direct = Matrix3r::Zero();
};

StationTangent<kGainsAndBiases> station_tangent(const MeasuredStations& s, std::size_t k) {
  StationTangent<kGainsAndBiases> t;
  t.by_estimate.leftCols<3>() = -s.by_field[k] * survey::to_eigen(s.fields[k].field_T).asDiagonal();
  t.by_estimate.rightCols<3>() = -s.by_field[k];
  t.direct.leftCols<6>() =
      s.by_down[k].lazyProduct(down_by_accelerometers(survey::to_eigen(s.fields[k].down_T), s.field.gravity));
  t.direct.col(static_cast<int>(kDeclination)) = s.by_declination[k];
  return t;
}

template <int Columns>
double sum_of_squares(const Eigen::RowVector3d& right, const Eigen::Matrix<double, 3, Columns>& effect) {
  return (right * effect).squaredNorm();
}

template <int Columns>
void add_square(const Eigen::Matrix<double, 3, Columns>& effect, Matrix3d& sum) {
  sum += effect.lazyProduct(effect.transpose());
}

/// Readings of a perfect tool in the field that is its reference.
std::vector<multistation::StationReadings> perfect_readings(const MeasuredStations& s) {
  const multistation::Reference reference =
      multistation::reference_of(multistation::ResidualKind::survey, s.field.gravity, s.field.total, s.field.dip);
  std::vector<multistation::StationReadings> out;
  for (const survey::StationFields& f : s.fields)
    out.push_back({survey::scale(s.field.gravity, f.down_T), f.field_T, reference});
  return out;
}

/// The same of all parameters of the table: an error of the accelerometers that is not estimated is missed by an
/// estimate of 0, and nothing but the declination acts directly.
std::vector<StationTangent<multistation::kParameters>> set_tangents(
    const MeasuredStations& s, const std::vector<multistation::StationReadings>& readings,
    const multistation::FitOptions& o) {
  std::vector<StationTangent<multistation::kParameters>> out;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const multistation::StationModel m = multistation::station_model(readings[k], {}, o.residuals, o.sizes);
    const Vector3d u = survey::to_eigen(s.fields[k].down_T);
    const Matrix3d by_gravity = s.by_down[k] * (Matrix3d::Identity() - u * u.transpose()) / s.field.gravity;
    StationTangent<multistation::kParameters> t;
    t.by_estimate = by_gravity * m.gravity_by_parameter + s.by_field[k] * m.field_by_parameter;
    t.direct.col(static_cast<int>(kDeclination)) = s.by_declination[k];
    out.push_back(t);
  }
  return out;
}

/// A row a parameter of the table: of those that are not estimated 0, less the truth.
SetResponse set_response(const multistation::FitSensitivity& f, const multistation::ParameterSet& set) {
  const auto in_table = [&](const auto& of_set, auto&& out) {
    out.setZero();
    for (int i = 0; i < set.size(); ++i) out.row(set.index(i)) = of_set.row(i);
  };
  SetResponse r;
  MatrixN<multistation::kParameters> by_truth;
  in_table(f.by_truth, by_truth);
  for (int i = 0; i < multistation::kParameters; ++i)
    if (!set.contains(i)) by_truth(i, i) = -1;
  r.run.leftCols<static_cast<int>(survey::kSensorTerms)>() =
      by_truth.leftCols<static_cast<int>(survey::kSensorTerms)>();
  r.run.col(static_cast<int>(kInterference)) = by_truth.col(multistation::kMagnetometerBias + 2);
  for (std::size_t k = 0; k < f.by_reference.size(); ++k) {
    // A reference that is too small is a field that is too large.
    r.station.emplace_back();
    in_table((-f.by_reference[k].rightCols<2>()).eval(), r.station.back());
    r.noise.emplace_back();
    in_table(f.by_magnetic[k], r.noise.back());
    r.run.middleCols<2>(static_cast<int>(kTotalField)) += r.station.back();
  }
  return r;
}

/// Of the normal matrix with a unit diagonal.
double scaled_condition(const Eigen::MatrixXd& posterior) {
  const Eigen::VectorXd per_sd = posterior.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd normal = stats::symmetric_inverse(per_sd.asDiagonal() * posterior * per_sd.asDiagonal());
  const Eigen::VectorXd per_length = normal.diagonal().cwiseSqrt().cwiseInverse(),
                        eigenvalues =
                            stats::symmetric_eigenvalues(per_length.asDiagonal() * normal * per_length.asDiagonal());
  return eigenvalues[eigenvalues.size() - 1] / eigenvalues[0];
}

/// With one estimate for all stations (`shared`), or with one of each station for itself. `loss`: v of the estimate.
template <int N>
CorrectedErrors sum_up(const MeasuredStations& s, const propagate::CodeDraws& draws, double noise,
                       const std::vector<StationTangent<N>>& tangents, const std::vector<Response<N>>& responses,
                       const StationCorrelation& correlation, double loss = 1) {
  using Matrix3N = Eigen::Matrix<double, 3, N>;
  using MatrixN3 = Eigen::Matrix<double, N, 3>;
  const bool shared = responses.size() == 1;
  const std::array<double, kRunInputs> sizes = run_sizes(draws, s.field);
  const Eigen::Map<const Eigen::Matrix<double, static_cast<int>(kRunInputs), 1>> size(sizes.data());
  const double station_declination = draws.station.declination_in(s.field);
  const Vector2d station_size(draws.station.total, draws.station.dip);
  const std::size_t n = s.fields.size();

  Matrix3N through_estimate = Matrix3N::Zero();  // sum_k L_k Y_k
  for (std::size_t k = 0; k < n; ++k) through_estimate += s.lever[k] * tangents[k].by_estimate;
  // Of one input a column at a station: its response, and what it does to the last position.
  const auto station_response = [&](std::size_t k, int column) -> VectorN<N> {
    const Response<N>& r = responses[shared ? 0 : k];
    if (r.station.empty()) return VectorN<N>::Zero();
    return r.station[shared ? k : 0].col(column) * station_size[column];
  };
  const auto noise_response = [&](std::size_t k) -> MatrixN3 {
    const Response<N>& r = responses[shared ? 0 : k];
    if (r.noise.empty()) return MatrixN3::Zero();
    return r.noise[shared ? k : 0] * noise;
  };

  CorrectedErrors out;
  for (Matrix3d& c : out.position) c.setZero();
  out.azimuth.resize(n);
  out.station_reference.resize(n);
  Matrix3r run_position = Matrix3r::Zero();
  // Squares of the responses of all stations: what the inputs of the others do to one station.
  std::array<MatrixN<N>, 3> others;
  for (auto& o : others) o.setZero();
  for (std::size_t k = 0; k < n; ++k) {
    const StationTangent<N>& t = tangents[k];
    const Matrix3r effect = (t.direct + t.by_estimate.lazyProduct(responses[shared ? 0 : k].run)) * size.asDiagonal();
    run_position += s.lever[k] * effect;
    const Eigen::Matrix<double, 1, static_cast<int>(kRunInputs)> lateral = s.right[k] * effect;
    for (std::size_t i = 0; i < kRunInputs; ++i)
      out.azimuth[k][i] = lateral[static_cast<Eigen::Index>(i)] * lateral[static_cast<Eigen::Index>(i)];

    const Matrix3N on_position = shared ? through_estimate : Matrix3N(s.lever[k] * t.by_estimate);
    for (int c = 0; c < 2; ++c) {
      const VectorN<N> response = station_response(k, c);
      out.station_reference[k][2 - static_cast<std::size_t>(c)] = on_position * response;
      add_square<1>(std::sqrt(loss) * on_position * response,
                    out.position[kStationTotalField + static_cast<std::size_t>(c)]);
      if (shared) others[static_cast<std::size_t>(c)] += response * response.transpose();
    }
    const Vector3d turned = station_declination * s.by_declination[k];
    add_square<1>(s.lever[k] * turned, out.position[kStationDeclination]);
    out.station_reference[k][0] = s.lever[k] * turned;
    out.azimuth[k][kStationDeclination] = sum_of_squares<1>(s.right[k], turned);
    out.azimuth[k][kMagnetometerNoise] = 0;
    if (noise > 0) {
      const MatrixN3 response = noise_response(k);
      add_square<3>(s.lever[k] * noise * s.by_field[k] + on_position * response, out.position[kMagnetometerNoise]);
      if (loss != 1) add_square<3>(std::sqrt(loss - 1) * on_position * response, out.position[kMagnetometerNoise]);
      if (shared) others[2] += response.lazyProduct(response.transpose());
    }
  }
  out.run_reference = {run_position.col(static_cast<int>(kDeclination)), run_position.col(static_cast<int>(kDip)),
                       run_position.col(static_cast<int>(kTotalField))};
  for (std::size_t i = 0; i < kRunInputs; ++i)
    add_square<1>(run_position.col(static_cast<Eigen::Index>(i)), out.position[i]);
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Matrix<double, 1, N> y = s.right[k] * tangents[k].by_estimate;
    for (int c = 0; c < 2; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const double own = y * station_response(k, c);
      out.azimuth[k][kStationTotalField + i] = loss * (shared ? double(y * others[i] * y.transpose()) : own * own);
    }
    if (noise > 0) {
      // The station's own noise acts directly, too; its response is among those of all.
      const Eigen::RowVector3d direct = noise * s.right[k] * s.by_field[k], response = y * noise_response(k);
      const double all = shared ? double(y * others[2] * y.transpose()) : response.squaredNorm();
      out.azimuth[k][kMagnetometerNoise] = loss * all + direct.squaredNorm() + 2 * direct.dot(response);
    }
  }
  if (!correlation) return out;

  // What the draws of a pair (input a of station j, input b of station k) have in common, but for a draw with itself.
  const auto on_position = [&](int input, std::size_t k) -> Vector3d {
    // A field that is turned to the east makes the azimuth too small.
    if (input == 2) return -s.lever[k] * station_declination * s.by_declination[k];
    const Matrix3N by = shared ? through_estimate : Matrix3N(s.lever[k] * tangents[k].by_estimate);
    return by * station_response(k, input);
  };
  std::array<std::vector<Vector3d>, 3> effects;
  std::array<std::vector<VectorN<N>>, 2> response;
  for (int a = 0; a < 3; ++a)
    for (std::size_t k = 0; k < n; ++k) {
      effects[static_cast<std::size_t>(a)].push_back(on_position(a, k));
      if (a < 2) response[static_cast<std::size_t>(a)].push_back(station_response(k, a));
    }
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const auto ia = static_cast<std::size_t>(a), ib = static_cast<std::size_t>(b);
      Matrix3d position = Matrix3d::Zero();
      MatrixN<N> estimate = MatrixN<N>::Zero();             // of a shared one
      std::vector<VectorN<N>> seen(n, VectorN<N>::Zero());  // a: of the estimate with the declination of station k
      for (std::size_t k = 0; k < n; ++k) {
        Vector3d of_a = Vector3d::Zero();
        VectorN<N> on_estimate = VectorN<N>::Zero();
        for (std::size_t j = 0; j < n; ++j) {
          const double r = correlation(a, j, b, k);
          const double with_others = a == b && j == k ? r - 1 : r;
          of_a += with_others * effects[ia][j];
          if (a < 2 && b < 2 && shared) on_estimate += with_others * response[ia][j];
          if (a < 2 && b == 2 && (shared || j == k)) seen[k] += r * response[ia][j];
        }
        position += of_a * effects[ib][k].transpose();
        if (a < 2 && b < 2 && shared) estimate += on_estimate * response[ib][k].transpose();
      }
      // Of a pair and its mirror each input gets a half.
      const Matrix3d half = 0.25 * (position + position.transpose());
      out.position[kStationTotalField + ia] += half;
      out.position[kStationTotalField + ib] += half;
      for (std::size_t k = 0; k < n; ++k) {
        const Eigen::Matrix<double, 1, N> y = s.right[k] * tangents[k].by_estimate;
        double common = 0;
        if (a < 2 && b < 2)
          common = shared   ? double(y * estimate * y.transpose())
                   : a == b ? 0.0
                            : correlation(a, k, b, k) * double(y * response[ia][k]) * double(y * response[ib][k]);
        else if (a < 2)  // and its mirror (declination first), which the loop has, too
          common = -double(y * seen[k]) * station_declination * double(s.right[k] * s.by_declination[k]);
        else if (b < 2)
          continue;
        out.azimuth[k][kStationTotalField + ia] += (a < 2 && b == 2 ? 1 : 0.5) * common;
        out.azimuth[k][kStationTotalField + ib] += (a < 2 && b == 2 ? 1 : 0.5) * common;
      }
    }
  return out;
}

CorrectedErrors undetermined(double condition) {
  CorrectedErrors out;
  out.determined = false;
  out.condition = condition;
  for (Matrix3d& c : out.position) c.setConstant(kNaN);
  return out;
}

/// Without value where the unknowns are not determined; `condition` grows to that of the fit.
std::optional<SixResponse> find_response(const estimate::EstimatorOptions& o, const estimate::NominalTruth& truth,
                                         double& condition) {
  const std::optional<estimate::Sensitivity> s = estimate::find_sensitivity(o, truth);
  condition = std::max(condition, s ? s->scaled_condition : kInfinity);
  if (!(condition <= kUndetermined)) return {};
  return response_of(*s, truth.stations, truth.field.gravity);
}

CorrectedErrors corrected_by_set(const MeasuredStations& s, const propagate::CodeDraws& draws, double noise,
                                 const Correction& correction, const StationCorrelation& correlation) {
  const multistation::LossCost& cost = correction.cost;
  assert(!correlation || cost.variance == 1);
  const multistation::FitOptions o = multistation::as_weighed(in_field(correction.parameters, s.field), cost);
  const std::vector<multistation::StationReadings> readings = perfect_readings(s);
  std::optional<multistation::FitSensitivity> sensitive;
  try {
    sensitive = multistation::fit_sensitivity(readings, {}, o, std::vector<double>(readings.size(), cost.slope));
  } catch (const InputError&) {
    return undetermined(kInfinity);
  }
  const double condition = scaled_condition(sensitive->posterior);
  if (!(condition <= kUndetermined)) return undetermined(condition);
  CorrectedErrors out =
      sum_up<multistation::kParameters>(s, draws, noise, set_tangents(s, readings, o),
                                        {set_response(*sensitive, o.parameters)}, correlation, cost.variance);
  out.condition = condition;
  if (cost.variance == 1) return out;
  std::vector<multistation::StationModel> models;
  for (const multistation::StationReadings& r : readings)
    models.push_back(multistation::station_model(r, {}, o.residuals, o.sizes));
  const auto reference = [](const propagate::CodeDraws::Reference& r) {
    return multistation::ReferenceErrors{0, r.total, r.dip};
  };
  out.limits = robust_limits({{}, tool_sizes(draws), reference(draws.run), reference(draws.station), 0, noise}, o,
                             models, *sensitive);
  return out;
}

/// L^-1 actual L^-T, claimed = L L'; NaN where there is no L.
Matrix2d whitened(const Matrix2d& actual, const Matrix2d& claimed, Matrix2d& inverse_factor) {
  const Eigen::LLT<Matrix2d> llt(claimed);
  if (llt.info() != Eigen::Success || !(claimed.determinant() > 1e-24 * claimed.trace() * claimed.trace()))
    return Matrix2d::Constant(kNaN);
  inverse_factor = llt.matrixL().solve(Matrix2d::Identity());
  return inverse_factor * actual * inverse_factor.transpose();
}

}  // namespace

multistation::FitOptions in_field(multistation::FitOptions options, const survey::ReferenceField& field) {
  options.total = field.total;
  options.dip = field.dip;
  return options;
}

const std::vector<std::string>& correction_names() {
  static const std::vector<std::string> names{"none", "msa", "msa3", "joint", "joint_priors", "axial"};
  return names;
}

estimate::InputErrors assumed_errors(const propagate::CodeDraws& sizes, double noise) {
  estimate::InputErrors a;
  a.magnetometer = noise;
  a.total = sizes.run.total;
  a.dip = sizes.run.dip;
  a.station_total = sizes.station.total;
  a.station_dip = sizes.station.dip;
  a.gain = sizes.sensors[survey::kMagnetometerScale];
  a.bias = sizes.sensors[survey::kMagnetometerBias];
  a.axial_bias = sizes.interference;
  return a;
}

estimate::EstimatorOptions axial_estimator() {
  estimate::EstimatorOptions o;
  o.estimated = kAxialBias;
  return o;
}

Correction correction(const std::string& name, const propagate::CodeDraws& sizes, double noise) {
  const std::vector<std::string>& names = correction_names();
  require(std::find(names.begin(), names.end(), name) != names.end(), "correction.kind = \"{}\": must be one of {}",
          name, fmt::join(names, ", "));
  Correction c;
  c.kind = name == "none"    ? Correction::Kind::none
           : name == "axial" ? Correction::Kind::station
                             : Correction::Kind::run;
  if (name == "axial") c.estimator = axial_estimator();
  if (name == "msa3") c.estimator.estimated = kBiases;
  if (name == "joint" || name == "joint_priors") {
    c.estimator.name = "msa_joint";
    c.estimator.assumed = assumed_errors(sizes, noise);
    if (name == "joint") c.estimator.assumed.gain = c.estimator.assumed.bias = c.estimator.assumed.axial_bias = 0;
  }
  return c;
}

MeasuredStations measured_stations(const survey::Survey& survey, const survey::ReferenceField& field,
                                   bool first_leg_doubled) {
  MeasuredStations m;
  m.field = field;
  const Matrix3d to_true = survey::true_from_magnetic(field.declination);
  const std::size_t n = survey.stations.size();
  for (std::size_t k = 1; k < n; ++k) {
    const survey::Station& s = survey.stations[k];
    const survey::Attitude at = survey::magnetic_attitude(s, field.declination);
    m.fields.push_back({survey::magnetic_T(at, field.total, field.dip), survey::down_T(at)});
    const propagate::TangentDerivatives d = propagate::tangent_derivatives(m.fields.back());
    m.by_field.push_back(to_true * d.by_field);
    m.by_down.push_back(to_true * d.by_down);
    const double sine = std::sin(s.inclination);
    m.by_declination.emplace_back(-sine * std::sin(s.azimuth), sine * std::cos(s.azimuth), 0);
    m.right.emplace_back(-std::sin(s.azimuth), std::cos(s.azimuth), 0);
    const double before = s.md - survey.stations[k - 1].md;
    const double after = k + 1 < n ? survey.stations[k + 1].md - s.md : 0;
    m.lever.push_back((before + after) / 2 + (k == 1 && first_leg_doubled ? before / 2 : 0));
  }
  return m;
}

CorrectedErrors corrected_errors(const MeasuredStations& s, const propagate::CodeDraws& draws, double noise,
                                 const Correction& c, const StationCorrelation& correlation) {
  double condition = 1;
  std::vector<SixResponse> responses;
  estimate::NominalTruth truth{{}, {1, 1, 1}, {0, 0, 0}, s.field};
  switch (c.kind) {
    case Correction::Kind::none:
      responses.push_back(no_response());
      break;
    case Correction::Kind::run: {
      truth.stations = s.fields;
      std::optional<SixResponse> r = find_response(c.estimator, truth, condition);
      if (!r) return undetermined(condition);
      responses.push_back(std::move(*r));
      break;
    }
    case Correction::Kind::parameters:
      return corrected_by_set(s, draws, noise, c, correlation);
    case Correction::Kind::station:
      for (const survey::StationFields& f : s.fields) {
        truth.stations = {f};
        std::optional<SixResponse> r = find_response(axial_estimator(), truth, condition);
        if (!r) return undetermined(condition);
        responses.push_back(std::move(*r));
      }
      break;
  }
  std::vector<StationTangent<kGainsAndBiases>> tangents;
  tangents.reserve(s.fields.size());
  for (std::size_t k = 0; k < s.fields.size(); ++k) tangents.push_back(station_tangent(s, k));
  CorrectedErrors out = sum_up(s, draws, noise, tangents, responses, correlation);
  out.condition = condition;
  return out;
}

Matrix3d CorrectedErrors::covariance() const {
  Matrix3d sum = Matrix3d::Zero();
  for (const Matrix3d& c : position) sum += c;
  return sum;
}

double CorrectedErrors::azimuth_variance(std::size_t station) const {
  double sum = 0;
  for (const double v : azimuth[station]) sum += v;
  return sum;
}

double worst_ratio(const Matrix2d& actual, const Matrix2d& claimed) {
  Matrix2d factor;
  const Matrix2d m = whitened(actual, claimed, factor);
  const double half = (m(0, 0) + m(1, 1)) / 2, difference = (m(0, 0) - m(1, 1)) / 2;
  return std::sqrt(half + std::hypot(difference, m(0, 1)));
}

Vector2d worst_direction(const Matrix2d& actual, const Matrix2d& claimed) {
  Matrix2d factor = Matrix2d::Constant(kNaN);
  const Matrix2d m = whitened(actual, claimed, factor);
  const double angle = std::atan2(2 * m(0, 1), m(0, 0) - m(1, 1)) / 2;
  return (factor.transpose() * Vector2d(std::cos(angle), std::sin(angle))).normalized();
}

}  // namespace surveymc::analysis
