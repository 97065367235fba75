#include "analysis/multistation_prediction.h"

#include <cmath>

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
