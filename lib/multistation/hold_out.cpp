#include "multistation/hold_out.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "base/error.h"
#include "base/units.h"
#include "stats/intervals.h"
#include "stats/linear_algebra.h"

namespace surveymc::multistation {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kOfReference = 3;

Vector3d errors_of(const ReferenceErrors& e) { return {e.gravity, e.total, e.dip}; }

/// Rows of a station by the unknowns, parameters of the set and errors of the reference, at the estimate; its residual
/// about the estimated reference.
struct Rows {
  Vector3d residual;
  MatrixXd by_unknowns;
};
Rows rows_of(StationReadings station, const Fit& fit, const FitOptions& o, const Matrix3d& by_errors) {
  const Vector3d moved = by_errors * errors_of(fit.reference);
  station.reference.gravity += moved[0];
  station.reference.first += moved[1];
  station.reference.second += moved[2];
  const StationModel m = station_model(station, fit.tool, o.residuals, o.sizes);
  const int p = o.parameters.size();
  Rows r{m.residual, MatrixXd(kResiduals, p + kOfReference)};
  for (int i = 0; i < p; ++i) r.by_unknowns.col(i) = m.by_parameter.col(o.parameters.index(i));
  r.by_unknowns.rightCols<kOfReference>() = m.by_reference * by_errors;
  return r;
}

double spread(const std::vector<double>& x) {
  double mean = 0, squares = 0;
  for (const double v : x) mean += v / static_cast<double>(x.size());
  for (const double v : x) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / (static_cast<double>(x.size()) - 1));
}

FieldNumbers spread(const std::vector<HeldStation>& stations, FieldNumbers HeldStation::*which) {
  const auto of = [&](double FieldNumbers::*number) {
    std::vector<double> x;
    for (const HeldStation& s : stations) x.push_back(s.*which.*number);
    return spread(x);
  };
  return {of(&FieldNumbers::gravity), of(&FieldNumbers::total), of(&FieldNumbers::dip)};
}

Stations those(const Stations& all, const std::vector<int>& indices, bool are_kept) {
  Stations out;
  for (int k = 0; k < static_cast<int>(all.size()); ++k)
    if ((std::find(indices.begin(), indices.end(), k) != indices.end()) == are_kept)
      out.push_back(all[static_cast<std::size_t>(k)]);
  return out;
}

}  // namespace

double learnt_parameters(const Fit& fit, const FitOptions& o) {
  double sum = 0;
  const auto add = [&sum](double posterior_sd, double prior_sd) {
    sum += std::isfinite(prior_sd) ? std::clamp(1 - std::pow(posterior_sd / prior_sd, 2), 0.0, 1.0) : 1.0;
  };
  const int p = o.parameters.size();
  for (int i = 0; i < p; ++i)
    add(std::sqrt(fit.inverse(i, i)), o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))]);
  if (!o.estimates_reference) return sum;
  const Vector3d prior = errors_of(o.reference);
  for (int i = 0; i < kOfReference; ++i)
    if (prior[i] > 0) add(std::sqrt(fit.inverse(p + i, p + i)), prior[i]);
  return sum;
}

FittedStations fit_by_least_squares(const Stations& stations, const FitOptions& options) {
  FittedStations f{fit(stations, options), {}, 1};
  if (!f.fit.converged) return f;
  const double redundancy = static_cast<double>(kResiduals * stations.size()) - learnt_parameters(f.fit, options);
  f.s0 = redundancy > 0 ? std::sqrt(f.fit.residuals.squaredNorm() / redundancy) : kNaN;
  claim_for_variance(f.fit, options, f.s0 * f.s0);
  return f;
}

FittedStations fit_robustly(const Stations& stations, const FitOptions& options, const RobustOptions& robust,
                            const random::Stream& stream) {
  const RobustFit r = robust_fit(stations, options, robust, stream);
  FittedStations f{r.fit, r.weights, 1};
  const double residuals = robust_components(fit_plan(options)) * static_cast<double>(stations.size());
  const double redundancy = residuals - learnt_parameters(f.fit, options);
  f.s0 = redundancy > 0 ? r.scale * std::sqrt(residuals / redundancy) : kNaN;
  claim_for_variance(f.fit, options, f.s0 * f.s0 * r.factor);
  return f;
}

VarianceComponents residual_components(const Stations& stations, const FitOptions& options) {
  const Matrix3d by_errors = reference_derivatives(fit_plan(options));
  const auto count = static_cast<Eigen::Index>(stations.size());
  std::vector<int> group;
  for (std::size_t k = 0; k < stations.size(); ++k)
    for (int j = 0; j < kResiduals; ++j) group.push_back(j);
  return variance_components(group, kResiduals, [&](const std::vector<double>& factors) {
    FitOptions o = options;
    for (std::size_t j = 0; j < factors.size(); ++j) o.sizes[j] *= std::sqrt(factors[j]);
    const Fit f = fit(stations, o);
    require(f.converged, "the fit for variance components does not converge");
    const Eigen::Index unknowns = f.inverse.rows();
    GroupedFit g{VectorXd(kResiduals * count), MatrixXd(kResiduals * count, unknowns),
                 VectorXd::Ones(kResiduals * count), f.inverse};
    for (Eigen::Index k = 0; k < count; ++k) {
      const Rows r = rows_of(stations[static_cast<std::size_t>(k)], f, options, by_errors);
      g.residuals.segment<kResiduals>(kResiduals * k) = r.residual;
      g.jacobian.middleRows<kResiduals>(kResiduals * k) = r.by_unknowns.leftCols(unknowns);
    }
    return g;
  });
}

FitOptions with_components(FitOptions options, const VarianceComponents& components) {
  for (std::size_t j = 0; j < options.sizes.size(); ++j) options.sizes[j] *= std::sqrt(components.groups[j].factor);
  return options;
}

double information_criterion(const Fit& fit, const FitOptions& options, std::size_t stations) {
  const auto m = static_cast<double>(kResiduals * stations);
  return m * std::log(fit.cost / m) + learnt_parameters(fit, options) * std::log(m);
}

FieldNumbers field_numbers(const StationReadings& station, const PerParameter<double>& tool) {
  const TriadErrors a = accelerometer_errors(tool), m = magnetometer_errors(tool);
  const Vector3d g = a.matrix.inverse() * (survey::to_eigen(station.gravity_T) - a.bias),
                 b = m.matrix.inverse() * (survey::to_eigen(station.magnetic_T) - m.bias);
  return {g.norm(), b.norm(), std::asin(g.dot(b) / (g.norm() * b.norm()))};
}

std::vector<HeldStation> judge_held_out(const FittedStations& fitted, const Stations& held, const FitOptions& o) {
  const Matrix3d by_errors = reference_derivatives(fit_plan(o));
  const Matrix3d reference_sd = errors_of(o.reference).asDiagonal();
  const Eigen::Index unknowns = fitted.fit.joint.rows();
  std::vector<HeldStation> out;
  for (const StationReadings& s : held) {
    const Rows r = rows_of(s, fitted.fit, o, by_errors);
    const MatrixXd j = r.by_unknowns.leftCols(unknowns);
    Matrix3d expected = fitted.s0 * fitted.s0 * Matrix3d::Identity() + j * fitted.fit.joint * j.transpose();
    if (!o.estimates_reference) {
      const Matrix3d e = (r.by_unknowns.rightCols<kOfReference>() + j * fitted.fit.by_reference) * reference_sd;
      expected += e * e.transpose();
    }
    const double distance = r.residual.dot(Vector3d(expected.inverse() * r.residual));
    out.push_back({distance, field_numbers(s, {}), field_numbers(s, fitted.fit.tool)});
  }
  return out;
}

Matrix3d earth_from_tool(const StationReadings& station, const PerParameter<double>& tool) {
  const TriadErrors a = accelerometer_errors(tool), m = magnetometer_errors(tool);
  const Vector3d down = Vector3d(a.matrix.inverse() * (survey::to_eigen(station.gravity_T) - a.bias)).normalized(),
                 field = m.matrix.inverse() * (survey::to_eigen(station.magnetic_T) - m.bias),
                 east = down.cross(field).normalized();
  Matrix3d r;
  r.row(0) = east.cross(down);
  r.row(1) = east;
  r.row(2) = down;
  return r;
}

Vector3d turning_axis(const std::vector<Group>& groups, const PerParameter<double>& tool) {
  // The mean of R a over a group is the longer the less R a varies.
  Matrix3d sum = Matrix3d::Zero();
  for (const Group& group : groups) {
    Matrix3d mean = Matrix3d::Zero();
    double weights = 0;
    for (std::size_t k = 0; k < group.stations.size(); ++k) {
      const double w = group.weights.empty() ? 1 : group.weights[k];
      mean += w * earth_from_tool(group.stations[k], tool);
      weights += w;
    }
    mean /= weights;
    sum += mean.transpose() * mean;
  }
  return stats::symmetric_eigen<3>(sum).vectors.col(2);
}

double scatter_of_axis(const Stations& group, const PerParameter<double>& tool, const Vector3d& axis) {
  std::vector<Vector3d> pointed;
  Vector3d mean = Vector3d::Zero();
  for (const StationReadings& s : group) mean += pointed.emplace_back(earth_from_tool(s, tool) * axis);
  double squares = 0;
  for (const Vector3d& d : pointed) squares += std::pow(std::atan2(d.cross(mean).norm(), d.dot(mean)), 2);
  return std::sqrt(squares / static_cast<double>(group.size()));
}

CrossValidation cross_validate(const Stations& stations, const std::vector<std::vector<int>>& folds, bool are_groups,
                               const FitOptions& options, const Fitter& fitter) {
  CrossValidation c;
  const double within = stats::chi_squared_quantile(kResiduals, 0.95),
               count_of_folds = static_cast<double>(folds.size());
  const auto add_squares = [count_of_folds](FieldNumbers& sum, const FieldNumbers& x) {
    sum.gravity += x.gravity * x.gravity / count_of_folds;
    sum.total += x.total * x.total / count_of_folds;
    sum.dip += x.dip * x.dip / count_of_folds;
  };
  double scatter = 0, scatter_before = 0;
  for (const std::vector<int>& fold : folds) {
    const Stations seen = those(stations, fold, false), held = those(stations, fold, true);
    const FittedStations fitted = fitter(seen);
    require(fitted.fit.converged, "the fit of {} parameters to {} stations does not converge",
            options.parameters.size(), seen.size());
    const std::vector<HeldStation> judged = judge_held_out(fitted, held, options);
    add_squares(c.spread_before, spread(judged, &HeldStation::before));
    add_squares(c.spread_after, spread(judged, &HeldStation::after));
    c.stations.insert(c.stations.end(), judged.begin(), judged.end());
    if (!are_groups || folds.size() < 2) continue;
    // Where the fit has given a shot no weight, the axis has none of it, either.
    std::vector<Group> others;
    for (const std::vector<int>& other : folds) {
      if (other == fold) continue;
      others.push_back({those(stations, other, true)});
      if (fitted.weights.empty()) continue;
      for (const int k : other)
        others.back().weights.push_back(fitted.weights[static_cast<std::size_t>(
            k - std::count_if(fold.begin(), fold.end(), [k](int held_k) { return held_k < k; }))]);
    }
    const auto scatter_with = [&](const PerParameter<double>& tool) {
      return scatter_of_axis(held, tool, turning_axis(others, tool));
    };
    c.axis_scatter.push_back(scatter_with(fitted.fit.tool));
    scatter += std::pow(c.axis_scatter.back(), 2) / count_of_folds;
    scatter_before += std::pow(scatter_with({}), 2) / count_of_folds;
  }
  for (FieldNumbers* s : {&c.spread_before, &c.spread_after})
    *s = {std::sqrt(s->gravity), std::sqrt(s->total), std::sqrt(s->dip)};
  c.axis_rms = c.axis_scatter.empty() ? kNaN : std::sqrt(scatter);
  c.axis_rms_before = c.axis_scatter.empty() ? kNaN : std::sqrt(scatter_before);
  const auto count = static_cast<double>(c.stations.size());
  std::vector<double> distances;
  for (const HeldStation& s : c.stations) distances.push_back(s.distance);
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  c.nees_median = *middle / stats::chi_squared_quantile(kResiduals, 0.5);
  for (const HeldStation& s : c.stations) {
    c.nees += s.distance / (kResiduals * count);
    c.coverage += (s.distance <= within) / count;
  }
  return c;
}

}  // namespace surveymc::multistation
