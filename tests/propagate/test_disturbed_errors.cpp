#include "propagate/disturbed_errors.h"

#include <cmath>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "propagate/drawn_well.h"
#include "proximity/pair_errors.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Matrix3d;
using surveymc::test::field_of;
using surveymc::test::shipped;
using surveymc::test::survey_of;

namespace {

struct Case {
  survey::Survey survey;
  survey::ReferenceField field = field_of(50500, 73, 3);
  std::vector<ToolRun> runs;
  WellErrors errors;
  std::optional<DisturbedDraws> disturbed;

  Case(const std::string& model, disturbance::Disturbance d, int stations = 40) {
    survey = survey_of(stations, [](int k) {
      return survey::Station{30.0 * k, std::min(3.0 * k, 90.0) * kDegree, (20 + 0.5 * k) * kDegree, 0};
    });
    // Uneven steps.
    double time = 0;
    for (int k = 0; k < stations; ++k) d.times.push_back(time += 1800 + 900 * (k % 3));
    runs = disturbed_runs({{1, shipped(model)}}, d, field);
    errors = well_errors(survey, survey::true_vertical_depths(survey), runs, field, 60 * kDegree);
    disturbed = disturbed_draws(errors, runs, d, field);
    disturbance_ = d;
  }
  ToolCovariances covariances() const {
    StationEffects effects;
    ToolCovariances c = tool_covariances(survey, survey::true_vertical_depths(survey), runs, field, 60 * kDegree,
                                         SourceDetail::all, &effects);
    add_correlation(c, effects, runs, disturbance_, field, SourceDetail::all);
    return c;
  }
  proximity::PositionErrors pair_errors(proximity::Interpolation how) const {
    return proximity::position_errors(survey, survey::true_vertical_depths(survey), runs, field, 60 * kDegree, how,
                                      nullptr, &disturbance_);
  }

 private:
  disturbance::Disturbance disturbance_;
};

disturbance::Disturbance ar1(double tau, bool match = true) {
  disturbance::Disturbance d;
  d.match_variance = match;
  d.process.tau = tau;
  d.process.sd = match ? Eigen::Vector3d::Zero() : Eigen::Vector3d(30, 25, 20);
  return d;
}

disturbance::Disturbance waves(bool match) {
  disturbance::Disturbance d;
  d.match_variance = match;
  d.process.kind = disturbance::Kind::series;
  Matrix3d amplitude, maximum;
  amplitude << 20, 9, 4, 35, 12, 6, 8, 2, 1;
  maximum << 11, 3, 1, 8, 2, 5, 14, 9, 6;
  d.process.series = std::make_shared<const disturbance::Series>(disturbance::daily_waves(amplitude, maximum));
  return d;
}

}  // namespace

TEST_CASE("Covariances with a disturbance: sums of effects, and effects of independent draws, are one") {
  for (const auto& d : {ar1(7000), ar1(7000, false), waves(true), waves(false)}) {
    const Case c("MWD+IFR1+AX", d);
    const ToolCovariances sums = c.covariances();
    const WellErrors independent = with_independent_draws(c.errors, *c.disturbed);
    for (const std::size_t k : {std::size_t{1}, std::size_t{2}, std::size_t{17}, std::size_t{39}}) {
      const Matrix3d by_draws = covariance_of(draw_effects(independent, {k, 1}, FirstOrder::iscwsa));
      CHECK((sums.total[k] - by_draws).norm() < 1e-6 * by_draws.trace());
    }
  }
}

TEST_CASE("Errors of a pair's well with a disturbance are those of independent draws, at stations and between them") {
  for (const auto& d : {ar1(7000), ar1(7000, false), waves(true)}) {
    const Case c("MWD+IFR1+AX", d);
    const WellErrors independent = with_independent_draws(c.errors, *c.disturbed);
    const proximity::PositionErrors linear = c.pair_errors(proximity::Interpolation::covariance),
                                    drawn = c.pair_errors(proximity::Interpolation::effects);
    CHECK(linear.sources.size() == drawn.sources.size());  // R is none that wells share
    for (const std::size_t k : {std::size_t{2}, std::size_t{17}, std::size_t{38}}) {
      const Eigen::Matrix3Xd here = draw_effects(independent, {k, 1}, FirstOrder::iscwsa),
                             next = draw_effects(independent, {k + 1, 1}, FirstOrder::iscwsa);
      CHECK((linear.covariance[k] - covariance_of(here)).norm() < 1e-6 * covariance_of(here).trace());
      CHECK(linear.covariance[k] == drawn.covariance[k]);
      for (const double f : {0.3, 0.5}) {
        const Matrix3d between = covariance_of(Eigen::Matrix3Xd((1 - f) * here + f * next));
        CHECK((drawn.covariance_at(k, f) - between).norm() < 1e-6 * between.trace());
      }
    }
  }
}

TEST_CASE("AR(1) is the double sum over the stations, with the power of their distance in time") {
  const Case c("MWD+IFR1", ar1(9000));
  const ToolCovariances sums = c.covariances();
  const Eigen::Matrix3Xd effects = draw_effects(c.errors, {39, 1}, FirstOrder::iscwsa);
  for (const ErrorSource& s : c.errors.sources) {
    if (s.code != "DECR" && s.code != "DBHR") continue;
    REQUIRE(s.draws.size() > 30);
    double time = 0;
    std::vector<double> times;
    for (int k = 0; k < 40; ++k) times.push_back(time += 1800 + 900 * (k % 3));
    Matrix3d expected = Matrix3d::Zero();
    for (const auto i : s.draws)
      for (const auto j : s.draws)
        expected += std::exp(-std::abs(times[c.errors.draws[i].first] - times[c.errors.draws[j].first]) / 9000) *
                    effects.col(i) * effects.col(j).transpose();
    const auto row = std::find(sums.sources.begin(), sums.sources.end(), s.code) - sums.sources.begin();
    const Matrix3d found = sums.by_source[39 * sums.sources.size() + static_cast<std::size_t>(row)];
    CHECK((found - expected).norm() < 1e-12 * expected.trace());
  }
}

TEST_CASE("A disturbance without memory leaves covariances and predictions to the bit") {
  const Case c("MWD+IFR1+AX", ar1(0));
  const Case plain = [] {
    Case p("MWD+IFR1+AX", ar1(0));
    p.runs = {{1, shipped("MWD+IFR1+AX")}};
    return p;
  }();
  const WellErrors today =
      well_errors(plain.survey, survey::true_vertical_depths(plain.survey), plain.runs, plain.field, 60 * kDegree);
  const WellErrors independent = with_independent_draws(c.errors, *c.disturbed);
  CHECK(draw_effects(independent, {39, 1}, FirstOrder::minimum_curvature) ==
        draw_effects(today, {39, 1}, FirstOrder::minimum_curvature));
}

TEST_CASE("Matched terms have the variance of those that they replace") {
  const Case c("MWD+IFR1+AX", waves(true));
  const ToolCovariances matched = c.covariances();
  const auto& terms = c.runs.front().model->terms;
  const auto sigma = [&](const std::string& code) {
    const auto t = std::find_if(terms.begin(), terms.end(), [&](const auto& x) { return x.code == code; });
    REQUIRE(t != terms.end());
    return t->sigma;
  };
  const double h = 50500 * std::cos(73 * kDegree);
  CHECK(sigma("DISTURBANCE-DECLINATION") == Approx(std::hypot(0.1 * kDegree, 3000 * kDegree / h)).epsilon(1e-12));
  CHECK(sigma("DISTURBANCE-DIP") == Approx(0.08 * kDegree).epsilon(1e-12));
  CHECK(sigma("DISTURBANCE-TOTAL") == Approx(60).epsilon(1e-12));
  CHECK_THROWS_AS(disturbed_runs({{1, shipped("GYRO-NS")}}, waves(true), c.field), InputError);
}

TEST_CASE("Drawn wells have the covariance of the disturbance") {
  // Without controls: their variance is the prediction itself.
  for (const auto& d : {ar1(7000), waves(true)}) {
    const Case c("MWD+IFR1+AX", d);
    std::vector<bool> keep;
    for (const ErrorSource& s : c.errors.sources)
      keep.push_back(std::any_of(c.disturbed->draws.begin(), c.disturbed->draws.end(),
                                 [&](std::uint32_t i) { return &c.errors.sources[c.errors.draws[i].source] == &s; }));
    std::vector<DrawPlace> places = draw_places(c.errors);
    for (std::uint32_t i = 0; i < c.disturbed->draws.size(); ++i) places[c.disturbed->draws[i]] = {kGivenDraws, i};
    const DrawnWell well = drawn_well(only_sources(c.errors, keep), {{39, 1}}, places, false);
    const int groups = 2500;
    survey::LaneArray made(groups, static_cast<int>((c.disturbed->draws.size() + 3) / 4 * 4)), out(groups, 3);
    const random::Stream stream(5, 21);
    c.disturbed->disturbance.fill(stream, 0, false, groups, made);
    well.draw(stream, 0, false, groups, out, &made);
    Matrix3d found = Matrix3d::Zero();
    const int trials = 8 * groups;
    for (int t = 0; t < trials; ++t) {
      const Eigen::Vector3d x(out.value(t, 0), out.value(t, 1), out.value(t, 2));
      found += x * x.transpose() / trials;
    }
    const Matrix3d predicted = covariance_of(draw_effects(
        with_independent_draws(only_sources(c.errors, keep), *c.disturbed), {39, 1}, FirstOrder::minimum_curvature));
    // sqrt(2 / n) of a normal variance is 1 %. What lasts some stations adds up; waves of a day cancel.
    const Matrix3d independent =
        covariance_of(draw_effects(only_sources(c.errors, keep), {39, 1}, FirstOrder::minimum_curvature));
    const double ratio = predicted(1, 1) / independent(1, 1);
    CHECK((d.process.kind == disturbance::Kind::ar1 ? ratio > 1.5 : ratio < 0.5));
    CHECK(found(1, 1) == Approx(predicted(1, 1)).epsilon(0.045));
    CHECK(found(0, 0) == Approx(predicted(0, 0)).epsilon(0.045));
  }
}

TEST_CASE("Azimuth errors of the tool are none of the reference's declination") {
  CHECK((reference_element("DECR", "AZ") == random::ReferenceElement::declination));
  CHECK((reference_element("DBHR", "DBH") == random::ReferenceElement::declination));
  for (const char* own : {"AZMR", "AZMS", "AZRF", "AMIC"}) CHECK_FALSE(reference_element(own, "AZ").has_value());
}
