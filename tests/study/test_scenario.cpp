#include "study/scenario.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "montecarlo/run_blocks.h"

using namespace surveymc;
using namespace surveymc::study;
using Catch::Matchers::Contains;

namespace {
struct Read {
  TrialPlan plan;
  VerdictRule verdict;
};
Read read(const std::string& body) {
  config::Config config = config::Config::from_text("experiment = 'e'\nseed = 1\n" + body, "t.toml", {});
  config::ConfigReader reader = config.reader(0);
  Read r;
  r.verdict.confidence = 0.95;
  r.plan = read_trial_plan(reader, {"sigma3_north", "sigma3_east"}, r.verdict);
  reader.finish();
  return r;
}
}  // namespace

TEST_CASE("A fixed number of trials has no looks and leaves the confidence alone") {
  const Read r = read("trials = 20000");
  CHECK(r.plan.trials == 20000);
  CHECK(r.plan.looks.empty());
  CHECK(r.verdict.confidence == 0.95);
}

TEST_CASE("A stopping rule looks at whole blocks, rising to max_trials, and shares its error among the looks") {
  const Read r = read("[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_east']\nmax_trials = 100000");
  REQUIRE(r.plan.looks.size() == 9);  // 4096 times 1, 1.5, ... 1.5^7, and the last
  CHECK(r.plan.looks.front() == 4096);
  CHECK(r.plan.looks.back() == 100000);
  for (std::size_t i = 0; i + 1 < r.plan.looks.size(); ++i) {
    CHECK(r.plan.looks[i] % montecarlo::kBlockTrials == 0);
    CHECK(r.plan.looks[i] < r.plan.looks[i + 1]);
  }
  CHECK(r.verdict.confidence == Approx(1 - 0.05 / 9).epsilon(1e-15));
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
