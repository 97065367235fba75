#include "sensor/gross_stations.h"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <set>

#include "random/choice.h"

using namespace surveymc;
using namespace surveymc::sensor;
using Catch::Matchers::WithinAbs;

namespace {

constexpr int kGrossTrials = 2000, kGrossStations = 12;

struct Drawn {
  survey::ReadingBlock readings{kGrossTrials, kGrossStations, true, false};
  std::vector<char> wrong;
  std::vector<double> frames;

  explicit Drawn(const GrossStations& gross) {
    for (int k = 0; k < kGrossStations; ++k) {  // turned about the vertical
      const double c = std::cos(0.4 * k), s = std::sin(0.4 * k);
      for (const double x : {c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0}) frames.push_back(x);
    }
    wrong = add_gross_errors(gross, random::Stream(5, 52), 64, frames, readings);
  }
  bool is_wrong(int trial, int k) const { return wrong[static_cast<std::size_t>(trial * kGrossStations + k)] != 0; }
  Eigen::Vector3d error(int trial, int k) const {
    return {readings.magnetic.value(trial, 3 * k), readings.magnetic.value(trial, 3 * k + 1),
            readings.magnetic.value(trial, 3 * k + 2)};
  }
  Eigen::Vector3d in_earth(int trial, int k) const {
    Eigen::Vector3d out;
    for (int i = 0; i < 3; ++i)
      out[i] = Eigen::Map<const Eigen::Vector3d>(frames.data() + 9 * k + 3 * i).dot(error(trial, k));
    return out;
  }
};

}  // namespace

TEST_CASE("So many stations are wrong as are asked for, and no other reading changes") {
  for (const GrossKind kind : {GrossKind::scattered, GrossKind::casing, GrossKind::stretch})
    for (const int count : {0, 1, 5, 12}) {
      const Drawn d({kind, count, 1500});
      for (int t = 0; t < kGrossTrials; ++t) {
        int found = 0;
        for (int k = 0; k < kGrossStations; ++k) {
          found += d.is_wrong(t, k);
          REQUIRE((d.error(t, k).norm() > 0) == d.is_wrong(t, k));
        }
        REQUIRE(found == count);
      }
    }
}

TEST_CASE("Scattered errors take every station as often, with the size of each axis") {
  const Drawn d({GrossKind::scattered, 3, 1500});
  double squares = 0, product = 0;
  for (int k = 0; k < kGrossStations; ++k) {
    int found = 0;
    for (int t = 0; t < kGrossTrials; ++t) {
      found += d.is_wrong(t, k);
      squares += d.error(t, k).squaredNorm();
      product += d.error(t, k).x() * d.error(t, (k + 1) % kGrossStations).x();
    }
    CHECK_THAT(found / double(kGrossTrials), WithinAbs(0.25, 4 * std::sqrt(0.25 * 0.75 / kGrossTrials)));
  }
  const double n = 9.0 * kGrossTrials;
  CHECK_THAT(squares / n / (1500.0 * 1500), WithinAbs(1, 4 * std::sqrt(2 / n)));
  CHECK_THAT(product / n / (1500.0 * 1500), WithinAbs(0, 4 / std::sqrt(n)));  // errors of their own
}

TEST_CASE("The field of a casing is one vector of the earth that decays from the first station") {
  const Drawn d({GrossKind::casing, 5, 2000});
  for (int t = 0; t < kGrossTrials; ++t)
    for (int k = 0; k < 5; ++k)
      REQUIRE((d.in_earth(t, k) - d.in_earth(t, 0) / std::pow(1 + 0.35 * k, 2)).norm() < 1e-9);
  CHECK(gross_decay(GrossKind::casing, 0) == 1);
}

TEST_CASE("A stretch is of neighbours, begins anywhere, and has one vector") {
  const Drawn d({GrossKind::stretch, 4, 1000});
  std::set<int> begins;
  for (int t = 0; t < kGrossTrials; ++t) {
    int first = 0;
    while (!d.is_wrong(t, first)) ++first;
    begins.insert(first);
    for (int k = first; k < first + 4; ++k) {
      REQUIRE(d.is_wrong(t, k));
      REQUIRE((d.in_earth(t, k) - d.in_earth(t, first)).norm() < 1e-9);
    }
  }
  CHECK(begins.size() == 9);
}

TEST_CASE("Every subset is chosen as often") {
  const random::Stream stream(1, 52);
  std::map<std::set<int>, int> times;
  const int draws = 6000;
  for (int t = 0; t < draws; ++t) {
    const std::vector<int> some =
        random::choose(stream, static_cast<std::uint64_t>(t), random::Channel::robust_subset, 3, 5, 2);
    ++times[{some.begin(), some.end()}];
  }
  REQUIRE(times.size() == 10);  // none twice in one subset
  for (const auto& [subset, n] : times) CHECK_THAT(n / double(draws), WithinAbs(0.1, 4 * std::sqrt(0.09 / draws)));
}
