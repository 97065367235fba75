#include "analysis/readings_analysis.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/msa_prediction.h"
#include "base/error.h"
#include "base/units.h"
#include "estimate/estimators.h"
#include "propagate/corrected_well_covariance.h"
#include "stats/linear_algebra.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::vector<std::string>& readings_estimators() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const estimate::EstimatorKind& k : estimate::estimators())
      if (!k.needs_attitude && k.predict) all.emplace_back(k.name);
    return all;
  }();
  return names;
}

namespace {

/// The run as a block of one trial. Its spare lanes repeat it: the kernels compute them anyway.
survey::ReadingBlock block_of(const survey::SixAxisReadings& r, const survey::ReferenceField& field) {
  survey::ReadingBlock block(1, r.size(), true, false);
  for (int k = 0; k < r.size(); ++k) {
    const survey::Vec3<double>&m = r.magnetic_T[static_cast<std::size_t>(k)],
          &g = r.gravity_T[static_cast<std::size_t>(k)];
    const survey::Vec3<double> u = scale(1 / norm(g), g);
    const std::array<double, 3> magnetic{m.x, m.y, m.z}, down{u.x, u.y, u.z};
    for (int i = 0; i < 3; ++i) {
      block.magnetic.fill(0, 3 * k + i, magnetic[static_cast<std::size_t>(i)]);
      block.down.fill(0, 3 * k + i, down[static_cast<std::size_t>(i)]);
    }
  }
  block.reference.fill(0, 0, field.total * std::cos(field.dip));
  block.reference.fill(0, 1, field.total * std::sin(field.dip));
  return block;
}

/// Fields of the readings, corrected by x.
std::vector<survey::StationFields> fields_of(const survey::SixAxisReadings& r, const propagate::Vector6d& x) {
  std::vector<survey::StationFields> fields;
  for (std::size_t k = 0; k < r.md.size(); ++k) {
    const survey::StationFields s{estimate::corrected_field(r.magnetic_T[k], {x[0], x[1], x[2]}, {x[3], x[4], x[5]}),
                                  scale(1 / norm(r.gravity_T[k]), r.gravity_T[k])};
    // A tenth of a per cent of the field is noise: no azimuth comes from it.
    require(norm(cross(s.down_T, s.field_T)) > 1e-3 * norm(s.field_T),
            "md {:g} m: the magnetic field is parallel to gravity: there is no magnetic azimuth", r.md[k]);
    fields.push_back(s);
  }
  return fields;
}

FieldResiduals residuals_of(const survey::StationFields& s, const survey::ReferenceField& field) {
  const double bv = dot(s.down_T, s.field_T), bh = norm(cross(s.down_T, s.field_T)), total = norm(s.field_T);
  return {bh - field.total * std::cos(field.dip), bv - field.total * std::sin(field.dip), total - field.total,
          std::atan2(bv, bh) - field.dip};
}

std::vector<survey::Vec3<double>> true_tangents(const survey::SixAxisReadings& r,
                                                const std::vector<survey::StationFields>& fields, double declination) {
  std::vector<survey::Vec3<double>> tangents;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    tangents.push_back(survey::magnetic_to_true(survey::tangent_from_fields(fields[k].down_T, fields[k].field_T),
                                                std::sin(declination), std::cos(declination)));
    // As find_defect(): the arc of a reversal has no plane.
    require(k == 0 || dot(tangents[k - 1], tangents[k]) > -1 + 1e-12,
            "md {:g} m: the hole turns by 180 degrees from the station before", r.md[k]);
  }
  return tangents;
}

/// Widest range of the tool's rotation without a station. Rotation is seen by gravity's or the field's cross-axis part,
/// whichever is the larger part of its vector: gravity has none in a vertical hole, the field none along itself.
double rotation_gap(const std::vector<survey::StationFields>& fields) {
  double gravity = 0, magnetic = 0;
  for (const survey::StationFields& s : fields) {
    gravity += std::hypot(s.down_T.x, s.down_T.y);
    magnetic += std::hypot(s.field_T.x, s.field_T.y) / norm(s.field_T);
  }
  std::vector<double> angles;
  for (const survey::StationFields& s : fields) {
    const survey::Vec3<double>& v = gravity >= magnetic ? s.down_T : s.field_T;
    angles.push_back(std::atan2(v.x, v.y));
  }
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2 * kPi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k) widest = std::max(widest, angles[k] - angles[k - 1]);
  return widest;
}

bool vertical_field_reversed(const std::vector<survey::StationFields>& raw, const survey::ReferenceField& field) {
  if (std::abs(field.dip) < 5 * kDegree) return false;  // near the equator the sign of the dip says nothing
  const auto other = std::count_if(
      raw.begin(), raw.end(), [&](const survey::StationFields& s) { return dot(s.down_T, s.field_T) * field.dip < 0; });
  return 2 * other > static_cast<std::ptrdiff_t>(raw.size());
}

/// First-order effects of all draws on one station: see propagate/corrected_well_covariance.h.
struct StationEffects {
  propagate::StationErrors errors;
  Eigen::Matrix<double, 1, 6> azimuth_by_draws, azimuth_by_parameters;
};
StationEffects station_effects(const survey::StationFields& s, const propagate::Vector6d& x,
                               const estimate::Matrix63d& by_magnetometer, const estimate::Matrix63d& by_down,
                               const estimate::InputErrors& noise, double declination) {
  const Vector3d per_gain = x.head<3>().cwiseInverse(), u = survey::to_eigen(s.down_T), b = survey::to_eigen(s.field_T);
  const Matrix3d across = noise.down * (Matrix3d::Identity() - u * u.transpose());
  const Matrix3d reading = noise.magnetometer * Matrix3d(per_gain.asDiagonal());
  Eigen::Matrix<double, 3, 6> field_by_parameters;
  field_by_parameters << Matrix3d((-b).cwiseProduct(per_gain).asDiagonal()), Matrix3d((-per_gain).asDiagonal());
  const Matrix3d to_true = survey::true_from_magnetic(declination);

  const propagate::TangentDerivatives t = propagate::tangent_derivatives(s);
  const propagate::AzimuthDerivatives a = propagate::azimuth_derivatives(s);
  StationEffects e;
  e.errors.tangent_by_draws << to_true * t.by_field * reading, to_true * t.by_down * across;
  e.errors.tangent_by_parameters = to_true * t.by_field * field_by_parameters;
  e.errors.parameters_by_draws << noise.magnetometer * by_magnetometer, by_down * across;
  e.azimuth_by_draws.leftCols<3>() = a.by_field * reading;
  e.azimuth_by_draws.rightCols<3>().setZero();
  if (noise.down > 0) e.azimuth_by_draws.rightCols<3>() = a.by_down * across;  // not finite in a vertical hole
  e.azimuth_by_parameters = a.by_field * field_by_parameters;
  return e;
}

/// A likely reason for having no estimate, for the message.
std::string likely_reason(const ReadingsAnalysis& a) {
  if (a.vertical_field_reversed)
    return "their dip has the sign of the other hemisphere: do the accelerometers read the other way round (key "
           "`accelerometers`)?";
  if (a.observability.condition_indices[0] > estimate::kSevereCondition)
    return fmt::format(
        "the stations hardly determine {} (condition index {:.3g}): a run needs stations of different "
        "toolface, inclination and azimuth",
        estimate::combination_name(a.observability.directions.col(0)), a.observability.condition_indices[0]);
  return "are the axes and units right, and field.total_nT and field.dip_deg?";
}

/// The estimate; fills evaluations and reference. `out` has the geometry of the raw readings.
propagate::Vector6d solve(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                          const estimate::EstimatorOptions& options, ReadingsAnalysis& out) {
  const survey::ReadingBlock block = block_of(readings, field);
  estimate::EstimateBlock estimate(1);
  const auto estimator = estimate::make_estimator(options, field);
  estimator->solve(block, estimate);
  out.evaluations = static_cast<int>(estimate.iterations.value(0, 0));
  require(estimate.converged.value(0, 0) != 0,
          "the estimator \"{}\" finds no minimum with positive gains in {} evaluations; {}", options.name,
          out.evaluations, likely_reason(out));
  propagate::Vector6d x;
  for (int i = 0; i < 6; ++i) x[i] = estimate.parameters.value(0, i);
  if (estimator->estimates_reference()) {
    const double bh = estimate.reference.value(0, 0), bv = estimate.reference.value(0, 1);
    out.reference = Eigen::Vector2d(std::hypot(bh, bv), std::atan2(bv, bh));
  }
  return x;
}

void require_observable(const estimate::Observability& o) {
  if (o.condition_indices[0] < estimate::kHopelessCondition) return;
  throw InputError(
      fmt::format("the stations cannot determine {} (condition index {:.1e}): a run needs stations of "
                  "different toolface, inclination and azimuth",
                  estimate::combination_name(o.directions.col(0)), o.condition_indices[0]));
}

}  // namespace

ReadingsAnalysis analyse_readings(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                  const sensor::NoiseModel& noise, const estimate::EstimatorOptions& estimator) {
  propagate::Vector6d perfect;
  perfect << 1, 1, 1, 0, 0, 0;
  const std::vector<survey::StationFields> raw = fields_of(readings, perfect);
  ReadingsAnalysis a;
  a.vertical_field_reversed = vertical_field_reversed(raw, field);
  a.rotation_gap = rotation_gap(raw);
  // Before the solver, which would only say that it does not converge.
  a.observability = estimate::observability(
      estimate::misfit_jacobian(estimate::field_misfits(raw, {1, 1, 1}, field.total, field.dip)));
  require_observable(a.observability);
  const propagate::Vector6d x = a.parameters = solve(readings, field, estimator, a);

  const std::vector<survey::StationFields> corrected = fields_of(readings, x);
  survey::ReferenceField fitted = field;
  if (a.reference) {
    fitted.total = (*a.reference)[0];
    fitted.dip = (*a.reference)[1];
  }
  for (const survey::StationFields& s : corrected) {
    const FieldResiduals r = residuals_of(s, fitted);
    a.squares += r.horizontal * r.horizontal + r.vertical * r.vertical;
  }
  a.misfits = estimate::field_misfits(corrected, {x[0], x[1], x[2]}, field.total, field.dip);
  a.observability = estimate::observability(estimate::misfit_jacobian(a.misfits));
  require_observable(a.observability);
  const estimate::InputErrors& assumed = estimator.assumed;
  const estimate::InputErrors input = input_errors(noise, {assumed.gain, assumed.bias, assumed.axial_bias}, field);
  const estimate::Sensitivity sensitive =
      estimate::sensitivity(estimator, {corrected, {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, field});
  const estimate::Matrix8d covariance = estimate::error_covariance(sensitive, corrected, input);
  a.covariance = covariance.topLeftCorner<6, 6>();
  a.reference_estimate_covariance = covariance.bottomRightCorner<2, 2>();
  a.reference_covariance = estimate::error_covariance(sensitive, corrected,
                                                      {0, 0, input.total, input.dip, input.reference_per_station, 0, 0})
                               .topLeftCorner<6, 6>();
  a.tests = estimate::residual_tests(corrected, a.misfits, input);
  // A perfect tool is gains 1 and biases 0 exactly: nothing of its estimate's spread comes from tools that vary.
  estimate::InputErrors of_perfect = input;
  of_perfect.gain = of_perfect.bias = of_perfect.axial_bias = 0;
  a.perfect_covariance = estimate::error_covariance(sensitive, corrected, of_perfect).topLeftCorner<6, 6>();
  const propagate::Vector6d off = (x - perfect).cwiseQuotient(a.perfect_covariance.diagonal().cwiseSqrt());
  const propagate::Vector6d per_sd = a.perfect_covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = per_sd.asDiagonal() * a.perfect_covariance * per_sd.asDiagonal();
  a.perfect_tool_statistic = off.dot(propagate::Vector6d(stats::symmetric_inverse(correlation) * off));

  const std::vector<survey::Vec3<double>> raw_tangents = true_tangents(readings, raw, field.declination);
  const std::vector<survey::Vec3<double>> tangents = true_tangents(readings, corrected, field.declination);
  std::vector<propagate::StationErrors> errors;
  std::vector<double> azimuth_variance;
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    const StationEffects e = station_effects(corrected[k], x, sensitive.by_magnetometer[k].topRows<6>(),
                                             sensitive.by_down[k].topRows<6>(), input, field.declination);
    errors.push_back(e.errors);
    azimuth_variance.push_back(propagate::covariance_with_estimate(e.azimuth_by_draws, e.azimuth_by_parameters,
                                                                   e.errors.parameters_by_draws, a.covariance)(0, 0));
  }
  const auto raw_positions = survey::minimum_curvature_positions(readings.md, raw_tangents);
  const auto positions = survey::minimum_curvature_positions(readings.md, tangents);
  const auto covariances = propagate::position_covariances(readings.md, tangents, errors, a.covariance);
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    const double variance = azimuth_variance[k];
    a.stations.push_back({survey::attitude_from_fields(readings.gravity_T[k], raw[k].field_T),
                          survey::attitude_from_fields(readings.gravity_T[k], corrected[k].field_T),
                          std::isfinite(variance) ? std::sqrt(std::max(0.0, variance)) : kNaN,
                          norm(readings.gravity_T[k]) - field.gravity, residuals_of(raw[k], field),
                          residuals_of(corrected[k], field), raw_positions[k], positions[k], covariances[k]});
  }
  return a;
}

}  // namespace surveymc::analysis
