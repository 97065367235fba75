#include "analysis/msa_prediction.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/estimator.h"
#include "msa_trials.h"
#include "propagate/corrected_well_covariance.h"
#include "random_runs.h"
#include "stats/moments.h"
#include "stats/tests.h"
#include "survey/corrected_position.h"

using namespace surveymc;
using namespace surveymc::analysis;

namespace {

sensor::NoiseModel full_noise(double scale, sensor::ReferenceNoise per,
                              sensor::NoiseLaw law = sensor::NoiseLaw::gaussian) {
  sensor::NoiseModel n = test::msa_noise(scale, per, 0.003 * scale);
  n.law = law;
  return n;
}

/// Estimates and positions of trials, less their prediction, and the weighted sums of their draws: 9 columns each.
struct Trials {
  Eigen::MatrixXd errors, sums;
};
Trials run(const test::ThesisCase& c, const sensor::NoiseModel& noise, const MsaPrediction& p, int count) {
  const sensor::CleanReadings clean = test::clean_readings(c);
  survey::ReadingBlock block = sensor::make_reading_block(count, c.survey.size(), noise);
  survey::LaneArray sums(survey::groups_for(count), sensor::NoiseWeights::kSums),
      position(survey::groups_for(count), 3);
  sensor::simulate_readings(clean, c.field, noise, random::Stream(31, 7), 0, block, &p.weights, &sums);
  estimate::EstimateBlock estimates(count);
  estimate::make_estimator({}, c.field)->solve(block, estimates);
  survey::corrected_final_positions(block, estimates.parameters, c.survey.md(), c.field.declination, position);
  Trials t{Eigen::MatrixXd(count, 9), Eigen::MatrixXd(count, 9)};
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < 9; ++i) {
      t.errors(k, i) =
          i < 6 ? estimates.parameters.value(k, i) - p.parameters[i] : position.value(k, i - 6) - p.position[i - 6];
      t.sums(k, i) = sums.value(k, i) - p.linear.mean[i];
    }
  return t;
}

MsaPrediction predicted(const test::ThesisCase& c, const sensor::NoiseModel& noise) {
  return predict_msa(c.survey, c.field, c.errors, {}, noise, test::clean_readings(c), {});
}

}  // namespace

TEST_CASE("The linear prediction of a trial is its estimate and its position, when the noise is small") {
  for (const int number : {1, 3, 4})
    for (const sensor::ReferenceNoise per :
         {sensor::ReferenceNoise::none, sensor::ReferenceNoise::per_run, sensor::ReferenceNoise::per_station})
      for (const sensor::NoiseLaw law : {sensor::NoiseLaw::gaussian, sensor::NoiseLaw::uniform_half_open}) {
        const test::ThesisCase c = test::thesis_case(number);
        const sensor::NoiseModel noise = full_noise(1e-4, per, law);
        const MsaPrediction p = predicted(c, noise);
        const Trials t = run(c, noise, p, 16);
        for (int i = 0; i < 9; ++i) {
          const double sd = std::sqrt(p.linear.covariance(i, i));
          if (sd < 1e-9) continue;  // the vertical of a plane well: nothing but rounding
          CAPTURE(number, static_cast<int>(per), static_cast<int>(law), i);
          // Second order is 1e-4 of test 1's at full noise (a few tenths of a sd).
          for (int k = 0; k < 16; ++k) CHECK(std::abs(t.errors(k, i) - t.sums(k, i)) < 2e-3 * sd);
        }
      }
}

TEST_CASE("The weighted sums have the mean and covariance that is claimed for them", "[long]") {
  const test::ThesisCase c = test::thesis_case(4);
  for (const sensor::NoiseLaw law : {sensor::NoiseLaw::gaussian, sensor::NoiseLaw::uniform_half_open}) {
    const sensor::NoiseModel noise = full_noise(1, sensor::ReferenceNoise::per_run, law);
    const MsaPrediction p = predicted(c, noise);
    constexpr int n = 8192;
    const stats::Moments m = stats::Moments::of(run(c, noise, p, n).sums);
    for (int i = 0; i < 9; ++i) CHECK(std::abs(m.mean[i]) < 4.5 * std::sqrt(p.linear.covariance(i, i) / n));
    CHECK(stats::wishart_test(m.covariance(), p.linear.covariance, m.count).p_value > 1e-3);
  }
}

TEST_CASE("The linear covariance is that of the estimate") {
  for (const int number : {3, 4}) {
    const test::ThesisCase c = test::thesis_case(number);
    const MsaPrediction p = predicted(c, full_noise(1, sensor::ReferenceNoise::per_run));
    const Eigen::MatrixXd parameters = p.linear.covariance.topLeftCorner<6, 6>(), claimed = p.parameter_covariance;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        CHECK(std::abs(parameters(i, j) - claimed(i, j)) < 1e-10 * std::sqrt(claimed(i, i) * claimed(j, j)));
  }
}

namespace {

/// What the study predicts of a well and has no weights for: the azimuths at three stations, and the reference.
constexpr int kAzimuths = 3, kOthers = 5;

/// The sums of these, built here from derivatives of the azimuth and from the rows of the reference.
sensor::NoiseWeights weights_of_others(const test::RandomRun& r, const estimate::NominalTruth& truth,
                                       const estimate::Sensitivity& s, const estimate::InputErrors& sizes) {
  constexpr int kSums = sensor::NoiseWeights::kSums;
  std::vector<StationDerivatives<kSums>> stations(truth.stations.size());
  const std::array<std::size_t, 3> places = first_middle_last(stations.size());
  for (int i = 0; i < kAzimuths; ++i) {
    const std::size_t k = places[static_cast<std::size_t>(i)];
    const propagate::AzimuthDerivatives d = propagate::azimuth_derivatives(truth.stations[k]);
    stations[k].by_field.row(i) = d.by_field;
    stations[k].by_down.row(i) = d.by_down;
  }
  InputEffects<kSums> e = input_effects(stations, by_estimate(stations, truth), s, truth, sizes);
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Eigen::Vector3d u = survey::to_eigen(truth.stations[k].down_T);
    e.magnetometer[k].middleRows<2>(kAzimuths) = sizes.magnetometer * s.by_magnetometer[k].bottomRows<2>();
    e.accelerometer[k].middleRows<2>(kAzimuths) =
        sizes.down * s.by_down[k].bottomRows<2>() * (Eigen::Matrix3d::Identity() - u * u.transpose());
    e.reference[sizes.reference_per_station ? k : 0].middleRows<2>(kAzimuths) +=
        s.by_reference[k].bottomRows<2>() * Eigen::Vector2d(sizes.total, sizes.dip).asDiagonal();
  }
  return noise_weights(e, r.noise, {});
}

/// Errors of one trial: six parameters, position, azimuths, total field and dip (the last two if they are estimated).
Eigen::VectorXd errors_of_trial(const test::RandomRun& r, const survey::ReadingBlock& block,
                                const estimate::EstimateBlock& out, const survey::LaneArray& position, int t,
                                Eigen::Index rows) {
  const estimate::Vector6d x = test::parameters_of(out.parameters, t);
  Eigen::VectorXd e(rows);
  e.head<6>() = x;
  for (int i = 0; i < 3; ++i) e[6 + i] = position.value(t, i);
  const std::array<std::size_t, 3> places = first_middle_last(r.survey.stations.size());
  for (int i = 0; i < kAzimuths; ++i) {
    const auto k = static_cast<int>(places[static_cast<std::size_t>(i)]);
    const Eigen::Vector3d m = survey::to_eigen(test::triad(block.magnetic, t, k)),
                          b = (m - x.tail<3>()).cwiseQuotient(x.head<3>());
    const survey::Attitude seen = survey::attitude_from_fields(test::triad(block.down, t, k), survey::from_eigen(b));
    const survey::Station& true_one = r.survey.stations[static_cast<std::size_t>(k)];
    e[9 + i] = std::remainder(seen.azimuth + r.field.declination - true_one.azimuth, 2 * kPi);
  }
  if (rows == 14) {
    const double bh = out.reference.value(t, 0), bv = out.reference.value(t, 1);
    e.tail<2>() << std::hypot(bh, bv), std::atan2(bv, bh);
  }
  return e;
}

/// Every sd that msa_position predicts to first order, against trials by one estimator.
void check_first_order(const test::RandomRun& r, const estimate::EstimatorOptions& o, int trials) {
  const sensor::CleanReadings clean = sensor::clean_readings(r.survey, r.field, r.errors);
  const estimate::NominalTruth truth{sensor::station_fields(clean), r.errors.gain, r.errors.bias, r.field};
  const MsaPrediction p = predict_msa(r.survey, r.field, r.errors, {}, r.noise, clean, o);
  const sensor::NoiseWeights others = weights_of_others(r, truth, estimate::sensitivity(o, truth), o.assumed);

  survey::ReadingBlock block = sensor::make_reading_block(trials, r.survey.size(), r.noise);
  const int groups = survey::groups_for(trials);
  survey::LaneArray sums(groups, sensor::NoiseWeights::kSums), sums_of_others(groups, sensor::NoiseWeights::kSums),
      position(groups, 3);
  const random::Stream stream(77, 7);
  sensor::simulate_readings(clean, r.field, r.noise, stream, 0, block, &others, &sums_of_others);
  sensor::simulate_readings(clean, r.field, r.noise, stream, 0, block, &p.weights, &sums);
  estimate::EstimateBlock out(trials);
  const auto estimator = estimate::make_estimator(o, r.field, truth.stations);
  estimator->solve(block, out);
  survey::corrected_final_positions(block, out.parameters, r.survey.md(), r.field.declination, position);

  const int rows = estimator->estimates_reference() && r.noise.reference != sensor::ReferenceNoise::none ? 14 : 12;
  Eigen::VectorXd variance(rows), known(rows);
  known << p.linear.covariance.diagonal(),
      sensor::noise_sum_moments(others, r.noise.law).covariance.diagonal().head(rows - 9);
  variance.head<6>() = p.parameter_covariance.diagonal();
  variance.segment<3>(6) = p.position_covariance[0].diagonal();
  variance.segment<3>(9) = Eigen::Vector3d(p.claimed_azimuth_sd.data()).cwiseAbs2();
  if (rows == 14) variance.tail<2>() = p.reference_covariance.diagonal();
  Eigen::MatrixXd errors(trials, rows), linear(trials, rows);
  for (int t = 0; t < trials; ++t) {
    REQUIRE(out.converged.value(t, 0) == 1);
    errors.row(t) = errors_of_trial(r, block, out, position, t, rows);
    for (int i = 0; i < rows; ++i) linear(t, i) = i < 9 ? sums.value(t, i) : sums_of_others.value(t, i - 9);
  }
  for (int i = 0; i < rows; ++i) {
    // Perfect accelerometers leave the vertical to errors of azimuth, of which it may see squares as much as firsts.
    if (i == 8 && variance[8] < 1e-5 * variance.segment<2>(6).maxCoeff()) continue;
    CAPTURE(i);
    CHECK(std::abs(test::controlled_ratio(errors.col(i), linear.col(i), known[i], variance[i]) - 1) < 1e-3);
  }
}

/// Far from gains of 1, where solvers start, the misfit may have another minimum: there, of error-free readings, too.
bool finds_truth(const test::RandomRun& r, const sensor::CleanReadings& clean, const estimate::EstimatorOptions& o) {
  survey::ReadingBlock block = sensor::make_reading_block(1, r.survey.size(), {});
  sensor::simulate_readings(clean, r.field, {}, random::Stream(77, 7), 0, block);
  estimate::EstimateBlock out(1);
  estimate::make_estimator(o, r.field, sensor::station_fields(clean))->solve(block, out);
  const estimate::Vector6d x = test::parameters_of(out.parameters, 0);
  return (x.head<3>() - Eigen::Vector3d(r.errors.gain.data())).cwiseAbs().maxCoeff() < 1e-4;
}

/// So many wells in which first order is near at all: no gain has an sd of more than 5 % at the usual noise.
void check_first_order_of_wells(int wells, int trials) {
  int number = 0, elsewhere = 0;
  for (int found = 0; found < wells; ++number) {
    const test::RandomRun r = test::random_run(number, 0.02);
    const estimate::InputErrors sizes = input_errors(r.noise, {}, r.field);
    const sensor::CleanReadings clean = sensor::clean_readings(r.survey, r.field, r.errors);
    const MsaPrediction msa = predict_msa(r.survey, r.field, r.errors, {}, r.noise, clean, {});
    if (msa.parameter_covariance.diagonal().head<3>().maxCoeff() > std::pow(0.02 * 0.05, 2)) continue;
    ++found;
    for (const std::string& name : estimate::estimator_names()) {
      CAPTURE(number, name);
      const estimate::EstimatorOptions o = test::options_of(name, sizes);
      if (finds_truth(r, clean, o))
        check_first_order(r, o, trials);
      else
        ++elsewhere;
    }
  }
  CHECK(number < 1.1 * wells);
  CHECK(elsewhere < 0.05 * wells);
}

}  // namespace

TEST_CASE("First order is whole: 200 wells, any gains, every estimator, every sd against trials of little noise",
          "[long]") {
  check_first_order_of_wells(200, 128);
}

TEST_CASE("First order is whole: 4000 wells", "[.][nightly]") { check_first_order_of_wells(4000, 512); }

TEST_CASE("A reference whose errors do not change from station to station is one of the run") {
  const test::RandomRun r = test::random_run(11, 1);
  sensor::NoiseModel noise;
  noise.magnetometer = 40;
  noise.reference = sensor::ReferenceNoise::per_run;
  noise.reference_total = 90;
  noise.reference_dip = 0.12 * kDegree;
  const sensor::CleanReadings clean = sensor::clean_readings(r.survey, r.field, r.errors);
  const MsaPrediction of_run = predict_msa(r.survey, r.field, r.errors, {}, noise, clean, {});
  noise.reference = sensor::ReferenceNoise::per_station;
  const Eigen::Index n = 2 * r.survey.size();
  Eigen::MatrixXd lasting = Eigen::MatrixXd::Zero(n, n), unit = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i % 2; j < n; j += 2) lasting(i, j) = 1;
  const MsaPrediction of_stations = predict_msa(r.survey, r.field, r.errors, {}, noise, clean, {}, &lasting),
                      independent = predict_msa(r.survey, r.field, r.errors, {}, noise, clean, {}, &unit),
                      plain = predict_msa(r.survey, r.field, r.errors, {}, noise, clean, {});
  const auto close = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    return (a - b).cwiseAbs().maxCoeff() < 1e-9 * b.cwiseAbs().maxCoeff();
  };
  CHECK(close(of_stations.linear.covariance, of_run.linear.covariance));
  CHECK(close(of_stations.parameter_covariance, of_run.parameter_covariance));
  CHECK(close(of_stations.reference_covariance, of_run.reference_covariance));
  CHECK(close(independent.linear.covariance, plain.linear.covariance));
  CHECK_FALSE(close(of_stations.parameter_covariance, plain.parameter_covariance));
}
