#include <cmath>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "disturbance/station_disturbance.h"
#include "stats/linear_algebra.h"

using namespace surveymc;
using namespace surveymc::disturbance;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const survey::ReferenceField kField{9.80665, 55000, 74 * kDegree, 0, 0};

Process ar1() {
  Process p;
  p.tau = 5400;
  p.sd = {20, 12, 7};
  return p;
}

Process storms(bool mixing) {
  Process p;
  p.kind = Kind::storm;
  p.storms = 6.0 / 86400;
  p.rise = 1800;
  p.decay = 4000;
  p.sd = {40, 25, 10};
  p.mixing = mixing;
  return p;
}

/// A made-up record of 500 minutes, whose components go together.
Process record() {
  auto s = std::make_shared<Series>();
  s->field.resize(3, 500);
  for (int i = 0; i < 500; ++i) {
    const double t = i / 500.0;
    s->field.col(i) << 30 * std::sin(2 * kPi * t) + 8 * std::cos(14 * kPi * t), 12 * std::cos(4 * kPi * t + 1),
        -9 * std::sin(2 * kPi * t + 0.7) + 30 * t * t;
  }
  take_off_quiet_level(*s, QuietLevel::mean);
  Process p;
  p.kind = Kind::series;
  p.series = s;
  return p;
}

}  // namespace

TEST_CASE("Draws of every kind have the covariance in time that is predicted") {
  const std::vector<double> times{0, 600, 1500, 4200, 11000};
  const random::Stream stream(20160101, 7);
  const int trials = 40000;
  for (const Process& p : {ar1(), storms(false), storms(true), record()}) {
    CAPTURE(static_cast<int>(p.kind), p.mixing);
    std::vector<Eigen::Matrix3Xd> x;
    for (int t = 0; t < trials; ++t) x.push_back(draw(p, times, stream, static_cast<std::uint64_t>(t)));
    for (std::size_t i = 0; i < times.size(); ++i)
      for (std::size_t j = 0; j < times.size(); ++j) {
        const Eigen::Matrix3d predicted = covariance(p, times[j] - times[i]);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            double sum = 0, square = 0;
            for (const auto& m : x) {
              const double v = m(a, static_cast<Eigen::Index>(i)) * m(b, static_cast<Eigen::Index>(j));
              sum += v;
              square += v * v;
            }
            const double mean = sum / trials, error = std::sqrt((square / trials - mean * mean) / trials);
            CAPTURE(i, j, a, b);
            CHECK_THAT(mean, WithinAbs(predicted(a, b), 4.8 * error));  // 900 of them: one in 1000 runs fails
          }
      }
  }
}

TEST_CASE("The covariance of storms is the integral over their shape") {
  const Process p = storms(true);
  for (const double lag : {0.0, 500.0, 1800.0, 6000.0}) {
    double integral = 0;
    const double step = 0.5;
    const auto shape = [&](double u) {
      return u < 0 ? 0 : u < p.rise ? u / p.rise : std::exp(-(u - p.rise) / p.decay);
    };
    for (double u = step / 2; u < 90000; u += step) integral += shape(u) * shape(u + lag) * step;
    CHECK_THAT(covariance(p, lag)(0, 0), WithinRel(p.storms * integral * 1600, 1e-6));
  }
}

TEST_CASE("Kurtosis and tails are those of all minutes of a series, and of the fourth cumulant of storms") {
  const Process p = record();
  double second = 0, fourth = 0;
  for (int i = 0; i < 500; ++i) {
    const double x = p.series->field(0, i) - 2 * p.series->field(2, i);
    second += x * x / 500;
    fourth += x * x * x * x / 500;
  }
  CHECK_THAT(kurtosis(p, {1, 0, -2}), WithinRel(fourth / (second * second), 1e-12));
  // Rare storms without mixing: 3 + 3 E s^4 / (rate (E s^2)^2).
  Process rare = storms(false);
  rare.rise = 0;
  CHECK_THAT(kurtosis(rare, {1, 0, 0}), WithinRel(3 + 3 * (4000 / 4.0) / (rare.storms * 2000 * 2000), 1e-12));
  CHECK_THAT(outside_three_sd(ar1(), {0, 1, 0}), WithinRel(0.0026998, 1e-4));
}

TEST_CASE("Elements follow the field by exact derivatives") {
  const Eigen::Matrix3d m = elements_by_field(kField);
  const double h = kField.total * std::cos(kField.dip), z = kField.total * std::sin(kField.dip);
  const Eigen::Vector3d d(3e-3, -2e-3, 4e-3);  // nT
  const double along = h + d[0], horizontal = std::hypot(along, d[1]);
  CHECK_THAT(m.row(kDeclination).dot(d), WithinRel(std::atan2(d[1], along), 1e-6));
  CHECK_THAT(m.row(kDip).dot(d), WithinRel(std::atan2(z + d[2], horizontal) - kField.dip, 1e-5));
  CHECK_THAT(m.row(kTotal).dot(d), WithinRel(std::hypot(horizontal, z + d[2]) - kField.total, 1e-5));
}

TEST_CASE("Station draws keep their normals, to the bit without memory, and are correlated by the time between them") {
  Disturbance d;
  d.match_variance = true;
  d.times = {0, 100, 5000, 5600};
  std::vector<StationDraw> draws;
  for (std::uint32_t k = 1; k < 4; ++k)
    for (std::uint32_t s = 0; s < 2; ++s)
      draws.push_back({k, kDeclination, s, random::Channel::station_error, 2 * k + s});
  const random::Stream stream(3, 21);
  d.process.tau = 0;
  const StationDisturbance without(d, kField, draws);
  const std::vector<double> z = without.values(stream, 5), negative = without.values(stream, 11, true);
  for (std::size_t i = 0; i < draws.size(); ++i) {
    CHECK(z[i] == stream.normal(5, draws[i].channel, draws[i].index));
    CHECK(negative[i] == -z[i]);
  }
  CHECK(stats::lower_factor(without.correlation()) == Eigen::MatrixXd::Identity(6, 6));
  d.process.tau = 3000;
  const StationDisturbance with(d, kField, draws);
  const std::vector<double> x = with.values(stream, 5);
  const Eigen::VectorXd mixed =
      stats::lower_factor(with.correlation()) * Eigen::Map<const Eigen::VectorXd>(z.data(), 6);
  for (std::size_t i = 0; i < 6; ++i) CHECK_THAT(x[i], WithinAbs(mixed[static_cast<Eigen::Index>(i)], 1e-14));
  CHECK_THAT(with.correlation(0, 2), WithinRel(std::exp(-4900.0 / 3000), 1e-14));
  CHECK(with.correlation(0, 3) == 0);
}

TEST_CASE("A factor of a correlation of fewer numbers than stations has its rank") {
  Disturbance d;
  d.process.kind = Kind::series;
  Eigen::Matrix3d amplitude = Eigen::Matrix3d::Zero(), maximum = Eigen::Matrix3d::Zero();
  amplitude.row(1) << 25, 8, 3;
  amplitude(0, 0) = 10;
  maximum.row(1) << 9, 3, 1;
  d.process.series = std::make_shared<const Series>(daily_waves(amplitude, maximum));
  std::vector<StationDraw> draws;
  for (std::size_t k = 0; k < 30; ++k) {
    d.times.push_back(3600.0 * static_cast<double>(k));
    draws.push_back({k, kDeclination});
    draws.push_back({k, kDip});
  }
  const StationDisturbance s(d, kField, draws);
  const Eigen::MatrixXd c = s.correlation(), l = stats::lower_factor(c);
  CHECK((l * l.transpose() - c).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((l.diagonal().array() > 1e-3).count() == 6);  // three waves: a sine and a cosine each
  CHECK_THAT(s.sizes()[kDeclination],
             WithinRel(std::sqrt((625 + 64 + 9) / 2.0) / (55000 * std::cos(74 * kDegree)), 1e-9));
}

TEST_CASE(
    "Stations between the steps of a series have the correlation of what is drawn, which is one of a covariance") {
  Disturbance d;
  d.process.kind = Kind::series;
  Eigen::Matrix3d amplitude = Eigen::Matrix3d::Zero(), maximum = Eigen::Matrix3d::Zero();
  amplitude.row(1) << 25, 8, 3;
  maximum.row(1) << 9, 3, 1;
  d.process.series = std::make_shared<const Series>(daily_waves(amplitude, maximum));
  const double between = 30.0 / 28 * 3600 + 300;  // s, a stand at 28 m/h and its survey: 69.3 steps
  std::vector<StationDraw> draws;
  for (std::size_t k = 0; k < 60; ++k) {
    d.times.push_back(between * static_cast<double>(k));
    draws.push_back({k, kDeclination});
  }
  const StationDisturbance s(d, kField, draws);
  const Eigen::MatrixXd c = s.correlation(), l = stats::lower_factor(c);
  CHECK((l * l.transpose() - c).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((l.diagonal().array() > 1e-3).count() == 6);
  // Mean over all begins of the record, by the minutes at which the draws read it.
  const Eigen::RowVectorXd east = d.process.series->field.row(1);
  for (const std::size_t i : {1u, 17u, 40u})
    for (const std::size_t j : {2u, 31u, 59u}) {
      double product = 0;
      for (Eigen::Index m = 0; m < 1440; ++m) {
        const auto at = [&](std::size_t k) { return (m + std::lround(d.times[k] / 60)) % 1440; };
        product += east[at(i)] * east[at(j)];
      }
      CHECK_THAT(s.correlation(i, j), WithinAbs(product / east.squaredNorm(), 1e-12));
    }
}
