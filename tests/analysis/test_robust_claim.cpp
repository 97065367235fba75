#include "analysis/robust_claim.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <limits>

#include "analysis/multistation_trials.h"
#include "analysis/well_design.h"
#include "base/units.h"
#include "multistation/robust.h"

using namespace surveymc;
using namespace surveymc::analysis;
using Catch::Matchers::WithinRel;

namespace {

survey::ReferenceField reference() {
  survey::ReferenceField f;
  f.total = 50500;
  f.dip = 73 * kDegree;
  f.gravity = 9.81;
  return f;
}

MeasuredStations building(int stations) {
  WellDesign d;
  d.kind = WellKind::building;
  d.stations = stations;
  d.build_rate = 4 * kDegree / 30;
  return measured_stations(make_well(d, 90 * kDegree, 45 * kDegree), reference(), true);
}

propagate::CodeDraws draws() {
  propagate::CodeDraws d;
  d.sensors = survey::equal_axes(.004, .0005, 70, .0016);
  d.interference = 220;
  d.run = {50, .1 * kDegree, .2 * kDegree, 0};
  d.station = {60, .08 * kDegree, .1 * kDegree, 0};
  return d;
}

multistation::FitOptions options(const std::string& set, bool priors) {
  multistation::FitOptions o;
  o.parameters =
      set == "3" ? multistation::ParameterSet::of({"mbx", "mby", "mbz"}) : multistation::ParameterSet::named(set);
  if (!priors) o.prior_sd.fill(std::numeric_limits<double>::infinity());
  o.total = reference().total;
  o.dip = reference().dip;
  return o;
}

/// Relative difference of two covariances, in units of the second's diagonal.
double distance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd sd = b.diagonal().cwiseSqrt().cwiseInverse();
  return (sd.asDiagonal() * (a - b) * sd.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("A claim with weights is the sum of what every input does to the fit") {
  const MeasuredStations stations = building(31);
  const propagate::CodeDraws d = draws();
  const multistation::PerParameter<double> sd = tool_sizes(d);
  std::vector<double> weights;
  for (std::size_t k = 0; k < stations.fields.size(); ++k) weights.push_back(k % 7 == 0 ? 0.1 : 0.3 + 0.02 * double(k));
  std::vector<multistation::StationReadings> readings;
  for (const survey::StationFields& f : stations.fields)
    readings.push_back({survey::from_eigen(9.81 * survey::to_eigen(f.down_T)), f.field_T,
                        multistation::reference_of(multistation::ResidualKind::survey, 9.81, 50500, 73 * kDegree)});
  for (const std::string set : {"3", "6", "12", "18"})
    for (const bool priors : {false, true}) {
      if (!priors && set == "18") continue;  // weak without
      const multistation::FitOptions o = options(set, priors);
      const double noise = 25;
      const multistation::FitSensitivity s = multistation::fit_sensitivity(readings, {}, o, weights);
      const int p = o.parameters.size();
      Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(p, p), run = Eigen::MatrixXd::Zero(p, 2);
      for (std::size_t k = 0; k < readings.size(); ++k) {
        const Eigen::MatrixXd field = s.by_reference[k].rightCols<2>();
        const Eigen::MatrixXd own = field * Eigen::Vector2d(60, .08 * kDegree).asDiagonal();
        // Least squares with weights w would have w^2: a claim has w, and its factor.
        expected +=
            (own * own.transpose() + noise * noise * s.by_magnetic[k] * s.by_magnetic[k].transpose()) / weights[k];
        run += field * Eigen::Vector2d(50, .1 * kDegree).asDiagonal();
      }
      expected += run * run.transpose();
      for (int i = 0; i < multistation::kParameters; ++i) {
        const Eigen::VectorXd effect = sd[static_cast<std::size_t>(i)] * s.by_truth.col(i);
        expected += effect * effect.transpose();
      }
      const RobustClaim claim(stations, d, noise, o);
      multistation::LossCost twice;
      twice.variance = 2;
      CHECK(distance(claim.covariance(weights.data(), {}), expected) < 1e-6);
      // The loss costs what the stations' own errors do, and nothing else.
      Eigen::MatrixXd more = claim.covariance(weights.data(), twice) - claim.covariance(weights.data(), {}),
                      stations_only = Eigen::MatrixXd::Zero(p, p);
      for (std::size_t k = 0; k < readings.size(); ++k) {
        const Eigen::MatrixXd own = s.by_reference[k].rightCols<2>() * Eigen::Vector2d(60, .08 * kDegree).asDiagonal();
        stations_only +=
            (own * own.transpose() + noise * noise * s.by_magnetic[k] * s.by_magnetic[k].transpose()) / weights[k];
      }
      CHECK(distance(more, stations_only) < 1e-6);
    }
}

TEST_CASE("A station without weight is not there, and one above one counts as one") {
  const MeasuredStations stations = building(21);
  const RobustClaim claim(stations, draws(), 0, options("3", false));
  std::vector<double> some(20, 1.0), large(20, 1.0);
  some[3] = some[11] = 0;
  large[3] = 20;
  const Eigen::MatrixXd all = claim.covariance(std::vector<double>(20, 1.0).data(), {});
  CHECK(claim.covariance(large.data(), {}) == all);
  CHECK(distance(claim.covariance(some.data(), {}), all) > 0.01);
  CHECK_FALSE(claim.covariance(std::vector<double>(20, 0.0).data(), {}).allFinite());
}

TEST_CASE("A claim with narrow priors holds: a station weighs the slope of its loss against them") {
  // 2048 trials of six parameters: a mean squared distance has a standard error of 1.3 %; 4.5 of them would hide what
  // is tested, so that the bound is 2.5 of them. Weights of one against the priors would be 10 to 20 % off.
  constexpr int kTrials = 2048;
  WellDesign design;
  design.kind = WellKind::building;
  design.stations = 121;
  design.spacing = 12;
  design.build_rate = 2 * kDegree / 30;
  const survey::Survey well = make_well(design, 90 * kDegree, 45 * kDegree);
  propagate::CodeDraws d;
  d.sensors = survey::equal_axes(0, 0, 35, .0008);
  multistation::FitOptions o = options("6", true);
  o.sizes = {.006, 300, 300};
  MultistationRun run = multistation_run(well, reference());
  run.magnetometer = 300;
  run.tool_sd = tool_sizes(d);
  for (int i = 0; i < o.parameters.size(); ++i) {
    const auto at = static_cast<std::size_t>(o.parameters.index(i));
    o.prior_sd[at] = run.tool_sd[at];
  }
  const multistation::FitPlan plan = multistation::fit_plan(o);
  MeasuredStations stations = measured_stations(well, reference(), true);
  stations.fields.clear();  // the run has its tie-on, too
  for (std::size_t k = 0; k < run.md.size(); ++k)
    stations.fields.push_back({survey::from_eigen(run.field_T[k]), survey::from_eigen(run.gravity_T[k].normalized())});
  using multistation::Loss;
  for (const Loss loss : {Loss::least_squares, Loss::l1, Loss::huber, Loss::cauchy, Loss::tukey}) {
    const random::Stream stream(7, 1);
    multistation::SixAxisBlock block(kTrials, well.size());
    survey::LaneArray tools(block.groups(), multistation::kParameters);
    multistation::FitBlock found(kTrials, o);
    multistation::RobustBlock robust(kTrials, well.size());
    simulate_multistation(run, stream, 0, block, tools);
    multistation::robust_fit_block(block, plan, o.parameters, multistation::robust_options(loss), stream, 0, found,
                                   robust);
    const multistation::LossCost cost = multistation::loss_cost(loss, plan);
    const RobustClaim claim(stations, d, run.magnetometer, o);
    double nees = 0;
    for (int t = 0; t < kTrials; ++t) {
      REQUIRE(found.converged.value(t, 0) == 1);
      std::vector<double> weights;
      for (int k = 0; k < well.size(); ++k) weights.push_back(robust.weights.value(t, k));
      Eigen::VectorXd e(6);
      for (int i = 0; i < 6; ++i) e[i] = found.estimate.value(t, i) - tools.value(t, o.parameters.index(i));
      const Eigen::MatrixXd c = claim.covariance(weights.data(), cost);
      const Eigen::VectorXd unit = c.diagonal().cwiseSqrt().cwiseInverse();
      nees +=
          (unit.asDiagonal() * e).dot((unit.asDiagonal() * c * unit.asDiagonal()).ldlt().solve(unit.asDiagonal() * e));
    }
    CAPTURE(loss, nees / kTrials);
    CHECK(std::abs(nees / kTrials / 6 - 1) < 0.033);
  }
}

TEST_CASE("The lateral cost of a loss is that of the stations' share of the variance") {
  const MeasuredStations stations = building(31);
  propagate::CodeDraws d = draws();
  const multistation::FitOptions o = options("3", false);
  using multistation::Loss;
  CHECK(lateral_variance_ratio(stations, d, 0, o, Loss::least_squares) == 1);
  const double v = multistation::loss_cost(Loss::huber, 2).variance;
  const double all = lateral_variance_ratio(stations, d, 0, o, Loss::huber);
  CHECK(all > 1);
  CHECK(all < v);
  d.sensors = {};
  d.interference = 0;
  d.run = {};
  d.station.declination = 0;
  CHECK_THAT(lateral_variance_ratio(stations, d, 0, o, Loss::huber), WithinRel(v, 1e-9));
  CHECK(std::isnan(lateral_variance_ratio(stations, d, 10, o, Loss::huber)));
}
