/// Ranges of points of about the same cost, of sweeps that are read whole and of larger ones.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "study/point_costs.h"

using namespace surveymc;
using namespace surveymc::study;

namespace {

int g_asked = 0;

/// cost = a * b + c; c = -1 is refused.
class Costly final : public PlanOf<double> {
 public:
  using PlanOf::PlanOf;
  double cost() const override { return s_; }
  std::unique_ptr<StudyPoint> prepare(const montecarlo::RunOptions&) const override { return nullptr; }
};

RunPlan run_of(const std::string& sweep) {
  const Experiment experiment = {random::StudyId::none, "", "",
                                 [](config::ConfigReader& c, random::StudySeed) -> std::unique_ptr<PointPlan> {
                                   ++g_asked;
                                   const double a = c.number("a", config::Range::non_negative(), "", 1),
                                                b = c.number("b", config::Range::non_negative(), "", 1),
                                                more = c.number("c", config::Range::closed(-1, 1e9), "", 0);
                                   c.require(more >= 0, "c", "must not be -1");
                                   c.finish();
                                   return std::make_unique<Costly>(a * b + more);
                                 }};
  g_asked = 0;
  return open_run(experiment, config::Config::from_text("experiment = 'e'\n[sweep]\n" + sweep, "t.toml", {}));
}

/// Largest and least true cost of a range over the mean.
std::pair<double, double> spread(const RunPlan& run, const std::vector<checkpoint::PointRange>& ranges) {
  double all = 0, least = kInfinity, most = 0;
  std::uint64_t end = 0;
  for (const checkpoint::PointRange& r : ranges) {
    CHECK(r.first == end);
    CHECK(r.end > r.first);
    end = r.end;
    double cost = 0;
    for (std::uint64_t i = r.first; i < r.end; ++i) cost += run.plan(i)->cost();
    all += cost;
    least = std::min(least, cost);
    most = std::max(most, cost);
  }
  CHECK(end == run.point_count());
  const double mean = all / static_cast<double>(ranges.size());
  return {least / mean, most / mean};
}

}  // namespace

TEST_CASE("Points of a small sweep are all read, and cut where the cost is equal") {
  const RunPlan run = run_of("a = [1, 2, 3, 4, 10, 11, 12]\n");
  const PointCosts costs(run);
  CHECK(g_asked == 7);
  CHECK(costs.before(0) == 0);
  CHECK(costs.before(5) == 20);
  CHECK(costs.before(7) == 43);
  const std::vector<checkpoint::PointRange> four = costs.ranges(4);
  CHECK(four == std::vector<checkpoint::PointRange>{{0, 4, 1}, {4, 5, 1}, {5, 6, 1}, {6, 7, 1}});
  CHECK(costs.ranges(2) == std::vector<checkpoint::PointRange>{{0, 5, 1}, {5, 7, 1}});  // 20 and 23, not 31 and 12
  CHECK(costs.ranges(100).size() == 7);
}

TEST_CASE("Ranges of a large product have equal costs, though few points are read") {
  // The last key is the fastest: each range of 100 points has all of its values, which cost 1 to 100.
  const RunPlan run = run_of("a = { from = 1, to = 300, count = 300 }\nb = { from = 1, to = 100, count = 100 }\n");
  REQUIRE(run.is_large());
  const PointCosts costs(run);
  CHECK(g_asked < 700);
  double sum = 0;
  for (const std::uint64_t end : {0, 1, 57, 100, 12'345, 30'000}) {
    sum = 0;
    for (std::uint64_t i = 0; i < end; ++i) sum += static_cast<double>((i / 100 + 1) * (i % 100 + 1));
    CHECK(costs.before(end) == Approx(sum).epsilon(1e-12));
  }
  const std::vector<checkpoint::PointRange> ranges = costs.ranges(40);
  CHECK(ranges.size() == 40);
  const auto [least, most] = spread(run, ranges);
  // A cut is off by half a point at most: 300 * 100 / 2 on both sides of a range of 150 * 301 * 50 * 101 / 40 = 5.7e6
  CHECK(least > 0.99);
  CHECK(most < 1.01);
}

TEST_CASE("Ranges of a large sweep whose costs are no product are cut by a point of every stretch") {
  const RunPlan sum = run_of("a = { from = 1, to = 300, count = 300 }\nc = { from = 0, to = 9900, count = 100 }\n");
  const PointCosts costs(sum);
  CHECK(g_asked > 10'000);
  CHECK(g_asked < 10'700);
  // 250 stretches a range, whose points' costs spread by 0.6 of their mean: the sum by 0.6 / sqrt(250) = 3.8 %
  const auto [least, most] = spread(sum, costs.ranges(40));
  CHECK(least > 1 - 5 * 0.038);
  CHECK(most < 1 + 5 * 0.038);

  const RunPlan drawn = run_of("design = { kind = 'sobol', points = 16384, seed = 1 }\na = { from = 1, to = 9 }\n");
  const auto [low, high] = spread(drawn, PointCosts(drawn).ranges(16));  // sd of a cost / mean 0.46, 625 stretches
  CHECK(low > 1 - 5 * 0.46 / 25);
  CHECK(high < 1 + 5 * 0.46 / 25);
}

TEST_CASE("Points of a large sweep that cannot be read cost nothing, and points without cost are cut by number") {
  const RunPlan half = run_of("c = { from = -1, to = 0, count = 2 }\na = { from = 1, to = 10000, count = 10000 }\n");
  const std::vector<checkpoint::PointRange> ranges = PointCosts(half).ranges(2);  // a is the slower key
  CHECK(ranges[0].end == Approx(20'000 / std::sqrt(2.0)).epsilon(0.01));
  const RunPlan none = run_of("a = { from = 0, to = 0.5, count = 20000 }\nb = [0]\n");
  CHECK(PointCosts(none).ranges(4) ==
        std::vector<checkpoint::PointRange>{{0, 5000, 1}, {5000, 10'000, 1}, {10'000, 15'000, 1}, {15'000, 20'000, 1}});
}
