#include "analysis/multistation_prediction.h"

#include <cmath>
#include <utility>

#include <array>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using namespace surveymc::analysis;
using namespace surveymc::multistation;

namespace {

survey::Survey building_well() {
  survey::Survey s;
  for (int k = 0; k < 30; ++k)
    s.stations.push_back({30.0 * k, (5 + 2.5 * k) * kDegree, (40 + k) * kDegree, 122.0 * k * kDegree});
  return s;
}

}  // namespace

TEST_CASE("Monte Carlo of any parameters agrees with first order, errors outside the set included") {
  // 4096 trials: an sd has a standard error of 1.1 %; 4.5 of them, and 1 % for second order.
  const survey::Survey well = building_well();
  const survey::ReferenceField field{9.81, 50000, 72 * kDegree, 0.05, 0};
  for (const char* name : {"9", "12", "18"})
    for (const bool joint : {false, true}) {
      MultistationRun run = multistation_run(well, field);
      run.tool_sd = default_priors();  // all 21 errors are drawn, whatever the set
      for (double& sd : run.tool_sd) sd *= 0.5;
      run.accelerometer = 0.003;
      run.magnetometer = 40;
      run.reference = {0.001, 60, 0.08 * kDegree};
      FitOptions o;
      o.parameters = ParameterSet::named(name);
      o.total = field.total;
      o.dip = field.dip;
      o.sizes = {0.003, 42, 42};
      o.reference = run.reference;
      o.estimates_reference = joint;
      const MultistationPrediction p = predict_multistation(run, o);
      const FitPlan plan = fit_plan(o);

      constexpr int kTrials = 4096;
      SixAxisBlock block(kTrials, well.size());
      survey::LaneArray tools(block.groups(), kParameters), position(block.groups(), 3);
      FitBlock found(kTrials, o);
      simulate_multistation(run, random::Stream(7, 1), 0, block, tools);
      fit_block(block, plan, o.parameters, found);
      correct_block(block, plan, o.parameters, found);
      multistation_positions(block, run.md, field.declination, position);
      const Eigen::Vector3d truth = survey::minimum_curvature_positions(well).back();
      const int n = o.parameters.size();
      Eigen::VectorXd squares = Eigen::VectorXd::Zero(n + 3);
      for (int t = 0; t < kTrials; ++t) {
        REQUIRE(found.converged.value(t, 0) == 1);
        for (int i = 0; i < n; ++i) {
          const double e = found.estimate.value(t, i) - tools.value(t, o.parameters.index(i));
          squares[i] += e * e / kTrials;
        }
        for (int i = 0; i < 3; ++i) {
          const double e = position.value(t, i) - truth[i];
          squares[n + i] += e * e / kTrials;
        }
      }
      for (int i = 0; i < n; ++i) {
        CAPTURE(name, joint, o.parameters[i].name);
        CHECK(std::abs(std::sqrt(squares[i] / p.covariance(i, i)) - 1) < 0.06);
      }
      for (int i = 0; i < 3; ++i) {
        CAPTURE(name, joint, i);
        CHECK(std::abs(std::sqrt(squares[n + i] / p.position_covariance(i, i)) - 1) < 0.06);
      }
    }
}

TEST_CASE("A robust loss costs what first order says, priors and noise that turns the hole included") {
  // The same draws by least squares and by the loss: ratios of sds, whose standard errors are sqrt(1 - 1 / v) of those
  // of the sds, 0.35 % of l1: 4.5 of them, and 0.4 % as stations are few, 1 % of tukey, which keeps the scale of its
  // start. l1 costs 13 % with two components of a residual, 9 % with three. Without noise of the accelerometers |g| is
  // no component, whether it is fitted or not.
  survey::Survey well;
  for (int k = 0; k < 60; ++k)
    well.stations.push_back({30.0 * k, (5 + 1.4 * k) * kDegree, (40 + k) * kDegree, 122.0 * k * kDegree});
  const survey::ReferenceField field{9.81, 50000, 72 * kDegree, 0.05, 0};
  struct Case {
    const char* set;
    Loss loss;
    double priors;  // narrow ones pull: a robust fit weighs its stations less against them
    double accelerometer = 0.002;
  };
  for (const Case& c :
       {Case{"6", Loss::l1, 1}, Case{"6", Loss::l1, .25}, Case{"6", Loss::cauchy, 1}, Case{"12", Loss::l1, .25},
        Case{"12", Loss::cauchy, .25}, Case{"6", Loss::l1, 1, 0}, Case{"6", Loss::tukey, 1, 0},
        Case{"12", Loss::cauchy, .25, 0}, Case{"12", Loss::tukey, .25, 0}}) {
    MultistationRun run = multistation_run(well, field);
    FitOptions o;
    o.parameters = ParameterSet::named(c.set);
    for (double& sd : o.prior_sd) sd *= c.priors;
    for (int i = 0; i < o.parameters.size(); ++i) {
      const auto at = static_cast<std::size_t>(o.parameters.index(i));
      run.tool_sd[at] = o.prior_sd[at];
    }
    run.accelerometer = c.accelerometer;
    run.magnetometer = 120;
    run.reference = {0.001, 60, 0.08 * kDegree};
    o.total = field.total;
    o.dip = field.dip;
    o.sizes = {0.002, 120, 120};
    o.gravity_is_noisy = c.accelerometer > 0;
    o.reference = run.reference;
    o.estimates_reference = true;
    const FitPlan plan = fit_plan(o);
    const MultistationPrediction plain = predict_multistation(run, o),
                                 p = predict_multistation(run, o, loss_cost(c.loss, plan));
    const int n = o.parameters.size();
    CHECK(p.limits.shared < 0.3);
    CHECK(p.limits.uneven < 1.4);
    constexpr int kTrials = 8192;
    std::array<Eigen::VectorXd, 2> squares{Eigen::VectorXd::Zero(n + 3), Eigen::VectorXd::Zero(n + 3)};
    const Eigen::Vector3d truth = survey::minimum_curvature_positions(well).back();
    const Eigen::MatrixXd weight = p.covariance.inverse();
    double nees = 0;
    for (const std::size_t is_robust : {0u, 1u}) {
      SixAxisBlock block(kTrials, well.size());
      survey::LaneArray tools(block.groups(), kParameters), position(block.groups(), 3);
      FitBlock found(kTrials, o);
      RobustBlock robust(kTrials, well.size());
      const random::Stream stream(7, 1);
      simulate_multistation(run, stream, 0, block, tools);
      fit_block_by_loss(block, plan, o.parameters, robust_options(is_robust ? c.loss : Loss::least_squares), stream, 0,
                        found, robust);
      correct_block(block, plan, o.parameters, found);
      multistation_positions(block, run.md, field.declination, position);
      for (int t = 0; t < kTrials; ++t) {
        REQUIRE(found.converged.value(t, 0) == 1);
        Eigen::VectorXd e(n + 3);
        for (int i = 0; i < n; ++i) e[i] = found.estimate.value(t, i) - tools.value(t, o.parameters.index(i));
        for (int i = 0; i < 3; ++i) e[n + i] = position.value(t, i) - truth[i];
        squares[is_robust] += e.cwiseAbs2() / kTrials;
        if (is_robust) nees += e.head(n).dot(weight * e.head(n)) / kTrials;
      }
    }
    const Eigen::VectorXd ratio = (squares[1].array() / squares[0].array()).sqrt();
    Eigen::VectorXd predicted(n + 3);
    predicted << (p.covariance.diagonal().array() / plain.covariance.diagonal().array()).sqrt(),
        (p.position_covariance.diagonal().array() / plain.position_covariance.diagonal().array()).sqrt();
    const double v = loss_cost(c.loss, plan).variance, few = c.loss == Loss::tukey ? 0.01 : 0.004,
                 bound = few + 4.5 * std::sqrt((1 - 1 / v) / (2 * kTrials));
    for (int i = 0; i < n + 3; ++i) {
      CAPTURE(c.set, c.loss, c.priors, c.accelerometer, i, ratio[i], predicted[i]);
      CHECK(std::abs(ratio[i] / predicted[i] - 1) < bound);
    }
    CAPTURE(c.set, c.loss, c.priors, c.accelerometer, bound);
    CHECK(predicted.maxCoeff() > 1 + 1.2 * bound);  // a prediction without the loss does not pass
    CAPTURE(c.set, c.loss, c.priors, nees);
    CHECK(std::abs(nees / n - 1) < 4.5 * std::sqrt(2.0 / (n * kTrials)) + 0.02);
  }
}

TEST_CASE("Shared errors that the fit leaves are told, and those that it takes are not") {
  const survey::Survey well = building_well();
  const survey::ReferenceField field{9.81, 50000, 72 * kDegree, 0.05, 0};
  MultistationRun run = multistation_run(well, field);
  run.magnetometer = 30;
  run.reference = {0, 100, 0.1 * kDegree};
  FitOptions o;
  o.parameters = ParameterSet::of({"mbz"});
  o.total = field.total;
  o.dip = field.dip;
  o.reference = run.reference;
  const auto shared = [&] { return predict_multistation(run, o, loss_cost(Loss::cauchy, fit_plan(o))).limits.shared; };
  CHECK(predict_multistation(run, o).limits.shared == 0);  // of least squares first order has no such limit
  CHECK(shared() > kLargeSharedResidual);
  // Where nothing is estimated all of the reference's error is left: 100 nT, and 87 nT by the dip, over 30 nT a
  // component.
  const double prior = std::exchange(o.prior_sd[kMagnetometerBias + 2], 1e-6);
  CHECK(std::abs(shared() - std::hypot(100, 50000 * 0.1 * kDegree) / (30 * std::sqrt(2.0))) < 1e-6);
  o.prior_sd[kMagnetometerBias + 2] = prior;
  o.estimates_reference = true;
  CHECK(shared() < 0.3);
  run.reference_per_station = true;  // errors of their own
  CHECK(shared() < 0.3);
  run.reference = {};
  run.tool[kMagnetometerScale] = 0.01;  // constant, and not estimated
  CHECK(shared() > kLargeSharedResidual);
  run.tool_sd[kMagnetometerScale] = std::exchange(run.tool[kMagnetometerScale], 0);
  CHECK(shared() > kLargeSharedResidual);
  run.tool_sd = {};
  run.tool[kMagnetometerBias + 2] = 300;  // estimated, but for the pull of its prior
  CHECK(shared() < 0.2);
}

TEST_CASE("What is drawn at stations is uneven by what is assumed of it") {
  const survey::ReferenceField field{9.81, 50000, 72 * kDegree, 0.05, 0};
  MultistationRun run = multistation_run(building_well(), field);
  run.magnetometer = 30;
  run.accelerometer = 0.0005;  // turns down by 2.5 nT
  FitOptions o;
  o.parameters = ParameterSet::named("12");
  o.total = field.total;
  o.dip = field.dip;
  o.sizes = {0.0005, 30, 30};
  const auto uneven = [&] { return predict_multistation(run, o, loss_cost(Loss::cauchy, fit_plan(o))).limits.uneven; };
  CHECK(std::abs(uneven() - 1) < 0.02);
  o.sizes = {0.005, 300, 300};  // all alike
  CHECK(std::abs(uneven() - 1) < 0.02);
  o.sizes[1] = o.sizes[2] = 30;
  CHECK(std::abs(uneven() - 10) < 0.1);
  o.gravity_is_noisy = false;
  CHECK(std::abs(uneven() - 1) < 0.02);
  // A reference of every station that has one direction: total field along Bh and Bv.
  run.reference = {0, 60, 0};
  run.reference_per_station = true;
  CHECK(std::abs(uneven() - std::sqrt(1 + 4)) < 0.02);
}

TEST_CASE("A station alone moves the position as its readings say: prediction without estimate") {
  // Priors so narrow that nothing is estimated: the corrected position is the uncorrected one.
  const survey::Survey well = building_well();
  const survey::ReferenceField field{9.81, 50000, 72 * kDegree, 0, 0};
  MultistationRun run = multistation_run(well, field);
  run.tool_sd = default_priors();
  run.magnetometer = 40;
  run.accelerometer = 0.003;
  FitOptions o;
  o.parameters = ParameterSet::named("21");
  for (double& sd : o.prior_sd) sd *= 1e-6;
  o.total = field.total;
  o.dip = field.dip;
  const MultistationPrediction p = predict_multistation(run, o);
  CHECK(p.position_covariance.isApprox(p.uncorrected_covariance, 1e-6));
}
