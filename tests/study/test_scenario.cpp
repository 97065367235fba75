#include "study/scenario.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "config_text.h"
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
  Read r;
  r.verdict.confidence = 0.95;
  const std::vector<RowName> judged{
      {"position", "joint", "sigma3_east"}, {"position", "random", "sigma3_east"}, {"parameters", "", "mean_bias_x"}};
  r.plan = test::read_config("seed = 1\n" + body, [&](config::ConfigReader& c) {
    return read_trial_plan(c, {"sigma3_north", "sigma3_east"}, judged, r.verdict);
  });
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

TEST_CASE("[survey.plan] is vertical, then built, then held to the bottom") {
  const auto planned = [](const std::string& more, bool needs_toolface = false) {
    return test::read_config("[survey.plan]\nkickoff_m = 100\ninclination_deg = 20\nazimuth_deg = 90\n" + more,
                             [&](config::ConfigReader& c) {
                               survey::Survey s = read_survey(c, {}, needs_toolface);
                               CHECK(read_true_vertical_depths(c, s).size() == s.stations.size());
                               return s;
                             });
  };
  const survey::Survey s = planned("md_m = 250\nspacing_m = 60\nbuild_deg_per_30m = 6");
  REQUIRE(s.size() == 6);
  CHECK(s.stations[5].md == 250);
  CHECK(s.stations[4].md == 240);
  CHECK(s.stations[1].inclination == 0);
  CHECK_THAT(s.stations[2].inclination, Catch::WithinRel(4 * kDegree, 1e-14));  // 20 m of .2 deg/m
  CHECK_THAT(s.stations[3].inclination, Catch::WithinRel(16 * kDegree, 1e-14));
  CHECK_THAT(s.stations[5].inclination, Catch::WithinRel(20 * kDegree, 1e-14));
  CHECK_THAT(s.stations[0].azimuth, Catch::WithinRel(90 * kDegree, 1e-14));
  CHECK(planned("md_m = 240\nspacing_m = 60").size() == 5);
  CHECK_THROWS_WITH(planned("md_m = 240", true), Contains("has no toolfaces, which this study needs"));
  CHECK_THROWS_WITH(planned("md_m = 240\nspacing_m = 900\nbuild_deg_per_30m = 6"), Contains("more than 90 deg"));
  CHECK_THROWS_WITH(planned("md_m = 1e9"), Contains("more than 100000 stations"));
}

namespace {
sensor::NoiseModel noise_of(const std::string& reference) {
  return test::read_config("seed = 1\n[noise]\nmagnetometer_nT = 50.0\nreference = " + reference,
                           [](config::ConfigReader& c) { return read_noise(c); });
}
}  // namespace

TEST_CASE("Sizes of the reference's noise need a word on when it is drawn") {
  const std::string rule =
      ": noise.reference.per is missing, which says when it is drawn: \"run\", \"station\", or \"none\" for never";
  CHECK_THROWS_WITH(noise_of("{ total_nT = 130.0, dip_deg = 0.2 }"), "t.toml:5: noise.reference.total_nT = 130" + rule);
  CHECK_THROWS_WITH(noise_of("{ dip_deg = 0.2 }"), "t.toml:5: noise.reference.dip_deg = 0.2" + rule);
  CHECK(noise_of("{ total_nT = 0.0 }").reference == sensor::ReferenceNoise::none);
  CHECK(noise_of("{ per = 'none', total_nT = 130.0, dip_deg = 0.2 }").reference_total == 0);
  CHECK(noise_of("{ per = 'run', total_nT = 130.0 }").reference_total == 130);
  CHECK(noise_of("'wmm2025'").reference_total > 0);
}
