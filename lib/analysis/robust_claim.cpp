#include "analysis/robust_claim.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "base/units.h"
#include "multistation/fit_kernel.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

multistation::PerParameter<double> tool_sizes(const propagate::CodeDraws& d) {
  multistation::PerParameter<double> sd{};
  std::copy(d.sensors.begin(), d.sensors.end(), sd.begin());
  sd[multistation::kMagnetometerBias + 2] = d.axial_bias();
  return sd;
}

RobustClaim::RobustClaim(const MeasuredStations& s, const propagate::CodeDraws& d, double noise,
                         const multistation::FitOptions& o) {
  const multistation::PerParameter<double> sd = tool_sizes(d);
  const int p = o.parameters.size();
  prior_.resize(p);
  truth_.resize(p);
  for (int i = 0; i < p; ++i) {
    const auto at = static_cast<std::size_t>(o.parameters.index(i));
    prior_[i] = 1 / (o.prior_sd[at] * o.prior_sd[at]);
    truth_[i] = sd[at] * sd[at];
  }
  const multistation::FitPlan plan = multistation::fit_plan(o);
  Eigen::Matrix<double, 3, 2> by_field = Eigen::Matrix<double, 3, 2>::Zero();  // of Reference by total field and dip
  by_field.bottomRows<2>() << plan.first_by_total, plan.first_by_dip, plan.second_by_total, plan.second_by_dip;
  const multistation::Reference reference =
      multistation::reference_of(o.residuals, s.field.gravity, s.field.total, s.field.dip);
  for (const survey::StationFields& f : s.fields) {
    const multistation::StationReadings readings{survey::from_eigen(s.field.gravity * survey::to_eigen(f.down_T)),
                                                 f.field_T, reference};
    const multistation::StationModel m = multistation::station_model(readings, {}, o.residuals, o.sizes);
    MatrixXd j(multistation::kResiduals, p);
    for (int i = 0; i < p; ++i) j.col(i) = m.by_parameter.col(o.parameters.index(i));
    // What is not estimated moves the readings against its column; a field that is too large is a reference that is too
    // small.
    const Eigen::Matrix<double, 3, 2> by_total_and_dip = -m.by_reference * by_field;
    MatrixXd r = MatrixXd::Zero(multistation::kResiduals, multistation::kParameters + 2);
    for (int i = 0; i < multistation::kParameters; ++i)
      if (!o.parameters.contains(i)) r.col(i) = -sd[static_cast<std::size_t>(i)] * m.by_parameter.col(i);
    r.rightCols<2>() = by_total_and_dip * Eigen::Vector2d(d.run.total, d.run.dip).asDiagonal();
    const Matrix3d own =
        by_total_and_dip *
            Eigen::Vector2d(d.station.total * d.station.total, d.station.dip * d.station.dip).asDiagonal() *
            by_total_and_dip.transpose() +
        noise * noise * m.by_magnetic * m.by_magnetic.transpose();
    normal_.emplace_back(j.transpose() * j);
    noise_.emplace_back(j.transpose() * own * j);
    run_.emplace_back(j.transpose() * r);
  }
}

MatrixXd RobustClaim::covariance(const double* weights, const multistation::LossCost& cost) const {
  MatrixXd normal = prior_.asDiagonal(), noise = MatrixXd::Zero(normal.rows(), normal.rows()),
           run = MatrixXd::Zero(normal.rows(), run_.front().cols());
  for (std::size_t k = 0; k < normal_.size(); ++k) {
    const double information = cost.information(weights[k]);
    normal += information * normal_[k];
    noise += information * noise_[k];
    run += information * run_[k];
  }
  MatrixXd middle = cost.claimed_variance() * noise + run * run.transpose();
  middle += (prior_.array().square() * truth_.array()).matrix().asDiagonal();
  // Parameters have units that differ by orders of magnitude: a unit diagonal first.
  const VectorXd unit = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatrixXd> factored(unit.asDiagonal() * normal * unit.asDiagonal());
  if (factored.info() != Eigen::Success) return MatrixXd::Constant(normal.rows(), normal.rows(), kNaN);
  middle = unit.asDiagonal() * middle * unit.asDiagonal();
  const MatrixXd half = factored.solve(middle).transpose();
  return unit.asDiagonal() * factored.solve(half) * unit.asDiagonal();
}

double lateral_variance_ratio(const MeasuredStations& s, const propagate::CodeDraws& d, double noise,
                              const multistation::FitOptions& o, multistation::Loss loss) {
  const std::string set = o.parameters.name();
  const bool six = set == "6",
             plain = std::none_of(o.prior_sd.begin(), o.prior_sd.end(), [](double x) { return std::isfinite(x); });
  if (noise > 0 || !plain || (!six && set != "mbx, mby, mbz")) return kNaN;
  const CorrectedErrors e = corrected_errors(s, d, noise, correction(six ? "msa" : "msa3", d));
  if (!e.determined) return kNaN;
  const auto variance = [&](const Matrix3d& c) -> double { return s.right.back() * c * s.right.back().transpose(); };
  const double whole = variance(e.covariance()),
               stations = variance(e.position[kStationTotalField]) + variance(e.position[kStationDip]);
  return 1 + (multistation::loss_cost(loss, 2).variance - 1) * stations / whole;
}

}  // namespace surveymc::analysis
