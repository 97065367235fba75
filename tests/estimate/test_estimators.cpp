/// Laws that every estimator of gains and biases obeys, and the numbers that MSA must give.
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <ostream>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "estimate/estimators.h"
#include "estimate/field_fit.h"
#include "estimate/sensitivity.h"
#include "msa_trials.h"
#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "stats/intervals.h"
#include "stats/moments.h"
#include "stats/tests.h"
#include "survey/corrected_position.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {

/// Everything that gives an answer: estimator, solver, derivative.
struct Way {
  std::string name, solver, derivative = EstimatorOptions{}.derivative;
};
std::ostream& operator<<(std::ostream& out, const Way& w) {
  return out << w.name << " by " << w.solver << ", " << w.derivative;
}

InputErrors thesis_errors(double scale) { return {70 * scale, 0, 107 * scale, 0.16 * kDegree * scale, false, 0, 0}; }

EstimatorOptions options(const Way& way, double scale = 1) {
  return {.name = way.name, .solver = way.solver, .assumed = thesis_errors(scale), .derivative = way.derivative};
}
std::unique_ptr<Estimator> estimator(const Way& way, const test::ThesisCase& c) {
  return make_estimator(options(way), c.field, test::station_fields(c));
}
NominalTruth nominal(const test::ThesisCase& c) {
  return {test::station_fields(c), c.errors.gain, c.errors.bias, c.field};
}

/// What the law suite runs: every line of the table of estimators that has all six parameters, in lanes, and the slow
/// second solvers where one trial is enough.
std::vector<Way> fast_ways() {
  std::vector<Way> ways;
  for (const EstimatorKind& k : estimators())
    if (k.estimates_all)
      for (const char* derivative : {"measured", "fitted"})
        if (!k.derivative.empty() || ways.empty() || ways.back().name != k.name)
          ways.push_back({std::string(k.name), "gauss_newton", derivative});
  return ways;
}
const std::vector<Way> kFast = fast_ways();
const std::vector<Way> kNlopt{{"msa", "nlopt_neldermead"},
                              {"msa", "nlopt_bobyqa"},
                              {"msa", "nlopt_lbfgs"},
                              {"msa_weighted", "nlopt_lbfgs", "measured"},
                              {"msa_weighted", "nlopt_lbfgs", "fitted"},
                              {"msa_joint", "nlopt_lbfgs", "measured"},
                              {"msa_joint", "nlopt_lbfgs", "fitted"},
                              {"msa_joint", "nlopt_bobyqa", "measured"},
                              {"wls_consider", "nlopt_neldermead", "measured"},
                              {"wls_consider", "nlopt_neldermead", "fitted"}};
std::vector<Way> all_ways() {
  std::vector<Way> all = kFast;
  all.insert(all.end(), kNlopt.begin(), kNlopt.end());
  return all;
}

survey::ReadingBlock simulate(const test::ThesisCase& c, const sensor::NoiseModel& noise, int trials) {
  return test::simulated(c, noise, trials, random::Stream(77, 1));
}

/// Solves a block. The errors of its estimates have mean 0, to 4 standard errors, and the covariance that the estimator
/// claims, which is returned. `tool`: the true parameters of a trial.
template <class Tool>
Matrix6d check_claim(const EstimatorOptions& o, const test::ThesisCase& c, const survey::ReadingBlock& block,
                     const Tool& tool, EstimateBlock& out) {
  make_estimator(o, c.field, test::station_fields(c))->solve(block, out);
  Eigen::MatrixXd x(block.trials, 6);
  for (int t = 0; t < block.trials; ++t) {
    REQUIRE(out.converged.value(t, 0) == 1);
    x.row(t) = test::parameters_of(out.parameters, t) - tool(t);
  }
  const stats::Moments m = stats::Moments::of(x);
  const Matrix6d claimed =
      error_covariance(sensitivity(o, nominal(c)), test::station_fields(c), o.assumed).topLeftCorner<6, 6>();
  CAPTURE(c.number, o.name, o.derivative);
  for (int i = 0; i < 6; ++i) CHECK(std::abs(m.mean[i]) < 4 * std::sqrt(claimed(i, i) / block.trials));
  CHECK(stats::wishart_test(m.covariance(), claimed, m.count).p_value > 1e-3);
  return claimed;
}

/// Both blocks have the same estimates of 8 trials, to 1e-8 of a gain and of the total field.
void check_same_estimates(const EstimateBlock& a, const EstimateBlock& b, const test::ThesisCase& c) {
  for (int t = 0; t < 8; ++t)
    test::check_parameters(test::parameters_of(b.parameters, t), test::parameters_of(a.parameters, t), 1e-8,
                           1e-8 * c.field.total);
}

}  // namespace

TEST_CASE("Law: noise-free readings give the truth to 1e-9, on all four trajectories") {
  for (int number = 1; number <= 4; ++number)
    for (const Way& way : all_ways()) {
      const test::ThesisCase c = test::thesis_case(number);
      EstimateBlock out(1);
      estimator(way, c)->solve(simulate(c, {}, 1), out);
      CAPTURE(number, way);
      CHECK(out.converged.value(0, 0) == 1);
      // uT, as the thesis: biases to 1e-9 uT = 1e-6 nT. NLopt stops at the root of rounding.
      const bool lanes = way.solver == "gauss_newton";
      test::check_parameters(test::parameters_of(out.parameters, 0), test::true_parameters(c), lanes ? 1e-9 : 2e-6,
                             lanes ? 1e-6 : 120e-3);
      if (!estimator_kind(way.name).estimates_reference) continue;
      CHECK(std::abs(out.reference.value(0, 0) - c.field.total * std::cos(c.field.dip)) < (lanes ? 1e-6 : 1e-1));
      CHECK(std::abs(out.reference.value(0, 1) - c.field.total * std::sin(c.field.dip)) < (lanes ? 1e-6 : 1e-1));
    }
}

TEST_CASE("Law: unbiased to 4 standard errors and with the claimed covariance, where noise is small", "[long]") {
  // Noise / 50: the second-order shift of thesis test 1 (0.2 sd at full noise) is 0.004 sd, below one standard error.
  constexpr double scale = 1.0 / 50;
  constexpr int trials = 4096;
  for (int number = 1; number <= 4; ++number)
    for (const Way& way : kFast) {
      const test::ThesisCase c = test::thesis_case(number);
      const survey::ReadingBlock block = simulate(c, test::msa_noise(scale), trials);
      EstimateBlock out(trials);
      check_claim(
          options(way, scale), c, block, [&](int) { return test::true_parameters(c); }, out);
    }
}

TEST_CASE("Law: with priors, over tools drawn from them, an estimator has the covariance that it claims", "[long]") {
  // All sizes a tenth of the thesis': second-order shifts are 0.1 sd at full size, more than four standard errors.
  constexpr double scale = 0.1;
  constexpr int trials = 4096;
  const sensor::ToolSpread spread{.0016 * scale, 70 * scale};
  for (const int number : {3, 4})
    for (const Way& way : kFast) {
      const std::string& name = way.name;
      if (!estimator_kind(name).weighs) continue;  // has no priors
      test::ThesisCase c = test::thesis_case(number);
      c.errors = {};  // the prior's centre
      const sensor::CleanReadings clean = test::clean_readings(c);
      survey::ReadingBlock block = simulate(c, test::msa_noise(scale), trials);
      survey::LaneArray deviation(survey::groups_for(trials), 6);
      sensor::spread_tools(clean, spread, false, random::Stream(77, 1), 0, block, deviation);
      EstimatorOptions o = options(way, scale);
      o.assumed.gain = spread.gain;
      o.assumed.bias = spread.bias;
      EstimateBlock out(trials);
      const Matrix6d claimed = check_claim(
          o, c, block, [&](int t) { return Vector6d(test::true_parameters(c) + test::parameters_of(deviation, t)); },
          out);
      if (name != "wls") continue;
      for (int i = 0; i < 6; ++i)  // the diagonal of U (thesis eq 10), by another way
        CHECK(out.claimed_variance.value(7, i) == Approx(claimed(i, i)).epsilon(1e-9));
    }
}

TEST_CASE("Law: equivariant: readings a m + d have gains a g and biases a q + d") {
  const test::ThesisCase c = test::thesis_case(4);
  const Eigen::Vector3d a(1.07, 0.92, 1.01), d(300, -150, 80);
  for (const Way& way : kFast) {
    CAPTURE(way);
    survey::ReadingBlock block = simulate(c, test::msa_noise(1), 16);
    EstimateBlock before(16), after(16);
    const auto e = estimator(way, c);
    e->solve(block, before);
    for (int group = 0; group < 2; ++group)
      for (int r = 0; r < 3 * c.survey.size(); ++r)
        for (int i = 0; i < simd::kGroup; ++i) {
          double& m = block.magnetic.row(group, r)[i];
          m = a[r % 3] * m + d[r % 3];
        }
    e->solve(block, after);
    for (int t = 0; t < 16; ++t)
      for (int i = 0; i < 3; ++i) {
        CHECK(after.parameters.value(t, i) == Approx(a[i] * before.parameters.value(t, i)).epsilon(1e-10));
        CHECK(std::abs(after.parameters.value(t, 3 + i) - (a[i] * before.parameters.value(t, 3 + i) + d[i])) < 1e-6);
      }
  }
}

TEST_CASE("Law: the order of the stations does not matter") {
  const test::ThesisCase c = test::thesis_case(4);
  const survey::ReadingBlock block = simulate(c, test::msa_noise(1), 8);
  survey::ReadingBlock reversed = simulate(c, test::msa_noise(1), 8);
  for (int k = 0; k < c.survey.size(); ++k)
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < simd::kGroup; ++i) {
        const int mirror = 3 * (c.survey.size() - 1 - k) + axis;
        reversed.magnetic.row(0, 3 * k + axis)[i] = block.magnetic.row(0, mirror)[i];
        reversed.down.row(0, 3 * k + axis)[i] = block.down.row(0, mirror)[i];
      }
  std::vector<survey::StationFields> fields = test::station_fields(c), mirrored(fields.rbegin(), fields.rend());
  for (const Way& way : kFast) {
    EstimateBlock a(8), b(8);
    make_estimator(options(way), c.field, fields)->solve(block, a);
    make_estimator(options(way), c.field, mirrored)->solve(reversed, b);
    CAPTURE(way);
    for (int t = 0; t < 8; ++t)
      for (int i = 0; i < 6; ++i)
        CHECK(b.parameters.value(t, i) == Approx(a.parameters.value(t, i)).epsilon(1e-9).margin(1e-7));
  }
}

TEST_CASE("NLopt and Gauss-Newton find the same minimum, or the same root, on every test, at full noise", "[long]") {
  for (int number = 1; number <= 4; ++number) {
    const test::ThesisCase c = test::thesis_case(number);
    constexpr int trials = 8;
    const survey::ReadingBlock block = simulate(c, test::msa_noise(1), trials);
    for (const Way& way : kNlopt) {
      EstimateBlock reference(trials), out(trials);
      estimator({way.name, "gauss_newton", way.derivative}, c)->solve(block, reference);
      estimator(way, c)->solve(block, out);
      for (int t = 0; t < trials; ++t) {
        CAPTURE(number, way, t);
        REQUIRE(out.converged.value(t, 0) == 1);
        if (way.derivative != "fitted")  // a root is no minimum of the cost
          CHECK(out.cost.value(t, 0) >= reference.cost.value(t, 0) * (1 - 1e-9));
        // 1e-6 of the bias' scale, the total field
        test::check_parameters(test::parameters_of(out.parameters, t), test::parameters_of(reference.parameters, t),
                               1e-6, 1e-6 * c.field.total);
      }
    }
  }
}

TEST_CASE("Perfect accelerometers make wls_consider and msa one estimate: the weights of (Bh, Bv) are equal") {
  const test::ThesisCase c = test::thesis_case(2);
  const survey::ReadingBlock block = simulate(c, test::msa_noise(1), 8);
  EstimateBlock a(8), b(8);
  estimator({"msa", "gauss_newton"}, c)->solve(block, a);
  estimator({"wls_consider", "gauss_newton", "measured"}, c)->solve(block, b);
  check_same_estimates(a, b, c);
}

TEST_CASE("A joint estimate without uncertainty of the reference is MSA") {
  const test::ThesisCase c = test::thesis_case(4);
  const survey::ReadingBlock block = simulate(c, test::msa_noise(1), 8);
  EstimatorOptions o = options({"msa_joint", "gauss_newton", "measured"});
  o.assumed.total = o.assumed.dip = 0;
  EstimateBlock a(8), b(8);
  estimator({"msa", "gauss_newton"}, c)->solve(block, a);
  make_estimator(o, c.field)->solve(block, b);
  check_same_estimates(a, b, c);
}

TEST_CASE("The deterministic case of the thesis spec") {
  // n[k][i] = 0.07 sqrt2 sin(1 + 1.7 (3k + i)) uT; reference B 51.107 uT, dip 72.16 deg. Expected values were computed
  // by an independent program (numpy, normal equations by lstsq).
  struct Expected {
    int number;
    double parameters[6], cost, position[3];  // biases in uT, cost in uT^2
  };
  const Expected cases[] = {{3,
                             {.99523568, .99489063, .98756693, .26251784, .27961040, .17395709},
                             .6395949803,
                             {657.13861024, 650.64705541, 2654.08911123}},
                            {4,
                             {.99324865, .99424690, 1.00574480, -.05639206, -.07363143, -.28892822},
                             .9709734399,
                             {1211.73937716, 647.76005802, 1494.59332988}}};
  for (const Expected& x : cases) {
    const test::ThesisCase c = test::thesis_case(x.number);
    survey::ReadingBlock block = simulate(c, {}, 1);
    for (int k = 0; k < c.survey.size(); ++k)
      for (int i = 0; i < 3; ++i)
        block.magnetic.row(0, 3 * k + i)[0] += 70 * std::sqrt(2) * std::sin(1 + 1.7 * (3 * k + i));
    block.reference.fill(0, 0, 51107 * std::cos(72.16 * kDegree));
    block.reference.fill(0, 1, 51107 * std::sin(72.16 * kDegree));
    for (const std::string solver : {"gauss_newton", "nlopt_lbfgs"}) {
      EstimateBlock out(1);
      estimator({"msa", solver}, c)->solve(block, out);
      CAPTURE(x.number, solver);
      for (int i = 0; i < 3; ++i) {
        CHECK(std::abs(out.parameters.value(0, i) - x.parameters[i]) < 1e-6);
        CHECK(std::abs(out.parameters.value(0, 3 + i) * 1e-3 - x.parameters[3 + i]) < 1e-6);
      }
      CHECK(std::abs(out.cost.value(0, 0) * 1e-6 - x.cost) < 1e-9);
      survey::LaneArray position(1, 3);
      survey::corrected_final_positions(block, out.parameters, c.survey.md(), 0, position);
      for (int i = 0; i < 3; ++i) CHECK(std::abs(position.value(0, i) - x.position[i]) < 1e-3);
    }
  }
}

TEST_CASE("Analytic 3-sigma of the parameters: thesis spec, 70 nT / 107 nT / .16 deg") {
  const std::array<std::array<double, 6>, 2> expected{
      {{.01236892, .01326083, .03989682, .05845965, .07210034, 1.93413850},
       {.01714080, .01444701, .03203104, .06199273, .03820882, 1.59870607}}};
  for (const int number : {3, 4}) {
    const test::ThesisCase c = test::thesis_case(number);
    const std::vector<survey::StationFields> fields = test::station_fields(c);
    const Matrix8d cov = error_covariance(sensitivity({}, nominal(c)), fields, thesis_errors(1));
    const auto& e = expected[static_cast<std::size_t>(number - 3)];
    for (int i = 0; i < 6; ++i)  // printed to 8 decimals; biases in uT
      CHECK(std::abs(3 * std::sqrt(cov(i, i)) * (i < 3 ? 1 : 1e-3) - e[static_cast<std::size_t>(i)]) <
            std::max(1e-6 * e[static_cast<std::size_t>(i)], 6e-9));
    const double correlation = cov(2, 5) / std::sqrt(cov(2, 2) * cov(5, 5));
    CHECK(correlation == Approx(number == 3 ? -.987 : -.979).margin(5e-4));
  }
}

TEST_CASE("Sensitivity of the estimate agrees with differences through the solver") {
  const test::ThesisCase c = test::thesis_case(4);
  const std::vector<survey::StationFields> fields = test::station_fields(c);
  const Way way = GENERATE(from_range(kFast));
  CAPTURE(way);
  const Sensitivity s = sensitivity(options(way), nominal(c));
  const auto solve = [&](auto change) {
    survey::ReadingBlock block =
        sensor::make_reading_block(1, c.survey.size(),
                                   {.accelerometer = 1e-30,  // a down direction of its own for every trial
                                    .reference = sensor::ReferenceNoise::per_station});
    sensor::simulate_readings(test::clean_readings(c), c.field, {}, random::Stream(1, 1), 0, block);
    for (int k = 0; k < c.survey.size(); ++k) {
      block.reference.fill(0, 2 * k, c.field.total * std::cos(c.field.dip));
      block.reference.fill(0, 2 * k + 1, c.field.total * std::sin(c.field.dip));
    }
    change(block);
    EstimateBlock out(1);
    estimator(way, c)->solve(block, out);
    return test::parameters_of(out.parameters, 0);
  };
  const auto close = [](const Vector6d& a, const auto& b) {  // central differences, 5 digits
    const double margin = 1e-6 * b.cwiseAbs().maxCoeff() + 1e-9;
    for (int i = 0; i < 6; ++i) CHECK(a[i] == Approx(b[i]).epsilon(1e-5).margin(margin));
  };
  for (const int k : {0, 17, 52}) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto moved = [&](double h) {
        return solve([&](survey::ReadingBlock& b) { b.magnetic.row(0, 3 * k + axis)[0] += h; });
      };
      close((moved(1) - moved(-1)) / 2, s.by_magnetometer[static_cast<std::size_t>(k)].col(axis));
    }
    const auto reference = [&](double dtotal, double ddip) {
      return solve([&](survey::ReadingBlock& b) {
        b.reference.row(0, 2 * k)[0] = (c.field.total + dtotal) * std::cos(c.field.dip + ddip);
        b.reference.row(0, 2 * k + 1)[0] = (c.field.total + dtotal) * std::sin(c.field.dip + ddip);
      });
    };
    close((reference(1, 0) - reference(-1, 0)) / 2, s.by_reference[static_cast<std::size_t>(k)].col(0));
    close((reference(0, 1e-5) - reference(0, -1e-5)) / 2e-5, s.by_reference[static_cast<std::size_t>(k)].col(1));
    // A tilt of the down direction, perpendicular to it
    const survey::Vec3<double> u = fields[static_cast<std::size_t>(k)].down_T;
    for (const survey::Vec3<double> seed : {survey::Vec3<double>{1, 0, 0}, survey::Vec3<double>{0, 1, 0}}) {
      const survey::Vec3<double> v = cross(u, seed), dir = scale(1 / norm(v), v);
      const auto tilted = [&](double h) {
        return solve([&](survey::ReadingBlock& b) {
          b.down.row(0, 3 * k)[0] += h * dir.x;
          b.down.row(0, 3 * k + 1)[0] += h * dir.y;
          b.down.row(0, 3 * k + 2)[0] += h * dir.z;
        });
      };
      close((tilted(1e-5) - tilted(-1e-5)) / 2e-5, s.by_down[static_cast<std::size_t>(k)] * survey::to_eigen(dir));
    }
  }
}

TEST_CASE("Stations that cannot determine the parameters are an error before the run") {
  std::vector<survey::StationFields> same(20, test::station_fields(test::thesis_case(4)).front());
  CHECK_THROWS_AS(sensitivity({}, {same, {1, 1, 1}, {0, 0, 0}, {9.8, 51000, 72 * kDegree, 0, 0}}), InputError);
}

TEST_CASE("A trial that cannot converge is flagged, and so is nonsense") {
  const test::ThesisCase c = test::thesis_case(4);
  survey::ReadingBlock block = simulate(c, test::msa_noise(1), 8);
  test::check_nonsense_is_flagged(block, [&](const EstimatorOptions& o) {
    EstimateBlock out(8);
    make_estimator(o, c.field)->solve(block, out);
    return out;
  });
}

TEST_CASE(
    "With priors the derivative at the fitted field takes the shift of the gains away that the measured one has") {
  // Five times the usual errors, 30 stations of a building well, tools drawn from the priors: spec of the shift,
  // 0.21 sd of each gain with the measured field.
  constexpr int trials = 8192;
  constexpr double sd = 350;
  survey::Survey survey;
  for (int k = 0; k < 30; ++k) {
    const double inclination = (3 + 72.0 * k / 29) * kDegree, toolface = std::fmod(137.5 * k, 360) * kDegree;
    survey.stations.push_back({30.0 * k, inclination, 55 * kDegree, toolface});
  }
  const survey::ReferenceField field{9.80665, 51000, 72 * kDegree, 0, 0};
  const sensor::NoiseModel noise{.magnetometer = sd,
                                 .reference = sensor::ReferenceNoise::per_run,
                                 .reference_total = 650,
                                 .reference_dip = 1 * kDegree};
  const sensor::ToolSpread spread{.008, 350};
  const sensor::CleanReadings clean = sensor::clean_readings(survey, field, {});
  survey::ReadingBlock block = sensor::make_reading_block(trials, survey.size(), noise);
  sensor::simulate_readings(clean, field, noise, random::Stream(5, 1), 0, block);
  survey::LaneArray deviation(survey::groups_for(trials), 6);
  sensor::spread_tools(clean, spread, false, random::Stream(5, 1), 0, block, deviation);
  EstimatorOptions o = test::options_of(
      "msa_joint", {sd, 0, noise.reference_total, noise.reference_dip, false, spread.gain, spread.bias});
  const Matrix8d claimed =
      error_covariance(sensitivity(o, {sensor::station_fields(clean), {1, 1, 1}, {0, 0, 0}, field}),
                       sensor::station_fields(clean), o.assumed);
  const auto shift = [&](const char* derivative) {
    o.derivative = derivative;
    EstimateBlock out(trials);
    make_estimator(o, field)->solve(block, out);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int t = 0; t < trials; ++t) {
      REQUIRE(out.converged.value(t, 0) == 1);
      for (int i = 0; i < 3; ++i) sum[i] += out.parameters.value(t, i) - 1 - deviation.value(t, i);
    }
    return Eigen::Vector3d((sum / trials).cwiseQuotient(claimed.diagonal().head<3>().cwiseSqrt()));
  };
  const Eigen::Vector3d measured = shift("measured"), fitted = shift("fitted");
  const double four_standard_errors = 4 / std::sqrt(trials);
  for (int i = 0; i < 3; ++i) {
    // What is left is the curvature of Bh: its mean is sd^2 / (2 Bh) too large, and a gain takes that up as if it were
    // of the whole field, in units of the gain's sd.
    const double bh = field.total * std::cos(field.dip);
    const double curvature = sd * sd / (2 * bh) / bh / std::sqrt(claimed(i, i));
    CAPTURE(i, measured[i], fitted[i], curvature);
    CHECK(std::abs(fitted[i]) < four_standard_errors + curvature);
    CHECK(measured[i] > .21 - four_standard_errors);
  }
}

TEST_CASE("The table of estimators: what is not in it has neither factory nor prediction nor model") {
  const test::ThesisCase c = test::thesis_case(4);
  EstimatorOptions o = test::options_of("mas", thesis_errors(1));
  for (const std::string& rule : {std::string("estimator.name = \"mas\": must be one of msa, msa_weighted")}) {
    CHECK_THROWS_WITH(make_estimator(o, c.field), Catch::Contains(rule));
    CHECK_THROWS_WITH(sensitivity(o, nominal(c)), Catch::Contains(rule));
    CHECK_THROWS_WITH(find_sensitivity(o, nominal(c)), Catch::Contains(rule));
  }
  CHECK_THROWS_WITH(field_fit_model(o, c.field), Catch::Contains("\"mas\": no fit"));
  o.name = "wls";
  CHECK_THROWS_WITH(field_fit_model(o, c.field), Catch::Contains("\"wls\": no fit"));
  for (const EstimatorKind& k : estimators()) {
    o.name = k.name;
    CAPTURE(o.name);
    CHECK(&estimator_kind(k.name) == &k);
    const auto made = make_estimator(o, c.field, test::station_fields(c));
    CHECK(made->name() == k.name);
    CHECK(made->estimates_reference() == k.estimates_reference);
    if (k.predict)
      CHECK(sensitivity(o, nominal(c)).by_magnetometer.size() == static_cast<std::size_t>(c.survey.size()));
    if (k.needs_attitude) CHECK_THROWS_AS(make_estimator(o, c.field), InputError);
    EstimatorOptions part = o;
    part.estimated[2] = false;
    if (k.takes_subset)
      CHECK_NOTHROW(make_estimator(part, c.field, test::station_fields(c)));
    else
      CHECK_THROWS_AS(make_estimator(part, c.field, test::station_fields(c)), InputError);
  }
}

TEST_CASE("Every estimator of the table stands in the documents") {
  for (const char* page : {"docs/keys.md", "docs/studies/msa_position.md"}) {
    std::ifstream file(std::string(SURVEYMC_SOURCE_DIR) + "/" + page);
    REQUIRE(file.good());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    for (const EstimatorKind& k : estimators()) {
      CAPTURE(page, k.name);
      // As a value in the table of keys, or as code in a study.
      const std::string name(k.name);
      CHECK((text.find("\"" + name + "\"") != std::string::npos || text.find("`" + name + "`") != std::string::npos));
    }
  }
}

TEST_CASE("Unknown estimators, solvers and bad options are errors") {
  const survey::ReferenceField field{9.8, 50000, 1, 0, 0};
  const auto make = [&](const std::string& name, const std::string& solver, int iterations, double tolerance) {
    return make_estimator({name, solver, iterations, tolerance, thesis_errors(1)}, field, {});
  };
  CHECK_THROWS_AS(make("mas", "gauss_newton", 50, 1e-9), InputError);
  CHECK_THROWS_AS(make("msa", "newton", 50, 1e-9), InputError);
  CHECK_THROWS_AS(make("msa", "gauss_newton", 0, 1e-9), InputError);
  CHECK_THROWS_AS(make("msa", "gauss_newton", 50, 0), InputError);
  CHECK_NOTHROW(make("msa", "nlopt_bobyqa", 50, 1e-9));
  CHECK_THROWS_WITH(make("wls", "gauss_newton", 50, 1e-9), Catch::Contains("true field at every station"));
  CHECK_THROWS_WITH(make("wls", "nlopt_lbfgs", 50, 1e-9), Catch::Contains("closed form"));
  CHECK_THROWS_WITH(make_estimator({"msa_joint"}, field), Catch::Contains("estimator.magnetometer_nT = 0"));
}
