#include "estimate/field_fit.h"

#include <algorithm>

#include <Eigen/LU>

#include "base/error.h"
#include "estimate/estimators.h"
#include "estimate/field_fit_estimators.h"
#include "estimate/field_fit_lanes.h"
#include "estimate/field_fit_point.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Matrix2d field_covariance(const InputErrors& a, const survey::ReferenceField& field, bool with_reference) {
  const double bh = field.total * std::cos(field.dip), bv = field.total * std::sin(field.dip);
  Matrix2d r = a.magnetometer * a.magnetometer * Matrix2d::Identity();
  const Vector2d tilt = a.down * Vector2d(-bv, bh);
  r += tilt * tilt.transpose();
  Matrix2d by_field;  // (Bh, Bv) by (total, dip)
  by_field << std::cos(field.dip), -bv, std::sin(field.dip), bh;
  const auto add = [&](double total, double dip) {
    const Matrix2d e = by_field * Vector2d(total, dip).asDiagonal();
    r += e * e.transpose();
  };
  if (a.station_total > 0 || a.station_dip > 0) add(a.station_total, a.station_dip);
  if (with_reference) add(a.total, a.dip);
  return r;
}

FieldFitModel field_fit_model(const EstimatorOptions& o, const survey::ReferenceField& field) {
  FieldFitModel m;
  m.total = field.total;
  m.estimated = o.estimated;
  if (o.name == "msa") return m;
  require(o.name == "msa_weighted" || o.name == "msa_joint" || o.name == "wls_consider",
          "estimator.name = \"{}\": no fit of the horizontal and vertical field", o.name);
  const InputErrors& a = o.assumed;
  require_weights(a);
  m.joint = o.name == "msa_joint";
  m.fitted_derivative = (o.derivative.empty() ? estimator_kind(o.name).derivative : o.derivative) == "fitted";
  // R includes the reference's errors as if drawn anew at every station; for a joint estimate only where they are so.
  const bool in_weights = o.name == "msa_weighted" || (m.joint && a.reference_per_station);
  const double s2 = a.magnetometer * a.magnetometer;
  const Matrix2d w = s2 * field_covariance(a, field, in_weights).inverse();
  m.w_hh = w(0, 0);
  m.w_hv = w(0, 1);
  m.w_vv = w(1, 1);
  if (m.joint && !in_weights) {
    m.total_sd = a.total / field.total;
    m.dip_sd = a.dip;
  }
  m.unit_weight = s2 / (field.total * field.total);
  if (a.gain > 0) m.gain_prior = m.unit_weight / (a.gain * a.gain);
  for (int axis = 0; axis < 3; ++axis)
    if (const double sd = a.bias_sd(axis); sd > 0) m.bias_prior[static_cast<std::size_t>(axis)] = s2 / (sd * sd);
  return m;
}

namespace {

class FieldFit final : public Estimator {
 public:
  FieldFit(std::string name, const FieldFitModel& model, const NewtonOptions& options)
      : name_(std::move(name)), model_(model), options_(options) {}
  std::string name() const override { return name_; }
  bool estimates_reference() const override { return model_.joint; }

  void solve(const survey::ReadingBlock& in, EstimateBlock& out) const override {
    FieldFitBatch batch{};
    batch.first = {in.magnetic.row(0, 0), in.down.row(0, 0), in.reference.row(0, 0), in.stations, in.reference_stride};
    batch.magnetic_stride = in.magnetic.group_stride();
    batch.down_stride = in.down.group_stride();
    batch.reference_stride = in.reference.group_stride();
    batch.parameters = out.parameters.row(0, 0);
    batch.cost = out.cost.row(0, 0);
    batch.iterations = out.iterations.row(0, 0);
    batch.converged = out.converged.row(0, 0);
    batch.parameters_stride = out.parameters.group_stride();
    batch.scalar_stride = out.cost.group_stride();
    batch.reference_estimate = out.reference.row(0, 0);
    batch.reference_estimate_stride = out.reference.group_stride();
    batch.groups = in.groups();
    batch.model = model_;
    batch.options = options_;
    simd::run_kernel<isa_v3::field_fit_batch, isa_v4::field_fit_batch>(batch);
  }

 private:
  std::string name_;
  FieldFitModel model_;
  NewtonOptions options_;
};

}  // namespace

FieldFitPoint field_fit_point(const FieldFitModel& model, const EstimateBlock& estimates,
                              const survey::ReadingBlock& readings, int trial) {
  FieldFitPoint p;
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(i);
    p.x[a] = 1 / estimates.parameters.value(trial, i);
    p.x[3 + a] = estimates.parameters.value(trial, 3 + i) * p.x[a] / model.total;
  }
  if (model.joint) {
    const double h = estimates.reference.value(trial, 0), v = estimates.reference.value(trial, 1),
                 given_h = readings.reference.value(trial, 0), given_v = readings.reference.value(trial, 1);
    if (model.total_sd > 0) p.x[6] = (std::hypot(h, v) - std::hypot(given_h, given_v)) / (model.total_sd * model.total);
    if (model.dip_sd > 0) p.x[7] = (std::atan2(v, h) - std::atan2(given_v, given_h)) / model.dip_sd;
  }
  p.cost = estimates.cost.value(trial, 0);
  p.converged = estimates.converged.value(trial, 0) != 0;
  return p;
}

namespace {

template <std::size_t N>
FieldFitPoint solve_from(const FieldFitModel& model, const FieldFitData& data, const FieldFitPoint& from,
                         double step_tolerance) {
  std::array<double, N> start;
  std::copy_n(from.x.begin(), N, start.begin());
  NewtonOptions options;
  options.step_tolerance = step_tolerance;
  const NewtonSolution<double, N> s = field_fit_solution<double, N>(model, data, start, options);
  FieldFitPoint p;
  std::copy_n(s.x.begin(), N, p.x.begin());
  p.cost = s.cost * model.total * model.total;
  p.converged = s.converged > 0 && are_sound(s.x);
  return p;
}

}  // namespace

FieldFitPoint field_fit_from(const FieldFitModel& model, const survey::ReadingBlock& readings, int trial,
                             const FieldFitPoint& start, double step_tolerance) {
  const auto lane = static_cast<std::size_t>(trial % simd::kGroup);
  const int group = trial / simd::kGroup;
  const FieldFitData data{readings.magnetic.row(group, 0) + lane, readings.down.row(group, 0) + lane,
                          readings.reference.row(group, 0) + lane, readings.stations, readings.reference_stride};
  return model.joint ? solve_from<8>(model, data, start, step_tolerance)
                     : solve_from<6>(model, data, start, step_tolerance);
}

std::unique_ptr<Estimator> make_field_fit(const std::string& name, const FieldFitModel& model,
                                          const NewtonOptions& options) {
  return std::make_unique<FieldFit>(name, model, options);
}

}  // namespace surveymc::estimate
