#include "analysis/gross_error_prediction.h"

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::analysis;

namespace {

/// One station far from the singular attitudes; an error of `size` sensitivities in bx.
reliability::GrossErrorTrials trials(double size) {
  reliability::AdjustmentModel model;
  model.field.dip = 72 * kDegree;
  const std::vector<survey::Attitude> attitudes{{50 * kDegree, 40 * kDegree, 110 * kDegree}};
  const auto bx = static_cast<Eigen::Index>(reliability::index_of(reliability::Observation::bx));
  const double unit = 1 / reliability::sensitivities(reliability::linear_model(model, attitudes))[bx];
  return {model, attitudes, {{bx, size * unit}}, random::Stream(1, 20)};
}

}  // namespace

TEST_CASE("An error of the minimal detectable size is found with the power of the test, in linear theory") {
  const reliability::TestLevels levels;
  const GrossErrorPrediction p = predict_gross_errors(trials(reliability::lambda0(levels)), levels, false);
  CHECK(p.linear.w[0] == Approx(reliability::lambda0(levels)).epsilon(1e-10));
  CHECK(p.linear.omega == Approx(p.linear.w[0] * p.linear.w[0]).epsilon(1e-10));  // an error of one reading alone
  CHECK(single_test_power(p, p.linear, 0, false) == Approx(levels.power).epsilon(1e-8));
  CHECK(p.linear_any >= levels.power - 2e-4);  // linear_rates is good to 2e-4
  CHECK(p.false_alarm_any > p.two_sided_alpha);
  CHECK(p.false_alarm_any < p.two_sided_alpha * static_cast<double>(p.model.observations()));
}

TEST_CASE("The nonlinear prediction of a small error is the linear one, and of a large one is not") {
  const reliability::TestLevels levels;
  const GrossErrorPrediction small = predict_gross_errors(trials(1e-3), levels, false),
                             large = predict_gross_errors(trials(40), levels, false);
  CHECK(small.nonlinear.w[0] == Approx(small.linear.w[0]).epsilon(1e-4));
  CHECK(std::abs(large.nonlinear.w[0] / large.linear.w[0] - 1) > 1e-3);
}

TEST_CASE("Pope's test has a power for one error in linear theory only") {
  const reliability::TestLevels levels;
  const GrossErrorPrediction p = predict_gross_errors(trials(5), levels, true);
  CHECK(single_test_power(p, p.linear, 0, true) > 0);
  CHECK(std::isnan(single_test_power(p, p.nonlinear, 0, true)));
  CHECK(std::isnan(p.any));
}
