#include "analysis/gross_error_prediction.h"

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::analysis;

namespace {

/// One station far from the singular attitudes; an error of `size` sensitivities in bx.
reliability::GrossErrorTrials trials(double size) {
  const reliability::AdjustmentModel model{.field = {9.82, 51000, 72 * kDegree}};
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

TEST_CASE("What one error is identified as is predicted only where noise does not tie or untie it", "[long]") {
  struct Case {
    reliability::AdjustmentMode mode;
    double inclination, toolface, azimuth;
    reliability::Observation in_error;
    bool known, in_group, may_be_tied;
  };
  using enum reliability::Observation;
  using enum reliability::AdjustmentMode;
  for (const Case& c :
       {Case{sse, 50, 110, 40, bx, true, false, false},      //
        Case{sse_axial, 30, 45, 60, bx, true, true, false},  // tied at any attitude
        Case{sse, 0, 30, 40, gz, false, true, false},        // gz and gravity, in a vertical hole only
        Case{sse, 0.02, 30, 40, gz, false, false, true},     // |rho| 1 - 2e-9: noise ties them now and then
        Case{sse, 1, 30, 40, gz, true, false, false},        // 1 - 6e-6: far beyond the noise
        Case{sse, 30, 0, 90, bz, true, false, true}}) {      // bz and by, until the error turns the tool
    const reliability::AdjustmentModel model{.mode = c.mode, .field = {9.82, 51000, 75 * kDegree}};
    const std::vector<survey::Attitude> attitudes{{c.inclination * kDegree, c.azimuth * kDegree, c.toolface * kDegree}};
    const auto number = static_cast<Eigen::Index>(reliability::index_of(c.in_error));
    const reliability::TestLevels levels;
    const double size =
        reliability::lambda0(levels) / reliability::sensitivities(reliability::linear_model(model, attitudes))[number];
    const GrossErrorPrediction p =
        predict_gross_errors({model, attitudes, {{number, size}}, random::Stream(1, 20)}, levels, false);
    INFO("I " << c.inclination << ", toolface " << c.toolface << ", azimuth " << c.azimuth);
    CHECK(std::isnan(p.identified) == !c.known);
    CHECK(p.any > 0.5);
    CHECK(p.in_group == c.in_group);
    CHECK(p.may_be_tied == c.may_be_tied);
  }
}

TEST_CASE("Pope's test has a power for one error in linear theory only") {
  const reliability::TestLevels levels;
  const GrossErrorPrediction p = predict_gross_errors(trials(5), levels, true);
  CHECK(single_test_power(p, p.linear, 0, true) > 0);
  CHECK(std::isnan(single_test_power(p, p.nonlinear, 0, true)));
  CHECK(std::isnan(p.any));
}
