#include "multistation/fit.h"

#include <cassert>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "multistation/fit_lanes.h"
#include "stats/linear_algebra.h"

namespace surveymc::multistation {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Units of the reference's unknowns in the search.
constexpr std::array<double, 3> kReferenceScale{0.001, 100, 0.2 * kDegree};

std::array<double, 3> values(const ReferenceErrors& e) { return {e.gravity, e.total, e.dip}; }

/// Unknown of the plan (3 a + i) of each parameter of the set.
std::array<int, kParameters> places_of(const FitPlan& plan, const ParameterSet& set) {
  std::array<int, kParameters> places{};
  for (int i = 0; i < set.size(); ++i)
    for (int a = 0; a < plan.kind_count; ++a)
      if (plan.kinds[static_cast<std::size_t>(a)] == set.index(i) / 3 * 3)
        places[static_cast<std::size_t>(i)] = 3 * a + set.index(i) % 3;
  return places;
}

/// What is linear about a run: unknowns are the set's parameters, then the reference's three where it is estimated.
struct LinearRun {
  std::vector<StationModel> stations;
  MatrixXd jacobian, normal_inverse;
  VectorXd prior_precision;
};

LinearRun linear_run(const std::vector<StationReadings>& readings, const PerParameter<double>& tool,
                     const ReferenceErrors& reference_error, const FitOptions& o, const FitPlan& plan,
                     const std::vector<double>& weights) {
  const int p = o.parameters.size(), n = p + (o.estimates_reference ? 3 : 0);
  const auto count = static_cast<Eigen::Index>(readings.size());
  const Eigen::Matrix3d by_reference = reference_derivatives(plan);
  const std::array<double, 3> error = values(reference_error);
  const Eigen::Vector3d moved = by_reference * Eigen::Map<const Eigen::Vector3d>(error.data());
  LinearRun run;
  run.jacobian.resize(kResiduals * count, n);
  MatrixXd weighted(kResiduals * count, n);
  for (Eigen::Index k = 0; k < count; ++k) {
    StationReadings s = readings[static_cast<std::size_t>(k)];
    s.reference.gravity += moved[0];
    s.reference.first += moved[1];
    s.reference.second += moved[2];
    run.stations.push_back(station_model(s, tool, o.residuals, o.sizes));
    const StationModel& m = run.stations.back();
    auto rows = run.jacobian.middleRows<kResiduals>(kResiduals * k);
    for (int i = 0; i < p; ++i) rows.col(i) = m.by_parameter.col(o.parameters.index(i));
    if (o.estimates_reference) rows.rightCols<3>() = m.by_reference * by_reference;
    weighted.middleRows<kResiduals>(kResiduals * k) =
        (weights.empty() ? 1.0 : weights[static_cast<std::size_t>(k)]) * rows;
  }
  run.prior_precision = VectorXd::Zero(n);
  VectorXd unit(n);
  std::vector<bool> fixed(static_cast<std::size_t>(n), false);
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i < p ? o.parameters.index(i) : kReferenceKind + i - p);
    unit[i] = plan.scale[at];
    run.prior_precision[i] = plan.precision[at] / (unit[i] * unit[i]);
    fixed[static_cast<std::size_t>(i)] = !plan.free[at];
  }
  // In units of the scales: a condition of geometry and priors.
  MatrixXd normal = unit.asDiagonal() * (run.jacobian.transpose() * weighted) * unit.asDiagonal();
  normal += (unit.array().square() * run.prior_precision.array()).matrix().asDiagonal();
  for (int i = 0; i < n; ++i)
    if (fixed[static_cast<std::size_t>(i)]) {
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1;
    }
  const VectorXd length = normal.diagonal().cwiseSqrt();
  require(length.minCoeff() > 0, "stations and priors do not determine the unknown parameters");
  const MatrixXd scaled = length.cwiseInverse().asDiagonal() * normal * length.cwiseInverse().asDiagonal();
  const VectorXd eigenvalues = stats::symmetric_eigenvalues(scaled);
  require(eigenvalues[0] > 1e-13 * eigenvalues[n - 1], "stations and priors do not determine the unknown parameters");
  run.normal_inverse = unit.cwiseQuotient(length).asDiagonal() * stats::symmetric_inverse(scaled) *
                       unit.cwiseQuotient(length).asDiagonal();
  for (int i = 0; i < n; ++i)
    if (fixed[static_cast<std::size_t>(i)]) {
      run.normal_inverse.row(i).setZero();
      run.normal_inverse.col(i).setZero();
    }
  return run;
}

}  // namespace

Eigen::Matrix3d reference_derivatives(const FitPlan& plan) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 0) = 1;
  m(1, 1) = plan.first_by_total;
  m(1, 2) = plan.first_by_dip;
  m(2, 1) = plan.second_by_total;
  m(2, 2) = plan.second_by_dip;
  return m;
}

FitBatch batch_of(const SixAxisBlock& r, const FitPlan& plan, const ParameterSet& set, const FitBlock& out,
                  const survey::LaneArray* weights) {
  FitBlock& to = const_cast<FitBlock&>(out);  // kernels that only read the estimates leave them as they are
  FitBatch b{};
  b.plan = &plan;
  b.first = {r.gravity.row(0, 0), r.magnetic.row(0, 0), r.reference.row(0, 0), weights ? weights->row(0, 0) : nullptr,
             r.stations,          r.reference_stride};
  b.gravity_stride = r.gravity.group_stride();
  b.magnetic_stride = r.magnetic.group_stride();
  b.reference_stride = r.reference.group_stride();
  b.weight_stride = weights ? weights->group_stride() : 0;
  b.groups = r.groups();
  b.places = places_of(plan, set);
  b.parameters = set.size();
  b.estimate = to.estimate.row(0, 0);
  b.estimate_stride = to.estimate.group_stride();
  b.reference = to.reference.row(0, 0);
  b.reference_out_stride = to.reference.group_stride();
  b.variance = to.has_variance ? to.variance.row(0, 0) : nullptr;
  b.variance_stride = to.variance.group_stride();
  b.cost = to.cost.row(0, 0);
  b.iterations = to.iterations.row(0, 0);
  b.converged = to.converged.row(0, 0);
  b.scalar_stride = to.cost.group_stride();
  return b;
}

FitPlan fit_plan(const FitOptions& o) {
  require(o.parameters.size() > 0, "parameters: must name at least one");
  for (const double s : o.sizes) require(s > 0, "sizes of residuals: {} must be > 0", s);
  FitPlan plan;
  plan.residuals = o.residuals;
  plan.corrects_accelerometers = o.parameters.corrects_accelerometers();
  plan.gravity_is_noisy = o.gravity_is_noisy;
  const auto add_kind = [&](int kind) { plan.kinds[static_cast<std::size_t>(plan.kind_count++)] = kind; };
  for (int kind = 0; kind < kParameters; kind += 3)
    if (o.parameters.contains_kind(kind)) add_kind(kind);
  if (o.estimates_reference) add_kind(kReferenceKind);
  for (int i = 0; i < kParameters; ++i) {
    const auto at = static_cast<std::size_t>(i);
    plan.scale[at] = parameter(i).prior_sd;
    plan.free[at] = o.parameters.contains(i);
    if (!plan.free[at]) continue;
    require(o.prior_sd[at] > 0, "priors.{} = {}: must be > 0", parameter(i).name, o.prior_sd[at]);
    plan.precision[at] = plan.scale[at] / o.prior_sd[at] * (plan.scale[at] / o.prior_sd[at]);
  }
  const std::array<double, 3> sd = values(o.reference);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t at = kReferenceKind + i;
    plan.scale[at] = kReferenceScale[i];
    require(sd[i] >= 0, "sd of the reference: {} must be >= 0", sd[i]);
    plan.free[at] = o.estimates_reference && sd[i] > 0;
    if (plan.free[at]) plan.precision[at] = plan.scale[at] / sd[i] * (plan.scale[at] / sd[i]);
  }
  for (std::size_t j = 0; j < o.sizes.size(); ++j) plan.per_size[j] = 1 / o.sizes[j];
  const double s = std::sin(o.dip), c = std::cos(o.dip);
  if (o.residuals == ResidualKind::survey) {
    plan.first_by_total = c;
    plan.first_by_dip = -o.total * s;
    plan.second_by_total = s;
    plan.second_by_dip = o.total * c;
  } else {
    plan.first_by_total = 1;
    plan.second_by_dip = c;
  }
  plan.max_iterations = o.max_iterations;
  plan.step_tolerance = o.step_tolerance;
  return plan;
}

SixAxisBlock block_of(const std::vector<StationReadings>& stations) {
  const auto count = static_cast<int>(stations.size());
  SixAxisBlock block(1, count, true);
  for (int k = 0; k < count; ++k) {
    const StationReadings& s = stations[static_cast<std::size_t>(k)];
    const std::array<double, 3> g{s.gravity_T.x, s.gravity_T.y, s.gravity_T.z},
        b{s.magnetic_T.x, s.magnetic_T.y, s.magnetic_T.z},
        r{s.reference.gravity, s.reference.first, s.reference.second};
    for (int i = 0; i < 3; ++i) {
      block.gravity.fill(0, 3 * k + i, g[static_cast<std::size_t>(i)]);
      block.magnetic.fill(0, 3 * k + i, b[static_cast<std::size_t>(i)]);
      block.reference.fill(0, 3 * k + i, r[static_cast<std::size_t>(i)]);
    }
  }
  return block;
}

Fit fit(const std::vector<StationReadings>& stations, const FitOptions& o, const std::vector<double>& weights) {
  const FitPlan plan = fit_plan(o);
  const auto count = static_cast<int>(stations.size());
  require(weights.empty() || weights.size() == stations.size(), "weights: {} for {} stations", weights.size(), count);
  const SixAxisBlock block = block_of(stations);
  survey::LaneArray weight(1, count);
  for (int k = 0; k < count; ++k) weight.fill(0, k, weights.empty() ? 1 : weights[static_cast<std::size_t>(k)]);
  FitBlock found(1, o);
  fit_block(block, plan, o.parameters, found, weights.empty() ? nullptr : &weight);

  Fit out;
  out.converged = found.converged.value(0, 0) != 0;
  out.cost = found.cost.value(0, 0);
  out.iterations = static_cast<int>(found.iterations.value(0, 0));
  const int p = o.parameters.size();
  out.estimate.resize(p);
  for (int i = 0; i < p; ++i)
    out.tool[static_cast<std::size_t>(o.parameters.index(i))] = out.estimate[i] = found.estimate.value(0, i);
  out.reference = {found.reference.value(0, 0), found.reference.value(0, 1), found.reference.value(0, 2)};
  if (!out.converged) return out;
  const LinearRun run = linear_run(stations, out.tool, out.reference, o, plan, weights);
  out.residuals.resize(kResiduals, count);
  for (int k = 0; k < count; ++k) out.residuals.col(k) = run.stations[static_cast<std::size_t>(k)].residual;
  out.inverse = run.normal_inverse;
  if (!o.estimates_reference) {
    out.by_reference = MatrixXd::Zero(p, 3);
    const Eigen::Matrix3d by_reference = reference_derivatives(plan);
    for (int k = 0; k < count; ++k)
      out.by_reference -= (weights.empty() ? 1.0 : weights[static_cast<std::size_t>(k)]) * run.normal_inverse *
                          run.jacobian.middleRows<kResiduals>(kResiduals * k).transpose() *
                          run.stations[static_cast<std::size_t>(k)].by_reference * by_reference;
  }
  claim_for_variance(out, o, 1);
  return out;
}

void claim_for_variance(Fit& fit, const FitOptions& o, double variance) {
  const int p = o.parameters.size();
  const std::array<double, 3> sd = values(o.reference);
  const auto precision_of = [](double prior) { return prior > 0 ? 1 / (prior * prior) : 0; };  // 0: fixed
  VectorXd precision(fit.inverse.rows());
  for (int i = 0; i < p; ++i) precision[i] = precision_of(o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))]);
  for (Eigen::Index i = p; i < precision.size(); ++i) precision[i] = precision_of(sd[static_cast<std::size_t>(i - p)]);
  fit.joint = fit.inverse;
  if (variance != 1) {
    const MatrixXd of_priors = fit.inverse * precision.asDiagonal() * fit.inverse;
    fit.joint = variance * (fit.inverse - of_priors) + of_priors;
  }
  fit.posterior = fit.joint.topLeftCorner(p, p);
  fit.covariance = fit.posterior;
  if (o.estimates_reference) {
    const VectorXd left = fit.joint.diagonal().tail<3>().cwiseSqrt();
    fit.reference_sd = {left[0], left[1], left[2]};
  } else {
    fit.reference_sd = o.reference;
    const MatrixXd moved = fit.by_reference * Eigen::Map<const Eigen::Vector3d>(sd.data()).asDiagonal();
    fit.covariance += moved * moved.transpose();
  }
  fit.learnt.resize(p);
  for (int i = 0; i < p; ++i) {
    const double prior = o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))];
    fit.learnt[i] = std::isfinite(prior) ? 1 - fit.covariance(i, i) / (prior * prior) : 1;
  }
}

FitSensitivity fit_sensitivity(const std::vector<StationReadings>& stations, const PerParameter<double>& tool,
                               const FitOptions& o, const std::vector<double>& weights) {
  const FitPlan plan = fit_plan(o);
  // The estimator linearises at what it estimates: errors that it does not know stay in its readings.
  PerParameter<double> known{};
  for (int i = 0; i < kParameters; ++i)
    if (o.parameters.contains(i)) known[static_cast<std::size_t>(i)] = tool[static_cast<std::size_t>(i)];
  const LinearRun run = linear_run(stations, known, {}, o, plan, weights);
  const int p = o.parameters.size();
  const Eigen::Matrix3d by_reference = reference_derivatives(plan);
  FitSensitivity out;
  const auto n = run.normal_inverse.rows();
  out.posterior = run.normal_inverse.topLeftCorner(p, p);
  out.of_priors = run.normal_inverse.topRows(p) * run.prior_precision.asDiagonal() * run.normal_inverse.leftCols(p);
  out.by_truth = Eigen::Matrix<double, Eigen::Dynamic, kParameters>::Zero(n, kParameters);
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Eigen::Matrix<double, Eigen::Dynamic, 3> gain =
        -(weights.empty() ? 1.0 : weights[k]) * run.normal_inverse *
        run.jacobian.middleRows<kResiduals>(kResiduals * static_cast<Eigen::Index>(k)).transpose();
    const StationModel& m = run.stations[k];
    out.by_gravity.emplace_back(gain * m.by_gravity);
    out.by_magnetic.emplace_back(gain * m.by_magnetic);
    out.by_reference.emplace_back(gain * m.by_reference * by_reference);
    // A true error moves the readings against its column; for one of the set, by as much as the estimate should.
    for (int i = 0; i < kParameters; ++i)
      if (!o.parameters.contains(i)) out.by_truth.col(i) -= gain * m.by_parameter.col(i);
  }
  for (int i = 0; i < p; ++i)
    out.by_truth.col(o.parameters.index(i)) = -run.normal_inverse.col(i) * run.prior_precision[i];
  return out;
}

void fit_block(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set, FitBlock& out,
               const survey::LaneArray* weights) {
  const FitBatch batch = batch_of(readings, plan, set, out, weights);
  simd::run_kernel<isa_v3::fit_batch, isa_v4::fit_batch>(batch);
}

void correct_block(SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set, const FitBlock& estimates) {
  FitBatch batch = batch_of(readings, plan, set, estimates, nullptr);
  batch.gravity_out = readings.gravity.row(0, 0);
  batch.magnetic_out = readings.magnetic.row(0, 0);
  simd::run_kernel<isa_v3::correct_batch, isa_v4::correct_batch>(batch);
}

void residual_block(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set,
                    const FitBlock& estimates, survey::LaneArray& residuals) {
  FitBatch batch = batch_of(readings, plan, set, estimates, nullptr);
  batch.residuals = residuals.row(0, 0);
  batch.residuals_stride = residuals.group_stride();
  simd::run_kernel<isa_v3::residual_batch, isa_v4::residual_batch>(batch);
}

}  // namespace surveymc::multistation
