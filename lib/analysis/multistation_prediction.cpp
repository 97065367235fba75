#include "analysis/multistation_prediction.h"

#include <cmath>

#include "propagate/station_effects.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Effects = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Position (N, E, V), and azimuth of the last station.
constexpr int kOfSurvey = 4;
using ByReading = Eigen::Matrix<double, kOfSurvey, 3>;

/// Of one station on these: by its readings, and by the tool's errors.
struct OnSurvey {
  ByReading by_gravity, by_magnetic;                                          ///< per m/s2, nT of a reading
  Eigen::Matrix<double, kOfSurvey, multistation::kParameters> by_correction;  ///< per unit of what is corrected for
};

std::vector<OnSurvey> on_survey(const MultistationRun& run, const std::vector<multistation::StationModel>& models) {
  std::vector<survey::StationFields> fields;
  for (const multistation::StationModel& m : models)
    fields.push_back({survey::from_eigen(m.field_T), survey::from_eigen(m.gravity_T.normalized())});
  const std::vector<propagate::StationEffect> effects =
      propagate::final_position_effects(run.md, fields, run.field.declination);
  std::vector<OnSurvey> out;
  for (std::size_t k = 0; k < models.size(); ++k) {
    const multistation::StationModel& m = models[k];
    const Vector3d u = survey::to_eigen(fields[k].down_T);
    ByReading by_field = ByReading::Zero(), by_down = ByReading::Zero();
    by_field.topRows<3>() = effects[k].by_field;
    by_down.topRows<3>() = effects[k].by_down;
    if (k + 1 == models.size()) {
      const propagate::AzimuthDerivatives azimuth = propagate::azimuth_derivatives(fields[k]);
      by_field.row(3) = azimuth.by_field;
      by_down.row(3) = azimuth.by_down;
    }
    const ByReading by_gravity = by_down * (Matrix3d::Identity() - u * u.transpose()) / m.gravity_T.norm();
    out.push_back({by_gravity * m.gravity_by_reading, by_field * m.field_by_reading,
                   by_gravity * m.gravity_by_parameter + by_field * m.field_by_parameter});
  }
  return out;
}

MatrixXd square(const MatrixXd& m) { return m * m.transpose(); }

}  // namespace

MultistationPrediction predict_multistation(const MultistationRun& run, const multistation::FitOptions& estimator,
                                            const multistation::LossCost& cost) {
  const multistation::FitOptions o = multistation::as_weighed(estimator, cost);
  const std::vector<multistation::StationReadings> stations = clean_stations(run);
  const multistation::FitSensitivity sensitive =
      multistation::fit_sensitivity(stations, run.tool, o, std::vector<double>(stations.size(), cost.slope));
  multistation::PerParameter<double> known{};
  for (int i = 0; i < o.parameters.size(); ++i) {
    const auto at = static_cast<std::size_t>(o.parameters.index(i));
    known[at] = run.tool[at];
  }
  std::vector<multistation::StationModel> models;
  for (const multistation::StationReadings& s : stations)
    models.push_back(multistation::station_model(s, known, o.residuals, o.sizes));
  const std::vector<OnSurvey> direct = on_survey(run, models);
  const int p = o.parameters.size();

  Eigen::Matrix<double, kOfSurvey, multistation::kParameters> by_correction =
      Eigen::Matrix<double, kOfSurvey, multistation::kParameters>::Zero();
  for (const OnSurvey& d : direct) by_correction += d.by_correction;
  MatrixXd by_estimate(kOfSurvey, p);
  for (int i = 0; i < p; ++i) by_estimate.col(i) = by_correction.col(o.parameters.index(i));

  // Rows: errors of the parameters, then of position and azimuth.
  MatrixXd covariance = MatrixXd::Zero(p + kOfSurvey, p + kOfSurvey),
           claimed = sensitive.claimed(cost.variance * cost.slope);
  Eigen::Matrix<double, kOfSurvey, kOfSurvey> uncorrected = Eigen::Matrix<double, kOfSurvey, kOfSurvey>::Zero();
  enum class Of { station, run };
  const auto add = [&](Of of, const Effects& through, const ByReading& at_once, const Vector3d& sd) {
    MatrixXd q(p + kOfSurvey, 3);
    q.topRows(p) = through;
    q.bottomRows(kOfSurvey) = by_estimate * through;
    if (of == Of::station && cost.variance != 1) covariance += (cost.variance - 1) * square(q * sd.asDiagonal());
    q.bottomRows(kOfSurvey) += at_once;
    covariance += square(q * sd.asDiagonal());
    uncorrected += square(at_once * sd.asDiagonal());
  };
  const Vector3d reference_sd(run.reference.gravity, run.reference.total, run.reference.dip),
      assumed_sd(o.reference.gravity, o.reference.total, o.reference.dip);
  Effects of_run = Effects::Zero(p, 3);
  for (std::size_t k = 0; k < stations.size(); ++k) {
    add(Of::station, sensitive.by_gravity[k].topRows(p), direct[k].by_gravity, Vector3d::Constant(run.accelerometer));
    add(Of::station, sensitive.by_magnetic[k].topRows(p), direct[k].by_magnetic, Vector3d::Constant(run.magnetometer));
    const Effects by_reference = sensitive.by_reference[k].topRows(p);
    if (run.reference_per_station) add(Of::station, by_reference, ByReading::Zero(), reference_sd);
    of_run += by_reference;
  }
  if (!run.reference_per_station) add(Of::run, of_run, ByReading::Zero(), reference_sd);
  if (!o.estimates_reference) claimed += square(of_run * assumed_sd.asDiagonal());

  MatrixXd by_tool(p + kOfSurvey, multistation::kParameters);
  by_tool.topRows(p) = sensitive.by_truth.topRows(p);
  by_tool.bottomRows(kOfSurvey) = by_estimate * by_tool.topRows(p);
  for (int i = 0; i < multistation::kParameters; ++i)
    if (!o.parameters.contains(i)) by_tool.col(i).tail<kOfSurvey>() -= by_correction.col(i);
  const Eigen::Map<const Eigen::Matrix<double, multistation::kParameters, 1>> tool(run.tool.data()),
      tool_sd(run.tool_sd.data());
  covariance += square(by_tool * tool_sd.asDiagonal());
  uncorrected += square(by_correction * tool_sd.asDiagonal());

  MultistationPrediction out;
  const VectorXd mean = by_tool * tool;
  out.shift = mean.head(p);
  out.position = mean.segment<3>(p);
  out.covariance = covariance.topLeftCorner(p, p);
  out.position_covariance = covariance.block<3, 3>(p, p);
  out.azimuth_sd = std::sqrt(covariance(p + 3, p + 3));
  out.uncorrected_covariance = uncorrected.topLeftCorner<3, 3>();
  out.uncorrected_azimuth_sd = std::sqrt(uncorrected(3, 3));
  out.claimed = claimed;
  if (cost.variance != 1) {
    ResidualErrors errors{run.tool, run.tool_sd, {}, {}, run.accelerometer, run.magnetometer};
    (run.reference_per_station ? errors.station : errors.run) = run.reference;
    out.limits = robust_limits(errors, o, models, sensitive);
  }
  out.learnt.resize(p);
  for (int i = 0; i < p; ++i) {
    const double prior = o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))];
    out.learnt[i] = std::isfinite(prior) ? 1 - claimed(i, i) / (prior * prior) : 1;
  }
  out.observability = multistation::set_observability(
      multistation::jacobian(stations, known, o.parameters, o.residuals, estimator.sizes), o.parameters, o.prior_sd);
  return out;
}

}  // namespace surveymc::analysis
