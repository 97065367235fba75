#include "compare/trial_plan.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "config_text.h"
#include "montecarlo/run_blocks.h"

using namespace surveymc;
using namespace surveymc::compare;
using Catch::Matchers::Contains;

namespace {
struct Read {
  TrialPlan plan;
  VerdictRule verdict;
};
Read read(const std::string& body) {
  Read r;
  r.verdict.confidence = 0.95;
  const std::vector<Row> rows{
      {.table = "position", .quantity = "sigma3_north", .predicted = false, .controlled = true},
      {.table = "position", .formulation = "joint", .quantity = "sigma3_east", .controlled = true},
      {.table = "position", .formulation = "random", .quantity = "sigma3_east", .controlled = true},
      {.table = "position", .formulation = "random", .quantity = "sigma3_up", .controlled = true, .available = false},
      {.table = "parameters", .quantity = "mean_bias_x"}};
  r.plan = test::read_config("seed = 1\n" + body,
                             [&](config::ConfigReader& c) { return read_trial_plan(c, rows, r.verdict); });
  return r;
}
}  // namespace

TEST_CASE("A fixed number of trials has no looks and leaves the confidence alone") {
  const Read r = read("trials = 20000");
  CHECK(r.plan.trials == 20000);
  CHECK(r.plan.looks.empty());
  CHECK(r.verdict.confidence == 0.95);
}

TEST_CASE("A stop by precision looks at whole blocks, 1.1 times apart, at the confidence of a fixed run") {
  const Read r = read("[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_east']\nmax_trials = 100000");
  CHECK(r.plan.looks.front() == 4096);
  CHECK(r.plan.looks.back() == 100000);
  for (std::size_t i = 0; i + 1 < r.plan.looks.size(); ++i) {
    CHECK(r.plan.looks[i] % montecarlo::kBlockTrials == 0);
    CHECK(r.plan.looks[i] < r.plan.looks[i + 1]);
    CHECK(10 * r.plan.looks[i + 1] <= 11 * (r.plan.looks[i] + montecarlo::kBlockTrials));
  }
  CHECK(r.verdict.confidence == 0.95);
  CHECK_FALSE(r.verdict.at_all_looks);
}

TEST_CASE("With correction = bonferroni the looks are 1.5 times apart and share the error") {
  const Read r =
      read("[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_east']\nmax_trials = 100000\ncorrection = 'bonferroni'");
  REQUIRE(r.plan.looks.size() == 9);  // 4096 times 1, 1.5, ... 1.5^7, and the last
  CHECK(r.plan.looks[1] == 6144);
  CHECK(r.verdict.confidence == Approx(1 - 0.05 / 9).epsilon(1e-15));
}

TEST_CASE("A stop by verdict names rows, of one formulation or of all, and takes confidence sequences") {
  const Read r =
      read("[stop]\nverdict = ['position.sigma3_east.joint', 'parameters.mean_bias_x']\nmax_trials = 100000");
  REQUIRE(r.plan.decisive.size() == 2);
  CHECK(r.plan.decisive[0].formulation == "joint");
  CHECK(r.plan.looks[1] == 4608);
  CHECK(r.verdict.at_all_looks);
  CHECK(r.verdict.confidence == 0.95);
  CHECK(r.verdict.interval_confidence(40'960) > 0.997);
  CHECK(read("[stop]\nverdict = ['position.sigma3_east']\nmax_trials = 100000").plan.decisive.size() == 2);
  CHECK_THROWS_WITH(read("[stop]\nverdict = ['position.sigma3_up']\nmax_trials = 100000"),
                    Contains("t.toml:4: stop.verdict") && Contains("must be of position.sigma3_east.joint"));
  CHECK_THROWS_WITH(read("[stop]\nverdict = ['position.sigma3_east']\nrelative_ci = 0.01\nmax_trials = 100000"),
                    Contains("stop.relative_ci") && Contains("not together with stop.verdict"));
  CHECK_THROWS_AS(read("[stop]\nverdict = ['position.sigma3_east']\nmax_trials = 100"), InputError);
}

TEST_CASE("A bad stopping rule is refused with place, value and rule") {
  CHECK_THROWS_WITH(read("trials = 5\n[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_east']\nmax_trials = 100000"),
                    Contains("t.toml:3: trials = 5: not together with [stop]"));
  CHECK_THROWS_WITH(read("[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_up']\nmax_trials = 100000"),
                    Contains("stop.quantities") && Contains("\"sigma3_up\" is none of sigma3_north, sigma3_east"));
  CHECK_THROWS_AS(read("[stop]\nrelative_ci = 1.5\nquantities = ['sigma3_east']\nmax_trials = 100000"), InputError);
  CHECK_THROWS_AS(read("[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_east']\nmax_trials = 100"), InputError);
  CHECK_THROWS_AS(read("[stop]\nrelative_ci = 0.01\nmax_trials = 100000"), InputError);
  CHECK_THROWS_AS(read("trials = 1"), InputError);
}
