/// Runs in a field that is not its reference: the draws against the readable definition, trial by trial.
#include "sensor/disturbed_runs.h"

#include <catch2/catch.hpp>

#include "survey/corrected_position.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::sensor;
using Catch::Matchers::WithinAbs;

namespace {

survey::Survey well() {
  return test::survey_of(7, [](int k) {
    return survey::Station{40. * k, (10 + 9 * k) * kDegree, (70 + 4 * k) * kDegree, (25 + 137 * k) * kDegree};
  });
}

DisturbedRunSetup setup_of(const survey::Survey& s) {
  DisturbedRunSetup setup = disturbed_run_setup(s, test::field_of(50000, 72, -4));
  setup.sd = survey::equal_axes(.004, .0005, 70, .0016);
  setup.interference = 220;
  setup.run = {50, .1 * kDegree, .2 * kDegree};
  setup.station = {60, .08 * kDegree, .15 * kDegree};
  setup.noise = 20;
  return setup;
}

}  // namespace

TEST_CASE("Readings of given normals are those of the runs that draw them, bit for bit") {
  const DisturbedRunSetup setup = setup_of(well());
  const random::Stream stream(7, 65000);
  survey::ReadingBlock drawn = make_disturbed_block(16, setup), given = make_disturbed_block(16, setup);
  draw_disturbed_runs(setup, stream, 32, drawn);
  const int stations = setup.stations();
  survey::LaneArray z(given.groups(), 16 + 6 * stations);
  for (int trial = 0; trial < 16; ++trial) {
    const auto number = static_cast<std::uint64_t>(32 + trial);
    const auto set = [&](int row, random::Channel channel, int index) {
      z.row(trial / simd::kGroup, row)[trial % simd::kGroup] =
          stream.normal(number, channel, static_cast<std::uint32_t>(index));
    };
    for (int i = 0; i < 16; ++i) set(i, random::Channel::disturbed_run, i);
    for (int k = 0; k < stations; ++k)
      for (int i = 0; i < 3; ++i) {
        set(16 + 3 * k + i, random::Channel::disturbed_station, 4 * k + i);
        set(16 + 3 * stations + 3 * k + i, random::Channel::magnetometer_noise, 3 * k + i);
      }
  }
  disturbed_readings(setup, z, given);
  for (int trial = 0; trial < 16; ++trial)
    for (int row = 0; row < 3 * stations; ++row) {
      CHECK(given.magnetic.value(trial, row) == drawn.magnetic.value(trial, row));
      CHECK(given.down.value(trial, row) == drawn.down.value(trial, row));
    }
  for (int row = 0; row < 2; ++row) CHECK(given.reference.value(3, row) == drawn.reference.value(3, row));
}

TEST_CASE("Readings of a disturbed run are those of the definition, draw by draw") {
  const survey::Survey s = well();
  const DisturbedRunSetup setup = setup_of(s);
  const random::Stream stream(7, 65000);
  survey::ReadingBlock block = make_disturbed_block(16, setup);
  survey::LaneArray sizes(2, block.stations);
  draw_disturbed_runs(setup, stream, 32, block, nullptr, &sizes);
  for (const int trial : {0, 5, 15}) {
    const auto number = static_cast<std::uint64_t>(32 + trial);
    const auto run = [&](std::uint32_t i) { return stream.normal(number, random::Channel::disturbed_run, i); };
    for (int k = 0; k < block.stations; ++k) {
      CAPTURE(trial, k);
      const auto station = [&](std::uint32_t i) {
        return stream.normal(number, random::Channel::disturbed_station, 4 * static_cast<std::uint32_t>(k) + i);
      };
      const double total = 50000 + 50 * run(13) + 60 * station(0);
      const double dip = (72 + .1 * run(14) + .08 * station(1)) * kDegree;
      const double declination = (-4 + .2 * run(15) + .15 * station(2)) * kDegree;
      const survey::Attitude at = survey::magnetic_attitude(s.stations[static_cast<std::size_t>(k) + 1], declination);
      const Eigen::Vector3d b = survey::to_eigen(survey::magnetic_T(at, total, dip)),
                            u = survey::to_eigen(survey::down_T(at));
      Eigen::Vector3d m, g;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::uint32_t>(axis);
        const double noise =
            stream.normal(number, random::Channel::magnetometer_noise, 3 * static_cast<std::uint32_t>(k) + a);
        m[axis] = (1 + .0016 * run(9 + a)) * b[axis] + 70 * run(6 + a) + (axis == 2 ? 220 * run(12) : 0) + 20 * noise;
        g[axis] = 9.80665 * (1 + .0005 * run(3 + a)) * u[axis] + .004 * run(a);
      }
      CHECK_THAT(sizes.value(trial, k), WithinAbs(g.norm(), 1e-5));  // normals of single precision on both sides
      g.normalize();
      for (int axis = 0; axis < 3; ++axis) {
        CHECK_THAT(block.magnetic.value(trial, 3 * k + axis), WithinAbs(m[axis], 1e-8));
        CHECK_THAT(block.down.value(trial, 3 * k + axis), WithinAbs(g[axis], 1e-13));
      }
    }
    CHECK_THAT(block.reference.value(trial, 0), WithinAbs(50000 * std::cos(72 * kDegree), 1e-8));
    CHECK_THAT(block.reference.value(trial, 1), WithinAbs(50000 * std::sin(72 * kDegree), 1e-8));
  }
}

TEST_CASE("Positions of a survey with a tie-on: its own without errors, and with the first leg doubled") {
  const survey::Survey s = well();
  DisturbedRunSetup setup = disturbed_run_setup(s, test::field_of(50000, 72, -4));
  survey::LaneArray unit(1, 6, true);
  for (int i = 0; i < 6; ++i) unit.fill(0, i, i < 3 ? 1 : 0);
  const auto positions = [&](bool doubled) {
    survey::ReadingBlock block = make_disturbed_block(8, setup);
    draw_disturbed_runs(setup, random::Stream(7, 65000), 0, block);
    survey::LaneArray position(1, 3), lateral(1, block.stations);
    survey::corrected_tied_positions(block, unit, survey::tied_survey(s, setup.field.declination, doubled), position,
                                     lateral);
    return std::pair(Eigen::Vector3d(position.value(3, 0), position.value(3, 1), position.value(3, 2)),
                     lateral.value(3, 0));
  };
  const Eigen::Vector3d truth = survey::minimum_curvature_positions(s).back();
  CHECK((positions(true).first - truth).norm() < 1e-9);
  // An error of declination turns the whole survey; of the tie-on, only where the first leg is doubled.
  setup.run.declination = .5 * kDegree;
  const double turn = .5 * kDegree * random::Stream(7, 65000).normal(3, random::Channel::disturbed_run, 15);
  const auto [once, lateral] = positions(false);
  const Eigen::Vector3d first = survey::to_eigen(survey::true_tangents(s)[1]);
  const Eigen::Vector3d turned(std::cos(-turn) * first.x() - std::sin(-turn) * first.y(),
                               std::sin(-turn) * first.x() + std::cos(-turn) * first.y(), first.z());
  CHECK((positions(true).first - once - 20 * (turned - first)).norm() < 1e-9);
  CHECK_THAT(lateral, WithinAbs(std::sin(19 * kDegree) * std::sin(-turn), 1e-12));
}

TEST_CASE("A turned run is the run of a survey whose toolfaces are larger by one angle, draw by draw") {
  const random::Stream stream(7, 65000);
  DisturbedRunSetup setup = setup_of(well());
  setup.turned = true;
  survey::ReadingBlock block = make_disturbed_block(8, setup);
  draw_disturbed_runs(setup, stream, 16, block);
  for (const int trial : {0, 3, 7}) {
    const std::uint64_t number = static_cast<std::uint64_t>(16 + trial), call = 4;
    const double angle = 2 * kPi * stream.uniforms<double>(number, random::Channel::disturbed_run, call)[0];
    survey::Survey turned = well();
    for (survey::Station& s : turned.stations) s.toolface += angle;
    survey::ReadingBlock plain = make_disturbed_block(8, setup_of(turned));
    draw_disturbed_runs(setup_of(turned), stream, 16, plain);
    for (int row = 0; row < 3 * block.stations; ++row) {
      CAPTURE(trial, row);
      CHECK_THAT(block.magnetic.value(trial, row), WithinAbs(plain.magnetic.value(trial, row), 1e-8));
      CHECK_THAT(block.down.value(trial, row), WithinAbs(plain.down.value(trial, row), 1e-13));
    }
  }
}

TEST_CASE("Draws of the stations that the caller makes take the place of the stream's, to the bit") {
  const DisturbedRunSetup setup = setup_of(well());
  const random::Stream stream(7, 65000);
  survey::ReadingBlock block = make_disturbed_block(16, setup), given = make_disturbed_block(16, setup);
  survey::LaneArray made(block.groups(), 3 * block.stations);
  for (int t = 0; t < 16; ++t)
    for (int k = 0; k < block.stations; ++k)
      for (std::uint32_t i = 0; i < 3; ++i)
        made.row(t / simd::kGroup, 3 * k + static_cast<int>(i))[t % simd::kGroup] =
            stream.normal(static_cast<std::uint64_t>(32 + t), random::Channel::disturbed_station,
                          4 * static_cast<std::uint32_t>(k) + i);
  draw_disturbed_runs(setup, stream, 32, block);
  draw_disturbed_runs(setup, stream, 32, given, &made);
  for (int t = 0; t < 16; ++t)
    for (int r = 0; r < 3 * block.stations; ++r) {
      CHECK(given.magnetic.value(t, r) == block.magnetic.value(t, r));
      CHECK(given.down.value(t, r) == block.down.value(t, r));
    }
}
