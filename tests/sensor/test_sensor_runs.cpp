#include "sensor/sensor_runs.h"

#include <catch2/catch.hpp>

#include "angles.h"
#include "base/units.h"
#include "propagate/sensor_error_covariance.h"
#include "propagate/tangent_propagation.h"
#include "random_runs.h"
#include "stats/moments.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::sensor;

namespace {

survey::ReferenceField reference(double dip_deg) { return test::field_of(50000, dip_deg, -4); }

/// Build from the vertical, through the horizontal, and up.
survey::Survey winding_well() {
  return test::survey_of(14, [](int k) {
    const double inclination = k < 3 ? 0.0 : k == 3 ? 1e-7 : 9.0 * (k - 3);
    return survey::Station{30.0 * k + (k > 4 ? 3.5 : 0), inclination * kDegree, (350 + 7 * k) * kDegree,
                           (20 + 77 * k) * kDegree};
  });
}

/// The chain as one would write it: readings, inclination and azimuth, then the position of the last station.
Eigen::Vector3d readable_position(const survey::Survey& survey, const survey::ReferenceField& field,
                                  const std::vector<double>& toolface, const double* e, survey::PositionMethod method,
                                  int last) {
  survey::Survey measured;
  for (std::size_t k = 0; k < survey.stations.size() && static_cast<int>(k) <= last; ++k) {
    survey::Attitude at = survey::magnetic_attitude(survey.stations[k], field.declination);
    at.toolface = toolface[k];
    const survey::Vec3<double> g = scale(field.gravity, survey::down_T(at)),
                               b = survey::magnetic_T(at, field.total, field.dip);
    const survey::Vec3<double> gm{(1 + e[3]) * g.x + e[0], (1 + e[4]) * g.y + e[1], (1 + e[5]) * g.z + e[2]};
    const survey::Vec3<double> bm{(1 + e[9]) * b.x + e[6], (1 + e[10]) * b.y + e[7], (1 + e[11]) * b.z + e[8]};
    const survey::Attitude seen = survey::attitude_from_fields(gm, bm);
    measured.stations.push_back({survey.stations[k].md, seen.inclination, seen.azimuth + field.declination, 0});
  }
  return (method == survey::PositionMethod::minimum_curvature ? survey::minimum_curvature_positions(measured)
                                                              : test::balanced_tangential_positions(measured))
      .back();
}

/// Trials from `first` on, with their positions.
SensorRuns runs_of(const SensorRunSetup& setup, int trials, const random::Stream& stream, std::uint64_t first = 0) {
  SensorRuns runs(trials, setup);
  draw_runs(setup, stream, first, runs);
  run_positions(setup, runs);
  return runs;
}

}  // namespace

TEST_CASE("Positions of the lanes are those of the readable chain through inclination and azimuth") {
  const survey::Survey survey = winding_well();
  const random::Stream stream(5, 9);
  const std::vector<int> reported{0, 1, 5, 13};
  for (const double dip : {-60.0, 72.0})
    for (const survey::PositionMethod method :
         {survey::PositionMethod::minimum_curvature, survey::PositionMethod::balanced_tangential})
      for (const survey::ToolfacePlan& plan :
           {survey::surveyed_toolfaces(survey), survey::slid(survey.size()), survey::rotated(survey.size()),
            survey::partly_slid(survey.md(), 50, 220)}) {
        const survey::ReferenceField field = reference(dip);
        const SensorRunSetup setup =
            sensor_run_setup(survey, field, survey::equal_axes(0.02, 0.002, 300, 0.005), plan, method, reported);
        const SensorRuns runs = runs_of(setup, 21, stream, 64);
        for (const int t : {0, 3, 7, 8, 20}) {
          const auto trial = static_cast<std::uint64_t>(64 + t);
          const std::vector<double> toolface = toolfaces_of_trial(plan, stream, trial);
          double e[survey::kSensorTerms];
          for (int i = 0; i < survey::kSensorTerms; ++i) {
            e[i] = runs.errors.value(t, i);
            CHECK(e[i] == setup.sd[static_cast<std::size_t>(i)] *
                              stream.normal(trial, random::Channel::sensor_term, static_cast<std::uint32_t>(i)));
          }
          for (std::size_t r = 0; r < reported.size(); ++r) {
            const Eigen::Vector3d expected = readable_position(survey, field, toolface, e, method, reported[r]);
            CAPTURE(dip, t, r);
            // 400 m, 14 stations, each direction within 1e-14
            for (int i = 0; i < 3; ++i)
              CHECK(std::abs(runs.positions.value(t, 3 * static_cast<int>(r) + i) - expected[i]) < 1e-11);
          }
        }
      }
}

TEST_CASE("A tie-on has no error: what the first station would have read moves nothing") {
  const survey::Survey survey = winding_well();
  const random::Stream stream(5, 9);
  const survey::ReferenceField field = reference(72);
  // An error of the first station alone moves the half leg after it; a second leg does not know it.
  const auto positions = [&](bool tie_on, double accelerometer_bias) {
    SensorRunSetup setup =
        sensor_run_setup(survey, field, survey::equal_axes(accelerometer_bias, 0, 0, 0),
                         survey::surveyed_toolfaces(survey), survey::PositionMethod::balanced_tangential, {1, 2});
    setup.first_is_tie_on = tie_on;
    return runs_of(setup, 8, stream);
  };
  const SensorRuns perfect = positions(false, 0), measured = positions(false, 0.02), tied = positions(true, 0.02),
                   tied_perfect = positions(true, 0);
  const std::vector<double> md = survey.md();
  for (int t = 0; t < 8; ++t) {
    double before[2] = {}, after[2] = {};
    for (int i = 0; i < 3; ++i) {
      CHECK(tied_perfect.positions.value(t, i) == perfect.positions.value(t, i));
      for (const int leg : {0, 1}) {
        const double shift = measured.positions.value(t, 3 * leg + i) - tied.positions.value(t, 3 * leg + i);
        before[leg] += shift * shift;
        const double error = tied.positions.value(t, 3 * leg + i) - perfect.positions.value(t, 3 * leg + i);
        after[leg] += error * error;
      }
    }
    CHECK(before[0] > 1e-6);                         // the first station's error, half a leg of it
    CHECK(std::abs(before[1] - before[0]) < 1e-11);  // stays as it is further down
    CHECK(after[0] > 1e-6);                          // the second station is measured all the same
  }
}

TEST_CASE("Toolfaces are addressed by station, a slide by its first station") {
  const survey::Survey survey = winding_well();
  const random::Stream stream(11, 9);
  const survey::ToolfacePlan mixed = survey::partly_slid(survey.md(), 50, 220), own = survey::rotated(survey.size());
  const std::vector<double> a = toolfaces_of_trial(mixed, stream, 3), b = toolfaces_of_trial(own, stream, 3);
  CHECK(mixed.first_slid() == 2);
  for (std::size_t k = 0; k < a.size(); ++k)
    CHECK(a[k] == (mixed.source[k] == survey::ToolfaceSource::own ? b[k] : b[2]));
  const SensorRunSetup setup = sensor_run_setup(survey, reference(72), survey::equal_axes(0.004, 0, 0, 0), mixed,
                                                survey::PositionMethod::minimum_curvature, {13});
  SensorRuns runs(8, setup);
  draw_runs(setup, stream, 0, runs);
  for (int k = 0; k < survey.size(); ++k) {
    CHECK(std::abs(runs.toolface.value(3, 2 * k) - std::cos(a[static_cast<std::size_t>(k)])) < 1e-15);
    CHECK(std::abs(runs.toolface.value(3, 2 * k + 1) - std::sin(a[static_cast<std::size_t>(k)])) < 1e-15);
  }
}

TEST_CASE("Without errors the positions are the survey's, whatever the toolface") {
  const survey::Survey survey = winding_well();
  const auto exact = survey::minimum_curvature_positions(survey);
  const SensorRunSetup setup =
      sensor_run_setup(survey, reference(72), survey::SensorTermArray{}, survey::rotated(survey.size()),
                       survey::PositionMethod::minimum_curvature, {2, 13});
  const SensorRuns runs = runs_of(setup, 16, random::Stream(1, 9));
  for (int t = 0; t < 16; ++t)
    for (int i = 0; i < 3; ++i) {
      CHECK(std::abs(runs.positions.value(t, i) - exact[2][i]) < 1e-12);
      CHECK(std::abs(runs.positions.value(t, 3 + i) - exact[13][i]) < 1e-11);
    }
}

TEST_CASE("Small sensor errors spread positions as the covariance says") {
  const survey::Survey survey = winding_well();
  const survey::ReferenceField field = reference(72);
  const survey::SensorTermArray sd =
      survey::equal_axes(0.0004, 0.00005, 7, 0.00016);  // a tenth: second order is out of sight
  constexpr int kTrials = 20000;
  for (const survey::ToolfacePlan& plan :
       {survey::surveyed_toolfaces(survey), survey::slid(survey.size()), survey::rotated(survey.size())}) {
    const Eigen::Matrix3d predicted =
        propagate::sensor_error_covariances(survey, field, sd, plan, survey::PositionMethod::minimum_curvature).back();
    const SensorRunSetup setup =
        sensor_run_setup(survey, field, sd, plan, survey::PositionMethod::minimum_curvature, {survey.size() - 1});
    const SensorRuns runs = runs_of(setup, kTrials, random::Stream(2, 9));
    Eigen::MatrixXd x(kTrials, 3);
    for (int t = 0; t < kTrials; ++t)
      for (int i = 0; i < 3; ++i) x(t, i) = runs.positions.value(t, i);
    const stats::Moments m = stats::Moments::of(x);
    for (int i = 0; i < 3; ++i) {
      const double relative = m.variance(i) / predicted(i, i) - 1;
      CHECK(std::abs(relative) < 4 * std::sqrt((m.kurtosis(i) - 1) / kTrials));
    }
  }
}

TEST_CASE("The covariance at given toolfaces is the whole first order: 200 wells against trials of little errors",
          "[long]") {
  constexpr int kTrials = 64;
  for (int number = 0; number < 200; ++number) {
    const test::RandomRun r = test::random_run(number, 0);
    const bool tie_on = number % 2 == 0;
    survey::SensorTermArray sd = survey::equal_axes(0.004, 0.0005, 70, 0.0016);
    for (std::size_t i = 0; i < sd.size(); ++i)  // a fiftieth, unlike from axis to axis, one in four without error
      sd[i] *= 0.02 * static_cast<double>((number + 5 * i) % 4) / 2;
    const survey::ToolfacePlan plan = survey::surveyed_toolfaces(r.survey);
    const int last = r.survey.size() - 1;
    const std::vector<double> md = r.survey.md();
    const std::vector<survey::Vec3<double>> tangents = survey::true_tangents(r.survey);
    std::vector<propagate::TangentErrors> by_error = propagate::sensor_tangent_errors(r.survey, r.field, sd, plan);
    if (tie_on) by_error.front().constant.setZero();
    const Eigen::Matrix3d predicted =
        propagate::propagate_tangent_errors(md, tangents, by_error, survey::PositionMethod::minimum_curvature).back();
    // By a draw of unit variance of each error.
    const std::vector<Eigen::Matrix3d> by_tangent = survey::final_position_by_tangent(md, tangents);
    Eigen::Matrix<double, 3, survey::kSensorTerms> by_draw = Eigen::Matrix<double, 3, survey::kSensorTerms>::Zero();
    for (std::size_t k = 0; k < by_tangent.size(); ++k) by_draw += by_tangent[k] * by_error[k].constant;

    SensorRunSetup setup =
        sensor_run_setup(r.survey, r.field, sd, plan, survey::PositionMethod::minimum_curvature, {last});
    setup.first_is_tie_on = tie_on;
    SensorRuns runs(kTrials, setup);
    draw_runs(setup, random::Stream(3, 9), 0, runs);
    for (int i = 0; i < survey::kSensorTerms; ++i)  // antithetic pairs
      for (int t = 1; t < kTrials; t += 2)
        runs.errors.row(t / simd::kGroup, i)[t % simd::kGroup] = -runs.errors.value(t - 1, i);
    run_positions(setup, runs);
    Eigen::MatrixXd position(kTrials, 3), linear(kTrials, 3);
    for (int t = 0; t < kTrials; ++t) {
      Eigen::Matrix<double, survey::kSensorTerms, 1> z;
      for (int i = 0; i < survey::kSensorTerms; ++i) {
        const double size = sd[static_cast<std::size_t>(i)];
        z[i] = size > 0 ? runs.errors.value(t, i) / size : 0;
      }
      linear.row(t) = by_draw * z;
      for (int i = 0; i < 3; ++i) position(t, i) = runs.positions.value(t, i);
    }
    for (int i = 0; i < 3; ++i) {
      CAPTURE(number, i);
      const double known = by_draw.row(i).squaredNorm();
      CHECK(std::abs(test::controlled_ratio(position.col(i), linear.col(i), known, predicted(i, i)) - 1) < 1e-3);
    }
  }
}
