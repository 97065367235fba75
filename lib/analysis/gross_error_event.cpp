#include "analysis/gross_error_event.h"

#include <algorithm>
#include <cmath>

#include "reliability/snooping.h"

namespace surveymc::analysis {

using Eigen::Index;
using Eigen::VectorXd;

double GrossErrorEvent::value(const VectorXd& normals) const {
  const bool with_errors = kind_ != GrossErrorEventKind::false_alarm_any;
  const reliability::StationAdjustment a = trials_.adjusted(trials_.readings(normals, with_errors));
  if (!a.converged) return kNaN;
  const reliability::TrialTests t = reliability::GrossErrorTrials::tests_of(a);
  const double unit = pope_ ? std::sqrt(prediction_.redundancy / t.omega) : 1;
  const double beyond = t.largest * unit - prediction_.critical;
  if (kind_ == GrossErrorEventKind::missed) return beyond;
  if (kind_ == GrossErrorEventKind::false_alarm_any) return -beyond;
  double right = 0, other = 0;
  const auto has_error = [&](Index i) {
    return std::any_of(trials_.errors().begin(), trials_.errors().end(),
                       [i](const reliability::GrossError& e) { return e.number == i; });
  };
  for (Index i = 0; i < t.w.size(); ++i) {
    double& most = has_error(i) ? right : other;
    most = std::max(most, std::abs(t.w[i]) * unit);
  }
  const bool is_wrong = beyond > 0 && std::none_of(t.suspects.begin(), t.suspects.end(), has_error);
  const double g = std::max(-beyond, right - other);
  constexpr double kOutside = 1e-9;  // tests that are one with that of an error stand beside it, not before it
  return is_wrong ? std::min(g, 0.0) : std::max(g, kOutside);
}

void GrossErrorEvent::evaluate(const survey::LaneArray& z, int groups, double* g) const {
  VectorXd normals(trials_.observations());
  for (int t = 0; t < groups * simd::kGroup; ++t) {
    for (int i = 0; i < trials_.observations(); ++i) normals[i] = z.value(t, i);
    g[t] = value(normals);
  }
}

std::vector<rare::HalfSpace> test_half_spaces(const reliability::GrossErrorTrials& trials,
                                              const GrossErrorPrediction& prediction) {
  const reliability::ParityModel& m = prediction.model;
  const Index rows = (trials.observations() + 3) / 4 * 4;
  const VectorXd sd = trials.standard_deviations();
  std::vector<rare::HalfSpace> all;
  for (const reliability::SuspectGroup& group : reliability::inseparable_groups(m)) {
    const Index i = group.front();
    const double length = m.columns.col(i).norm();
    if (!(length > 0)) continue;
    VectorXd direction = VectorXd::Zero(rows);
    direction.head(sd.size()) = (m.columns.transpose() * m.columns.col(i) / length).cwiseProduct(sd);
    rare::add_two_sided(direction / direction.norm(), prediction.critical, all);
  }
  return all;
}

}  // namespace surveymc::analysis
