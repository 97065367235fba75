/// surveymc diff: what differs beyond chance between two results.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "compare/comparison.h"
#include "compare/family.h"
#include "stats/intervals.h"
#include "sweep/difference.h"

using namespace surveymc;
using namespace surveymc::compare;
using namespace surveymc::sweep;

namespace {

constexpr std::uint64_t kTrials = 40'000;
constexpr int kRows = 58;

/// Standard deviations of `scale` as a run of so many normal trials gives them, and rates.
store::Result drawn_result(std::uint64_t seed, double scale, std::uint64_t trials = kTrials) {
  std::mt19937_64 generator(seed);
  std::vector<ComparisonRow> rows;
  for (int i = 0; i < kRows; ++i) {
    if (i % 4 == 3) {
      std::binomial_distribution<std::uint64_t> hits(trials, 0.001 * (i + 1));
      rows.push_back(compare_rate("rate " + std::to_string(i), hits(generator), trials, 0.001 * (i + 1), {}, trials));
      continue;
    }
    std::chi_squared_distribution<double> squares(static_cast<double>(trials - 1));
    const double variance = squares(generator) / static_cast<double>(trials - 1);
    const stats::Interval ci = stats::sd_interval(variance, trials, 3, 0.95);
    rows.push_back(compare_value("sd " + std::to_string(i), "m",
                                 {scale * std::sqrt(variance), {scale * ci.lo, scale * ci.hi}}, 1, {}, trials));
  }
  return {.provenance = {.experiment = "e", .seed = seed, .trials = trials},
          .tables = {comparison_table("t", "rows, intervals at 95 %", rows, trials, 0)}};
}

DifferenceRow row_named(const Differences& d, const std::string& name, const std::string& column) {
  for (const DifferenceRow& r : d.rows)
    if (r.row == name && r.column == column) return r;
  return {};
}

}  // namespace

TEST_CASE("Keys that differ are those of another value, and those that one config has not") {
  store::Result a, b;
  CHECK(differing_keys(a, b).empty());
  a.provenance.config =
      "seed = 1\ntrials = 10\n[field]\ndip_deg = 60.0\n[[leg]]\nfrom_md_m = 1.0\n[[leg]]\nfrom_md_m = 2.0\n";
  b.provenance.config = "seed = 1\ntrials = 20\n[field]\ndip_deg = 60.0\ntotal_nT = 5e4\n[[leg]]\nfrom_md_m = 1.5\n";
  const store::Table three{"", "", {{"md_m", "m", "", std::vector<double>{1, 2, 3}}}};
  a.inputs = {{"x.csv", "0123456789", three}, {"same.csv", "77", three}};
  b.inputs = {{"x.csv", "9876543210", three}, {"same.csv", "77", three}, {"<shipped>/MWD.toml", "5", three}};
  std::string text;
  for (const KeyDifference& k : differing_keys(a, b)) text += k.key + ": " + k.a + " | " + k.b + "\n";
  CHECK(text ==
        "field.total_nT:  | 50000.0\n"
        "leg[0].from_md_m: 1.0 | 1.5\n"
        "leg[1].from_md_m: 2.0 | \n"
        "rows of x.csv: 3 (01234567) | 3 (98765432)\n"
        "trials: 10 | 20\n");
  CHECK(differing_keys(a, a).empty());
}

TEST_CASE("Fisher's exact test") {
  CHECK_THAT(same_rate_p(1, 10, 11, 14), Catch::WithinRel(0.002759456185220083, 1e-9));  // tables have 0.002759
  CHECK(same_rate_p(5, 10, 5, 10) == 1);
  CHECK_THAT(same_rate_p(0, 4, 4, 4), Catch::WithinRel(2.0 / 70, 1e-9));
  CHECK(same_rate_p(1000, 1'000'000, 1400, 1'000'000) < 1e-10);
}

TEST_CASE("Holm's procedure rejects in order until one p-value is too large") {
  CHECK(holm({0.01, 0.04, 0.03, 0.005, kNaN}, 0.05) == std::vector<bool>{true, false, false, true, false});
  CHECK(holm({0.02, 0.02}, 0.05) == std::vector<bool>{true, true});
  CHECK(holm({0.03, 0.04}, 0.05) == std::vector<bool>{false, false});
}

TEST_CASE("Two seeds of one config differ falsely in no more than 5 % of pairs, and 3 % is found in all", "[long]") {
  constexpr int kPairs = 200;
  int false_alarms = 0, found = 0;
  for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
    const store::Result a = drawn_result(2 * pair, 1);
    false_alarms += compare_results(a, drawn_result(2 * pair + 1, 1), {}).any();
    if (pair < 20) found += compare_results(a, drawn_result(2 * pair + 1, 1.03), {}).any();
  }
  CHECK(false_alarms <= kPairs * 0.05 + 3 * std::sqrt(kPairs * 0.05 * 0.95));
  CHECK(found == 20);
}

TEST_CASE("The course of a run is not compared with that of other draws") {
  const auto with_looks = [](std::uint64_t seed, std::size_t looks) {
    store::Result r = drawn_result(seed, 1);
    r.tables.push_back({"looks", "", {{"quantity", "", "", std::vector<std::string>(looks, "q")}}});
    r.tables.push_back({"outliers", "", {{"trial", "1", "", std::vector<std::int64_t>(looks, 3)}}});
    return r;
  };
  CHECK_FALSE(compare_results(with_looks(1, 4), with_looks(2, 6), {}).any());
  const Differences same = compare_results(with_looks(1, 4), with_looks(1, 6), {});
  CHECK(std::count_if(same.rows.begin(), same.rows.end(), [](const auto& r) { return r.finding == "only in B"; }) == 4);
}

TEST_CASE("What one realisation was judged names no row, and a rate may be there in one result only") {
  const auto alarms = [](std::uint64_t seed, const std::string& judgement, double rate) {
    store::Result r = drawn_result(seed, 1);
    store::Table t{"alarms", ""};
    t.columns = {{"sensor", "", "", std::vector<std::string>{"PT_f"}},
                 {"judgement", "", "", std::vector<std::string>{judgement}},
                 {"rate", "1", "", std::vector<double>{rate}},
                 {"rate_ci_low", "1", "", std::vector<double>{rate / 2}},
                 {"rate_ci_high", "1", "", std::vector<double>{rate}},
                 {"trials", "1", "", std::vector<double>{2000}}};
    t.columns[2].ancillary = "rate_ci_low rate_ci_high";
    r.tables.push_back(t);
    return r;
  };
  CHECK_FALSE(compare_results(alarms(1, "correct", 0.5), alarms(2, "early", 0.5), {}).any());
  const Differences d = compare_results(alarms(1, "correct", kNaN), alarms(2, "correct", 0.5), {});
  CHECK(row_named(d, "PT_f", "rate").finding == "changed");  // it was an error of the binomial interval
}

TEST_CASE("What is detectable is found with probability 0.9", "[long]") {
  constexpr int kPairs = 150;
  const double size =
      row_named(compare_results(drawn_result(0, 1), drawn_result(1, 1), {}), "sd 0", "monte_carlo").detectable;
  CHECK_THAT(size, Catch::WithinRel((3.33 + 1.28) / std::sqrt(1.0 * kTrials), 0.05));  // 58 hypotheses
  int found = 0;
  for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
    store::Result b = drawn_result(2 * pair + 1, 1);
    const store::Result larger = drawn_result(2 * pair + 1, std::exp(size));
    for (store::Column& c : b.tables[0].columns)  // the first row alone is larger
      if (auto* x = std::get_if<std::vector<double>>(&c.values))
        (*x)[0] = std::get<std::vector<double>>(larger.tables[0].column(c.name).values)[0];
    const Differences d = compare_results(drawn_result(2 * pair, 1), b, {});
    found += row_named(d, "sd 0", "monte_carlo").finding == "differs";
  }
  CHECK(std::abs(found - 0.9 * kPairs) < 4 * std::sqrt(0.09 * kPairs));
}

TEST_CASE("The same seed: what differs has changed, and predictions are no matter of chance") {
  const store::Result a = drawn_result(7, 1);
  CHECK_FALSE(compare_results(a, a, {}).any());
  store::Result b = drawn_result(7, 1.0001);  // a thousandth of a standard error
  const Differences common = compare_results(a, b, {});
  CHECK(row_named(common, "sd 4", "monte_carlo").finding == "changed");
  CHECK(row_named(common, "rate 3", "monte_carlo").finding == "equal");
  const DifferenceRule tolerant{.tolerance = 1};
  CHECK(row_named(compare_results(a, b, tolerant), "sd 4", "monte_carlo").finding == "chance");
  // One run holds the other: their difference varies less than that of independent runs.
  const Differences longer = compare_results(a, drawn_result(7, 1, 2 * kTrials), {});
  CHECK_THAT(row_named(longer, "sd 4", "monte_carlo").standard_error,
             Catch::WithinRel(std::sqrt(0.5 / (2.0 * kTrials)), 0.05));
  b = drawn_result(8, 1);
  std::get<std::vector<double>>(b.tables[0].columns[6].values)[5] *= 1 + 1e-9;
  REQUIRE(b.tables[0].columns[6].name == "ratio");
  for (store::Column& c : b.tables[0].columns)
    if (c.name == "analytic") std::get<std::vector<double>>(c.values)[5] *= 1 + 1e-9;
  CHECK(row_named(compare_results(a, b, {}), "sd 5", "analytic").finding == "changed");
}

TEST_CASE("Rows that cannot be compared are named") {
  const store::Result a = drawn_result(1, 1);
  store::Result b = drawn_result(2, 1);
  for (store::Column& c : b.tables[0].columns) {
    if (c.name == "unit") std::get<std::vector<std::string>>(c.values)[0] = "ft";
    if (c.name == "quantity") std::get<std::vector<std::string>>(c.values)[1] = "another";
  }
  const Differences d = compare_results(a, b, {});
  std::map<std::string, int> findings;
  for (const DifferenceRow& r : d.rows) ++findings[r.finding];
  CHECK(findings["other unit"] == 1);
  CHECK(findings["only in A"] == 1);
  CHECK(findings["only in B"] == 1);
  CHECK(compare_results(drawn_result(1, 1, 500), drawn_result(2, 1, 500), {}).judged == 0);  // too few trials
  b.provenance.experiment = "another";
  CHECK_THROWS_AS(compare_results(a, b, {}), InputError);
}
