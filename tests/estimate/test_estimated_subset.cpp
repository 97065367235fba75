/// Estimating some of the six parameters only: the others stay where they are and their errors go into the estimates.
#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "estimate/estimator.h"
#include "estimate/sensitivity.h"
#include "msa_trials.h"

using namespace surveymc;
using namespace surveymc::estimate;
using Catch::Matchers::Contains;

namespace {

using Subset = std::array<bool, 6>;
const std::vector<Subset> kSubsets{{false, false, false, true, true, true},
                                   {true, true, false, true, true, true},
                                   {false, false, false, false, false, true},
                                   {true, false, true, false, true, false}};

EstimatorOptions options(const std::string& name, const Subset& estimated, const std::string& solver = "gauss_newton") {
  return {.name = name,
          .solver = solver,
          .assumed = {70, 1e-4, 107, .16 * kDegree, false, .0016, 70, 220},
          .estimated = estimated};
}

test::ThesisCase perfect_tool() {
  test::ThesisCase c = test::thesis_case(3);
  c.errors = {};
  return c;
}

/// Estimate from noise-free readings of a tool with these errors.
Vector6d estimated(const EstimatorOptions& o, const test::ThesisCase& c, const sensor::NoiseModel& noise) {
  const survey::ReadingBlock block = test::simulated(c, noise, 1, random::Stream(8, 1));
  EstimateBlock out(1);
  make_estimator(o, c.field)->solve(block, out);
  REQUIRE(out.converged.value(0, 0) == 1);
  return test::parameters_of(out.parameters, 0);
}

}  // namespace

TEST_CASE("Parameters that are not estimated stay at 1 and 0, the others find the truth") {
  for (const std::string name : {"msa", "msa_weighted", "msa_joint", "wls_consider"})
    for (const Subset& subset : kSubsets) {
      test::ThesisCase c = perfect_tool();
      for (std::size_t i = 0; i < 3; ++i) {
        if (subset[i]) c.errors.gain[i] = 1.003;
        if (subset[3 + i]) c.errors.bias[i] = 150;
      }
      EstimatorOptions o = options(name, subset);
      o.assumed.gain = o.assumed.bias = o.assumed.axial_bias = 0;  // no priors, that would pull
      const auto x = estimated(o, c, {});
      CAPTURE(name);
      for (int i = 0; i < 3; ++i) {
        const auto a = static_cast<std::size_t>(i);
        if (!subset[a]) CHECK(x[i] == 1);
        if (!subset[3 + a]) CHECK(x[3 + i] == 0);
      }
      test::check_parameters(x, test::true_parameters(c), 1e-9, 1e-6);
    }
}

TEST_CASE("NLopt and Gauss-Newton find the same minimum of a subset") {
  const sensor::NoiseModel noise = test::msa_noise(1, sensor::ReferenceNoise::per_run, .001);
  const test::ThesisCase c = perfect_tool();
  for (const std::string name : {"msa", "msa_joint", "wls_consider"})
    for (const Subset& subset : kSubsets)
      for (const std::string solver : {"nlopt_lbfgs", "nlopt_neldermead"}) {
        if (name == "msa_joint" && solver == "nlopt_neldermead") continue;  // eight unknowns: slow
        const auto a = estimated(options(name, subset), c, noise),
                   b = estimated(options(name, subset, solver), c, noise);
        CAPTURE(name, solver);
        test::check_parameters(a, b, 2e-6, 120e-3);  // as for all six: NLopt stops at the root of rounding
      }
}

TEST_CASE("Sensitivity to the true parameters agrees with differences through the solver") {
  for (const std::string name : {"msa", "msa_weighted", "msa_joint", "wls_consider"})
    for (const Subset& subset : kSubsets) {
      const test::ThesisCase c = perfect_tool();
      const EstimatorOptions o = options(name, subset);
      const Sensitivity s = sensitivity(o, {test::station_fields(c), c.errors.gain, c.errors.bias, c.field});
      for (std::size_t i = 0; i < 6; ++i) {
        const double h = i < 3 ? 1e-5 : 1;  // second order is 1e-5 of first
        std::array<Vector6d, 2> error;
        for (std::size_t side = 0; side < 2; ++side) {
          test::ThesisCase moved = c;
          const double step = side == 0 ? h : -h;
          if (i < 3)
            moved.errors.gain[i] += step;
          else
            moved.errors.bias[i - 3] += step;
          error[side] = estimated(o, moved, {});
          error[side][static_cast<int>(i)] -= step;
        }
        const Vector6d slope = (error[0] - error[1]) / (2 * h);
        CAPTURE(name, i, subset[0], subset[3]);
        for (int r = 0; r < 6; ++r) {
          // Rounding of the estimate (1e-12 of a gain, 1e-12 of the field) over the step, and second order.
          const double rounding = (r < 3 ? 1e-11 : 1e-6) / h;
          const double expected = s.by_truth(r, static_cast<int>(i));
          CHECK(std::abs(slope[r] - expected) < 1e-6 * std::abs(expected) + rounding);
        }
      }
    }
}

TEST_CASE("A held parameter's nominal error is in the predicted shift") {
  test::ThesisCase c = perfect_tool();
  c.errors.gain = {1, 1, 1.0001};
  const EstimatorOptions o = options("msa", {true, true, false, true, true, true});
  const Sensitivity s = sensitivity(o, {test::station_fields(c), c.errors.gain, c.errors.bias, c.field});
  const auto x = estimated(o, c, {});
  for (int i = 0; i < 6; ++i) {
    const double error = x[i] - (i < 3 ? c.errors.gain[static_cast<std::size_t>(i)] : 0);
    CHECK(std::abs(error - s.shift[i]) < 2e-3 * std::abs(s.shift[i]) + 1e-9);  // second order: 1e-4 of the field
  }
}

TEST_CASE("What the stations cannot determine is named, or absent") {
  test::ThesisCase c = perfect_tool();
  for (survey::Station& s : c.survey.stations)
    s = {s.md, 1, 1, s.toolface};  // straight: gain z cannot be told from bias z
  const NominalTruth truth{test::station_fields(c), {1, 1, 1}, {0, 0, 0}, c.field};
  const Subset all{true, true, true, true, true, true}, axial{false, false, true, false, false, true};
  CHECK_FALSE(find_sensitivity(options("msa", all), truth));
  CHECK_THROWS_WITH(sensitivity(options("msa", all), truth), Contains("three gains and three biases"));
  CHECK_THROWS_WITH(sensitivity(options("msa", axial), truth), Contains("the gains and biases to be estimated"));
  CHECK(find_sensitivity(options("msa", {true, true, false, true, true, true}), truth));
  CHECK(find_sensitivity(options("msa_joint", all), truth));  // priors determine it
  CHECK_THROWS_AS(make_estimator(options("wls", axial), c.field, test::station_fields(c)), InputError);
  CHECK_THROWS_AS(find_sensitivity(options("wls", axial), truth), InputError);
}
