#include "sensor/tool_spread.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "sensor/tool_spread_lanes.h"
#include "simd/instruction_set.h"
#include "stats/moments.h"
#include "stats/tests.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::sensor;

namespace {

const ToolSpread kSpread{0.0016, 70};

struct Spread {
  Spread(int number, std::uint64_t first, int trials, bool antithetic, const NoiseWeights* weights = nullptr)
      : c(test::thesis_case(number)),
        clean(clean_readings(c.survey, c.field, c.errors)),
        block(make_reading_block(trials, c.survey.size(), {})),
        deviation(survey::groups_for(trials), 6),
        sums(survey::groups_for(trials), NoiseWeights::kSums) {
    simulate_readings(clean, c.field, {}, random::Stream(21, 3), first, block);
    spread_tools(clean, kSpread, antithetic, random::Stream(21, 3), first, block, deviation, weights, &sums);
  }
  test::ThesisCase c;
  CleanReadings clean;
  survey::ReadingBlock block;
  survey::LaneArray deviation, sums;
};

double size(int i) { return i < 3 ? kSpread.gain : kSpread.bias; }
double& component(survey::Vec3<double>& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

TEST_CASE("A drawn tool deviates by the normals of its address, and its readings are those of that tool") {
  Spread s(3, 512, 16, false);
  for (int t = 0; t < 16; ++t) {
    for (int i = 0; i < 6; ++i)
      REQUIRE(s.deviation.value(t, i) == size(i) * random::Stream(21, 3).normal(512 + static_cast<std::uint64_t>(t),
                                                                                random::Channel::tool_errors,
                                                                                static_cast<std::uint32_t>(i)));
    MagnetometerErrors tool = s.c.errors;
    for (std::size_t i = 0; i < 3; ++i) {
      tool.gain[i] += s.deviation.value(t, static_cast<int>(i));
      tool.bias[i] += s.deviation.value(t, static_cast<int>(3 + i));
    }
    CleanReadings own = clean_readings(s.c.survey, s.c.field, tool);
    for (int r = 0; r < 3 * s.c.survey.size(); ++r)
      REQUIRE(std::abs(s.block.magnetic.value(t, r) - component(own.magnetic_T[static_cast<std::size_t>(r / 3)],
                                                                r % 3)) < 4e-11);  // four roundings of 5e4 nT
  }
}

TEST_CASE("Tools have the mean, the size and no correlation that the spread says") {
  constexpr int trials = 16384;
  const Spread s(4, 0, trials, false);
  Eigen::MatrixXd x(trials, 6);
  for (int t = 0; t < trials; ++t)
    for (int i = 0; i < 6; ++i) x(t, i) = s.deviation.value(t, i) / size(i);
  const stats::Moments m = stats::Moments::of(x);
  for (int i = 0; i < 6; ++i) CHECK(std::abs(m.mean[i]) < 4 / std::sqrt(double(trials)));
  CHECK(stats::wishart_test(m.covariance(), Eigen::MatrixXd::Identity(6, 6), m.count).p_value > 1e-3);
}

TEST_CASE("A spread of nothing, or of gains alone, changes nothing else") {
  const test::ThesisCase c = test::thesis_case(4);
  const CleanReadings clean = clean_readings(c.survey, c.field, c.errors);
  const survey::ReadingBlock before = test::simulated(c, {}, 8, random::Stream(1, 1));
  survey::ReadingBlock after = test::simulated(c, {}, 8, random::Stream(1, 1));
  survey::LaneArray deviation(1, 6);
  CHECK(!ToolSpread{}.any());
  spread_tools(clean, {}, false, random::Stream(1, 1), 0, after, deviation);
  for (int r = 0; r < 3 * c.survey.size(); ++r) CHECK(after.magnetic.value(5, r) == before.magnetic.value(5, r));
  spread_tools(clean, {0.001, 0}, false, random::Stream(1, 1), 0, after, deviation);
  for (int i = 0; i < 3; ++i) {
    CHECK(deviation.value(5, i) != 0);
    CHECK(deviation.value(5, 3 + i) == 0);
  }
}

TEST_CASE("Antithetic tools 2j and 2j + 1 are those of trial j and opposite") {
  NoiseWeights weights;
  for (std::size_t i = 0; i < 6 * NoiseWeights::kSums; ++i) weights.tool.push_back(std::sin(0.1 + double(i)));
  const Spread pairs(3, 1024, 32, true, &weights), own(3, 512, 16, false, &weights);
  for (int t = 0; t < 32; ++t) {
    const double sign = t % 2 == 0 ? 1 : -1;
    for (int i = 0; i < 6; ++i) REQUIRE(pairs.deviation.value(t, i) == sign * own.deviation.value(t / 2, i));
    for (int q = 0; q < NoiseWeights::kSums; ++q) {
      REQUIRE(pairs.sums.value(t, q) == sign * own.sums.value(t / 2, q));
      double expected = 0;
      for (std::size_t i = 0; i < 6; ++i)
        expected += weights.tool[i * NoiseWeights::kSums + static_cast<std::size_t>(q)] *
                    pairs.deviation.value(t, static_cast<int>(i)) / size(static_cast<int>(i));
      REQUIRE(std::abs(pairs.sums.value(t, q) - expected) < 1e-14);  // six terms of order one
    }
  }
}

TEST_CASE("A trial has the same tool in whatever batch it comes") {
  const Spread large(2, 512, 64, false), small(2, 512 + 40, 8, false);
  for (int t = 0; t < 8; ++t) {
    for (int i = 0; i < 6; ++i) REQUIRE(small.deviation.value(t, i) == large.deviation.value(40 + t, i));
    for (int r = 0; r < 3 * small.c.survey.size(); ++r)
      REQUIRE(small.block.magnetic.value(t, r) == large.block.magnetic.value(40 + t, r));
  }
}

TEST_CASE("Tools and assumed sd have the same bits from AVX2 and AVX-512") {
  if (simd::instruction_set() != simd::InstructionSet::v4) return;  // nothing to compare on this machine
  const test::ThesisCase c = test::thesis_case(4);
  const CleanReadings clean = clean_readings(c.survey, c.field, c.errors);
  NoiseWeights weights;
  for (std::size_t i = 0; i < 6 * NoiseWeights::kSums; ++i) weights.tool.push_back(std::cos(0.3 + double(i)));
  constexpr int trials = 64, rows = 3 * 53;
  REQUIRE(rows == 3 * c.survey.size());
  struct Result {
    survey::LaneArray magnetic{survey::groups_for(trials), rows}, deviation{survey::groups_for(trials), 6},
        sums{survey::groups_for(trials), NoiseWeights::kSums}, assumed{survey::groups_for(trials), rows};
  };
  const auto run = [&](simd::InstructionSet set, bool antithetic) {
    Result r;
    const random::Stream stream(4, 2);
    const ToolSpreadBatch tools{
        &clean.field_T.front().x,
        r.magnetic.row(0, 0),
        r.deviation.row(0, 0),
        r.sums.row(0, 0),
        weights.tool.data(),
        r.magnetic.group_stride(),
        r.deviation.group_stride(),
        r.sums.group_stride(),
        c.survey.size(),
        survey::groups_for(trials),
        64,
        {kSpread.sd(0), kSpread.sd(1), kSpread.sd(2), kSpread.sd(3), kSpread.sd(4), kSpread.sd(5)},
        antithetic,
        stream};
    const AssumedSdBatch assumed{r.assumed.row(0, 0),
                                 r.assumed.group_stride(),
                                 rows,
                                 survey::groups_for(trials),
                                 64,
                                 AssumedNoise::random_variance,
                                 70,
                                 stream};
    if (set == simd::InstructionSet::v4) {
      isa_v4::spread_tools(tools);
      isa_v4::draw_assumed_sd(assumed);
    } else {
      isa_v3::spread_tools(tools);
      isa_v3::draw_assumed_sd(assumed);
    }
    return r;
  };
  for (const bool antithetic : {false, true}) {
    const Result a = run(simd::InstructionSet::v3, antithetic), b = run(simd::InstructionSet::v4, antithetic);
    for (int t = 0; t < trials; ++t) {
      for (int i = 0; i < 6; ++i) REQUIRE(a.deviation.value(t, i) == b.deviation.value(t, i));
      for (int q = 0; q < NoiseWeights::kSums; ++q) REQUIRE(a.sums.value(t, q) == b.sums.value(t, q));
      for (int r = 0; r < rows; ++r) {
        REQUIRE(a.magnetic.value(t, r) == b.magnetic.value(t, r));
        REQUIRE(a.assumed.value(t, r) == b.assumed.value(t, r));
      }
    }
  }
}

TEST_CASE("Assumed noise is uniform as sd or as variance, by its address, and new in every trial") {
  const test::ThesisCase c = test::thesis_case(3);
  constexpr int trials = 2048;
  const int rows = 3 * c.survey.size();
  for (const AssumedNoise law : {AssumedNoise::random_sd, AssumedNoise::random_variance}) {
    survey::ReadingBlock block = make_reading_block(trials, c.survey.size(), {});
    block.add_assumed_sd();
    draw_assumed_sd(law, 70, random::Stream(5, 1), 512, block);
    double sum = 0, lowest = 1e9, highest = 0;
    for (int t = 0; t < trials; ++t)
      for (int r = 0; r < rows; ++r) {
        const double sd = block.assumed_sd.value(t, r);
        const double drawn = law == AssumedNoise::random_sd ? sd : sd * sd;  // nT, or nT^2
        sum += drawn;
        lowest = std::min(lowest, drawn);
        highest = std::max(highest, drawn);
      }
    const double n = double(trials) * rows;
    CHECK(std::abs(sum / n - 35) < 4 * 70 / std::sqrt(12 * n));
    CHECK(lowest > 0);  // a weight of infinity would be an estimate from one reading
    CHECK(highest < 70 * (1 + 1e-15));
    CHECK(block.assumed_sd.value(0, 0) != block.assumed_sd.value(1, 0));
    survey::ReadingBlock small = make_reading_block(8, c.survey.size(), {});
    small.add_assumed_sd();
    draw_assumed_sd(law, 70, random::Stream(5, 1), 512 + 16, small);
    for (int t = 0; t < 8; ++t)
      for (int r = 0; r < rows; ++r) REQUIRE(small.assumed_sd.value(t, r) == block.assumed_sd.value(16 + t, r));
  }
}
