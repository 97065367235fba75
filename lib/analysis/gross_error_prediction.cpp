#include "analysis/gross_error_prediction.h"

#include <algorithm>
#include <cmath>

#include "reliability/identification.h"
#include "reliability/snooping.h"

namespace surveymc::analysis {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

ErrorShift shift_of(const std::vector<reliability::GrossError>& errors, const VectorXd& w, double omega) {
  ErrorShift shift;
  for (const reliability::GrossError& e : errors) shift.w.push_back(w[e.number]);
  shift.omega = omega;
  return shift;
}

/// Observations that cannot be told apart from `number`, and the largest |rho| of its test with that of another.
struct Company {
  reliability::SuspectGroup group;
  double closest = 0;
};
Company company_of(const reliability::ParityModel& m, Index number) {
  Company c;
  for (const reliability::SuspectGroup& g : reliability::inseparable_groups(m))
    if (std::find(g.begin(), g.end(), number) != g.end()) c.group = g;
  const Eigen::MatrixXd rho = reliability::test_correlations(m);
  for (Index i = 0; i < rho.cols(); ++i)
    if (i != number && std::find(c.group.begin(), c.group.end(), i) == c.group.end())
      c.closest = std::max(c.closest, std::abs(rho(number, i)));
  return c;
}

/// The adjustment of readings that are off by about one sd, each by another part of it.
reliability::StationAdjustment displaced(const reliability::GrossErrorTrials& trials) {
  VectorXd normals(trials.observations());
  for (Index i = 0; i < normals.size(); ++i) normals[i] = std::sqrt(2.0) * std::sin(1.0 + static_cast<double>(i));
  return trials.adjusted(trials.readings(normals, true));
}

}  // namespace

GrossErrorPrediction predict_gross_errors(const reliability::GrossErrorTrials& trials,
                                          const reliability::TestLevels& levels, bool pope) {
  const std::vector<reliability::GrossError>& errors = trials.errors();
  GrossErrorPrediction p;
  p.two_sided_alpha = reliability::two_sided_alpha(levels);
  p.model = reliability::linear_model(trials.model(), trials.attitudes());
  p.redundancy = static_cast<double>(p.model.redundancy);
  p.critical = pope ? reliability::pope_critical(p.redundancy, p.two_sided_alpha) : reliability::w_critical(levels);
  const double lambda = reliability::lambda0(levels);
  p.general = reliability::b_method_level(p.redundancy, lambda * lambda, levels.power);

  reliability::ParityModel shifted = p.model;
  shifted.whitened.setZero();
  for (const reliability::GrossError& e : errors) shifted.whitened += shifted.columns.col(e.number) * e.size;
  p.linear = shift_of(errors, reliability::w_statistics(shifted), shifted.omega());
  const reliability::StationAdjustment noise_free = trials.adjusted(trials.readings_without_noise(true));
  p.nonlinear = noise_free.converged ? shift_of(errors, reliability::w_statistics(noise_free.parity), noise_free.omega)
                                     : shift_of(errors, VectorXd::Constant(p.model.observations(), kNaN), kNaN);

  if (!pope)
    p.false_alarm_any = reliability::linear_rates(p.model, VectorXd::Zero(p.model.columns.rows()), 0, p.critical).any;
  if (errors.empty() || pope) return p;
  const Index number = errors.front().number;
  p.linear_any = reliability::linear_rates(p.model, shifted.whitened, number, p.critical).any;
  if (!noise_free.converged) return p;
  const reliability::ParityModel& m = noise_free.parity;
  const reliability::LinearRates rates = reliability::linear_rates(m, m.whitened, number, p.critical);
  p.any = rates.any;
  if (errors.size() != 1) return p;
  // A trial is grouped at its own attitude. A tie of the noise-free attitude alone, as of gz and gravity in a vertical
  // hole, is none of the trials', and what is nearly tied there is tied in some of them. A tie of the true attitude
  // alone is one of rare trials.
  constexpr double kNearlyTied = 1 - 1e-6;
  const Company at_truth = company_of(p.model, number), here = company_of(m, number);
  p.in_group = here.group.size() > 1;
  p.may_be_tied = here.group != at_truth.group || std::max(here.closest, at_truth.closest) > kNearlyTied;
  if (here.closest > kNearlyTied) return p;
  const reliability::StationAdjustment beside = displaced(trials);
  if (beside.converged && company_of(beside.parity, number).group == here.group) p.identified = rates.identified;
  return p;
}

double single_test_power(const GrossErrorPrediction& p, const ErrorShift& shift, std::size_t k, bool pope) {
  if (std::isnan(shift.w[k])) return kNaN;
  if (!pope) return reliability::w_power(shift.w[k], p.critical);
  // The denominator of Pope's test is free of the error only if there is one error, and in linear theory
  const bool central = shift.w.size() == 1 && &shift == &p.linear;
  return central ? reliability::pope_power(shift.w[k], p.redundancy, p.two_sided_alpha) : kNaN;
}

}  // namespace surveymc::analysis
