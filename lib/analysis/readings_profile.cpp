#include "analysis/readings_profile.h"

#include <algorithm>
#include <cmath>

#include "analysis/msa_chain.h"
#include "base/units.h"
#include "orders/profile.h"
#include "stats/intervals.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What a run's result is, of which the profile takes the path exactly and the rest to first order: without curvature
/// of the rest. Errors that are drawn anew at every station shift an estimate one way, and with it the truth the other.
class Result : public orders::PathChain {
 public:
  explicit Result(const MsaChain& chain) : chain_(chain) {}
  Eigen::Index dimension() const override { return chain_.dimension(); }
  orders::Expansion expand(const VectorXd& z, const VectorXd& state,
                           const orders::ExpansionParts& parts) const override {
    orders::Expansion e;
    e.first = first(z, state);
    e.trace.setZero();
    e.along.fill(MatrixXd::Zero(dimension(), parts.directions.cols()));
    e.squares.setZero();
    return e;
  }

 protected:
  virtual Matrix3Xd first(const VectorXd& z, const VectorXd& state) const = 0;
  const MsaChain& chain_;
};

class LastPosition final : public Result {
 public:
  using Result::Result;
  orders::Path path(const VectorXd& v, const std::vector<double>& t) const override { return chain_.path(v, t); }

 private:
  Matrix3Xd first(const VectorXd& z, const VectorXd& state) const override { return chain_.expand(z, state, {}).first; }
};

/// One parameter, as the first of three components.
class Parameter final : public Result {
 public:
  Parameter(const MsaChain& chain, int parameter, double estimate)
      : Result(chain), parameter_(parameter), estimate_(estimate) {}
  orders::Path path(const VectorXd& v, const std::vector<double>& t) const override {
    orders::Path p = chain_.path(v, t);
    for (Eigen::Index i = 0; i < p.at.cols(); ++i)
      if (p.at.col(i).allFinite()) p.at.col(i) << chain_.parameters(p.states.col(i))[parameter_] - estimate_, 0, 0;
    return p;
  }

 private:
  Matrix3Xd first(const VectorXd& z, const VectorXd& state) const override {
    Matrix3Xd j = Matrix3Xd::Zero(3, z.size());
    j.row(0) = chain_.parameters_by_normals(z, state).row(parameter_);
    return j;
  }
  int parameter_;
  double estimate_;
};

survey::Survey survey_of(const survey::SixAxisReadings& r, const ReadingsAnalysis& a, double declination) {
  survey::Survey s;
  for (std::size_t k = 0; k < a.stations.size(); ++k) {
    const survey::Attitude& at = a.stations[k].corrected;
    s.stations.push_back({r.md[k], at.inclination, at.azimuth + declination, at.toolface});
  }
  return s;
}

sensor::CleanReadings readings_without_further_errors(const survey::SixAxisReadings& r, const ReadingsAnalysis& a) {
  sensor::CleanReadings clean{{}, r.magnetic_T, r.gravity_T, {}};
  for (std::size_t k = 0; k < r.md.size(); ++k) {
    const survey::Vec3<double>& m = r.magnetic_T[k];
    const estimate::Vector6d& x = a.parameters;
    clean.field_T.push_back({(m.x - x[3]) / x[0], (m.y - x[4]) / x[1], (m.z - x[5]) / x[2]});
    clean.down_T.push_back(scale(1 / norm(r.gravity_T[k]), r.gravity_T[k]));
  }
  return clean;
}

bool has_profile(const estimate::EstimatorOptions& o, int stations) {
  constexpr int kMostStations = 2000;
  const bool is_fit = o.name == "msa" || o.name == "msa_weighted" || o.name == "msa_joint";
  const estimate::InputErrors& a = o.assumed;
  const bool has_prior = o.name != "msa" && (a.gain > 0 || a.bias > 0 || a.axial_bias > 0);
  return is_fit && o.estimates_all() && !has_prior && stations <= kMostStations;
}

}  // namespace

double ProfiledInterval::shift() const {
  const double half = (first_high - first_low) / 2,
               moved = std::max(std::abs(profile_low - first_low), std::abs(profile_high - first_high));
  return moved == 0 ? 0 : moved / half;
}

std::vector<ProfiledInterval> profile_readings(const survey::SixAxisReadings& readings,
                                               const survey::ReferenceField& field, const sensor::NoiseModel& noise,
                                               const estimate::EstimatorOptions& estimator,
                                               const ReadingsAnalysis& analysis, double confidence) {
  std::vector<ProfiledInterval> all;
  if (!has_profile(estimator, readings.size())) return all;
  estimate::EstimatorOptions options = estimator;
  options.solver = "gauss_newton";
  MsaTrials trials{survey_of(readings, analysis, field.declination),
                   field,
                   readings_without_further_errors(readings, analysis),
                   noise,
                   {},
                   {}};
  for (std::size_t i = 0; i < 3; ++i) {
    trials.errors.gain[i] = analysis.parameters[static_cast<Eigen::Index>(i)];
    trials.errors.bias[i] = analysis.parameters[static_cast<Eigen::Index>(3 + i)];
  }
  const MsaChain chain(trials, options);

  const double z = stats::normal_quantile((1 + confidence) / 2);
  const auto add = [&](const std::string& name, double estimate, double variance, const orders::Profile& p, int axis) {
    ProfiledInterval x{name, estimate, std::sqrt(std::max(0.0, variance))};
    x.first_low = estimate - z * x.sd;
    x.first_high = estimate + z * x.sd;
    const Eigen::Vector3d direction = Eigen::Vector3d::Unit(axis);
    const bool has_value = !p.mixture.empty();
    const orders::Mixture smooth = orders::without_gaps(p);
    const auto end = [&](double q) { return has_value ? estimate + orders::quantile(smooth, direction, q) : kNaN; };
    x.profile_sd = has_value ? orders::shape_along(p.mixture, direction).sd : kNaN;
    x.profile_low = end((1 - confidence) / 2);
    x.profile_high = end((1 + confidence) / 2);
    for (const orders::Jump& j : p.jumps) x.jump_probability = std::max(x.jump_probability, j.probability);
    all.push_back(x);
  };
  orders::ExpansionParts squares;
  squares.squares = true;
  for (int i = 0; i < 6; ++i) {
    const Parameter parameter(chain, i, analysis.parameters[i]);
    add(std::string(estimate::parameter_name(i)) + (i < 3 ? "" : "_nT"), analysis.parameters[i],
        analysis.covariance(i, i), orders::profile(parameter, orders::centre_of(parameter, squares)), 0);
  }
  const LastPosition position(chain);
  const orders::Profile p = orders::profile(position, orders::centre_of(position, squares));
  const StationAnalysis& last = analysis.stations.back();
  for (int i = 0; i < 3; ++i)
    add(std::array{"north_m", "east_m", "vertical_m"}[static_cast<std::size_t>(i)], last.position[i],
        last.position_covariance(i, i), p, i);
  return all;
}

}  // namespace surveymc::analysis
