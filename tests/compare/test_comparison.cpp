#include "base/units.h"
#include "compare/comparison.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>

#include <catch2/catch.hpp>

#include "normal_draws.h"

using namespace surveymc;
using namespace surveymc::compare;

namespace {
stats::Moments normal_moments(int n, double sd) {
  return stats::Moments::of(sd * test::normal_draws(random::Stream(5, 9), 0, n, 1));
}
}  // namespace

TEST_CASE("Verdicts: equivalence inside the margin, difference outside, otherwise undecided") {
  CHECK(judge({0.99, 1.01}, 0.02, 1000).word == "agrees");
  CHECK(judge({0.98, 1.02}, 0.02, 1000).word == "agrees");
  CHECK(judge({1.021, 1.05}, 0.02, 1000).word == "differs");
  CHECK(judge({0.5, 0.979}, 0.02, 1000).word == "differs");
  CHECK(judge({0.97, 1.01}, 0.02, 1000).word == "undecided");
  CHECK(judge({0.9, 1.1}, 0.02, 1000).word == "undecided");
  CHECK(judge({kNaN, 1}, 0.02, 1000).word.empty());
  // Half width 0.1 about 1 has to shrink to 0.02: 25 times the trials, and a tenth for luck.
  CHECK(judge({0.9, 1.1}, 0.02, 1000).trials_to_decide == Approx(27500).margin(1));
}

TEST_CASE("A predicted sd is judged by its ratio to the Monte-Carlo one") {
  const stats::Moments m = normal_moments(50000, 3.0);
  const ComparisonRow good = compare_sd("sigma3_x", "m", 3, m, 0, 3.0, {0.02, 0.95}, 50000);
  CHECK(good.verdict == "agrees");
  CHECK(good.analytic == 9.0);
  CHECK(good.monte_carlo == Approx(9).epsilon(0.02));
  CHECK(good.interval.lo < good.monte_carlo);
  CHECK(good.ratio == Approx(good.analytic / good.monte_carlo).epsilon(1e-15));
  CHECK(good.ratio_interval.lo < good.ratio);
  CHECK(good.ratio_interval.hi > good.ratio);
  CHECK(compare_sd("x", "m", 1, m, 0, 3.3, {0.02, 0.95}, 50000).verdict == "differs");
  CHECK(compare_sd("x", "m", 1, m, 0, 3.06, {0.02, 0.95}, 50000).verdict == "undecided");
  CHECK(compare_sd("x", "m", 1, stats::Moments(1), 0, 3.0, {}, 0).verdict.empty());
}

TEST_CASE("A root mean square is judged by its ratio to the predicted one") {
  // Squares with mean 9 and sd 3 over 10,000 trials: RMS 3, its interval half of 0.0196 / 3 wide on either side,
  // relatively
  const Estimate found = rms_estimate(9, 9, 10000, 0.95);
  CHECK(found.value == 3);
  CHECK(found.interval.lo == Approx(std::sqrt(9 - stats::normal_quantile(0.975) * 0.03)).epsilon(2e-5));
  CHECK(found.interval.hi == Approx(std::sqrt(9 + stats::normal_quantile(0.975) * 0.03)).epsilon(2e-5));
  const ComparisonRow row = compare_value("rms", "m", found, 3.01, {}, 10000);
  CHECK(row.verdict == "agrees");
  CHECK(row.ratio == 3.01 / 3);
  CHECK(compare_value("rms", "m", found, 4, {}, 10000).verdict == "differs");
  CHECK(compare_value("rms", "m", found, kNaN, {}, 10000).verdict.empty());
  const ComparisonRow wide = compare_value("rms", "m", rms_estimate(1, 100, 10, 0.95), 1, {}, 10);
  CHECK(wide.interval.lo > 0);  // a mean of squares of which one is not 0
  CHECK(wide.interval.hi > 1e3);
  CHECK(wide.verdict == "undecided");
  CHECK(std::isnan(rms_estimate(9, 9, 1, 0.95).value));
}

TEST_CASE("A value whose interval begins at 0 is judged by the other end") {
  // Found between 0 and 0.5: any ratio of the prediction to it from 2 on is possible.
  const ComparisonRow far = compare_value("x", "m", {0.2, {0, 0.5}}, 1, {0.02, 0.95}, 100);
  CHECK(far.verdict == "differs");
  CHECK(far.evidence.p_differs < 0.05);
  CHECK(far.evidence.p_agrees == 1);
  const ComparisonRow near = compare_value("x", "m", {0.2, {0, 0.5}}, 0.4, {0.02, 0.95}, 100);
  CHECK(near.verdict == "undecided");
  CHECK(near.evidence.p_differs > 0.05);
  CHECK(near.trials_to_decide == 0);  // the half width is not known
  CHECK(compare_value("x", "m", {0.2, {0, kInfinity}}, 1, {0.02, 0.95}, 100).verdict.empty());  // no bound at all
  CHECK(compare_value("x", "m", {0.2, {0, kNaN}}, 1, {0.02, 0.95}, 100).verdict.empty());
}

TEST_CASE("A mean is judged on its shift in standard deviations") {
  const stats::Moments m = normal_moments(50000, 3.0);
  const ComparisonRow good = compare_mean("mean_x", "m", m, 0, 100, 100, {0.02, 0.95}, 50000);
  CHECK(good.verdict == "agrees");
  CHECK(good.monte_carlo == Approx(100).margin(0.06));
  CHECK(std::isnan(good.ratio));
  CHECK(compare_mean("mean_x", "m", m, 0, 100, 100.2, {0.02, 0.95}, 50000).verdict == "differs");  // 0.07 sd
}

TEST_CASE("Only a verdict that is not the expected one is reported") {
  ComparisonRow row = compare_sd("sigma3_x", "m", 3, normal_moments(50000, 3.0), 0, 6.0, {0.02, 0.95}, 50000);
  const auto unexpected = [&](const std::string& expected) {
    row.expected = expected;
    return unexpected_verdicts({comparison_table("position", "", {row}, 50000, 0)});
  };
  CHECK(unexpected("").empty());
  CHECK(unexpected("differs").empty());
  REQUIRE(unexpected("agrees").size() == 1);
  CHECK(unexpected("agrees")[0] == "position sigma3_x: differs, expected agrees");
}

TEST_CASE("How well published standard deviations fit: once for each quantity, means left out") {
  const auto row = [](const std::string& formulation, const std::string& quantity, double monte_carlo, double ratio,
                      double published) {
    ComparisonRow r = empty_row(formulation, quantity, "m");
    r.monte_carlo = monte_carlo;
    r.ratio = ratio;
    r.published = published;
    return r;
  };
  const double none = kNaN;
  const store::Table t = published_fit_table(
      {row("", "mean_x", 5, none, 7), row("first_order", "sigma3_x", 2, 1, 4), row("claimed", "sigma3_x", 2, 1, 4),
       row("first_order", "sigma3_y", 2, 1, 1), row("first_order", "sigma3_z", 2, 1, none)});
  CHECK(t.name == "published_fit");
  CHECK(t.number("quantities", 0) == 2);
  CHECK(t.number("rms_log_ratio", 0) == Approx(std::log(2)).epsilon(1e-15));  // ratios 2 and 1/2
  CHECK(t.number("ratio_min", 0) == 0.5);
  CHECK(t.number("ratio_max", 0) == 2);
  const store::Table empty = published_fit_table({row("", "sigma3_x", 2, 1, none), row("", "mean_x", 5, none, 7)});
  CHECK(empty.number("quantities", 0) == 0);
  for (const char* name : {"rms_log_ratio", "ratio_min", "ratio_max"}) CHECK(std::isnan(empty.number(name, 0)));
}

TEST_CASE("A row shows the margin of its verdict, and none without one") {
  const VerdictRule rule{.margin = .07};
  const ComparisonRow judged = compare_rate("rate", 32000, 40000, 0.8, rule, 40000);
  CHECK(judged.margin == .07);
  CHECK(std::isnan(compare_rate("rate", 5, 10, kNaN, rule, 10).margin));
  const store::Table t = comparison_table("t", "", {judged}, 40000, 0);
  const auto column =
      std::find_if(t.columns.begin(), t.columns.end(), [](const store::Column& c) { return c.name == "margin"; });
  REQUIRE(column != t.columns.end());
  CHECK(std::get<std::vector<double>>(column->values) == std::vector<double>{.07});
  CHECK(std::next(column)->name == "verdict");
}

TEST_CASE("A row that is not to be judged keeps nothing of a verdict") {
  ComparisonRow row = compare_rate("rate", 80, 100, 0.8, VerdictRule{}, 100);
  REQUIRE(row.verdict == "undecided");
  REQUIRE(row.trials_to_decide > 0);
  leave_unjudged(row, "a rough prediction");
  const store::Table t = comparison_table("t", "", {row}, 100, 0);
  CHECK(t.word("verdict", 0).empty());
  for (const char* column : {"margin", "p_differs", "p_agrees", "trials_to_decide"})
    CHECK(std::isnan(t.number(column, 0)));
  CHECK(t.number("ratio", 0) == 1);
  CHECK(t.word("note", 0) == "a rough prediction");
}

TEST_CASE("Where too many trials failed nothing is judged, and the row says why") {
  ComparisonRow judged = compare_rate("detection", 800, 1000, 0.8, VerdictRule{}, 1000), empty;
  judged.note = "by its own test";
  std::vector<ComparisonRow> rows{judged, empty};
  rows[0].verdict = "agrees";
  leave_undecided(rows, 10, 1000, 0.01, "adjustments");  // one per cent is allowed
  CHECK(rows[0].verdict == "agrees");
  CHECK(rows[0].note == "by its own test");
  leave_undecided(rows, 11, 1000, 0.01, "adjustments");
  CHECK(rows[0].verdict == "undecided");
  CHECK(rows[0].note == "11 of 1000 adjustments did not converge (more than 1 %); by its own test");
  CHECK(rows[1].verdict.empty());  // there is nothing to judge in it
}

TEST_CASE("Rates are judged by their exact interval") {
  const VerdictRule rule;
  CHECK(compare_rate("rate", 32000, 40000, 0.8, rule, 40000).verdict == "agrees");
  CHECK(compare_rate("rate", 32000, 40000, 0.9, rule, 40000).verdict == "differs");
  CHECK(compare_rate("rate", 80, 100, 0.8, rule, 100).verdict == "undecided");
  const ComparisonRow row = compare_rate("rate", 32000, 40000, 0.8, rule, 40000);
  CHECK(row.monte_carlo == 0.8);
  CHECK(row.ratio_interval.lo == 0.8 / row.interval.hi);
  // An event that was never seen has no ratio; a prediction beyond all that is possible differs all the same
  CHECK(compare_rate("rate", 0, 40000, 0.8, rule, 40000).verdict == "differs");
  CHECK(compare_rate("rate", 0, 40000, 1e-6, rule, 40000).verdict.empty());
  CHECK(compare_rate("rate", 0, 0, 0.8, rule, 40000).note == "no converged trial");
  // What cannot happen: few trials do not show that it does not, many do, and one event shows that it does
  for (const std::uint64_t few : {1, 2, 100}) CHECK(compare_rate("rate", 0, few, 0, rule, few).verdict == "undecided");
  const ComparisonRow never = compare_rate("rate", 0, 400, 0, rule, 400);  // up to 0.0092, the margin is 0.02
  CHECK(never.verdict == "agrees");
  CHECK(never.evidence.p_agrees == Approx(2 * std::pow(0.98, 400)).epsilon(1e-9));
  CHECK(compare_rate("rate", 1, 400, 0, rule, 400).verdict == "differs");
  CHECK(compare_rate("rate", 5, 10, kNaN, rule, 10).verdict.empty());
}

TEST_CASE("An event that was never seen is held against the same edge of the margin as any other") {
  const VerdictRule rule{0.5, 0.95};
  // The rate is 0.003682 at most (97.5 %): a prediction beyond 1.5 times that differs, P(none of 1000 at 0.00631/1.5)
  // is 0.0148.
  const ComparisonRow row = compare_rate("rate", 0, 1000, 0.00631, rule, 1000);
  CHECK(row.verdict == "differs");
  CHECK(row.evidence.p_differs == Approx(2 * std::pow(1 - 0.00631 / 1.5, 1000)).epsilon(1e-9));
  CHECK(compare_rate("rate", 0, 1000, 0.0055, rule, 1000).verdict.empty());
}

TEST_CASE("Rates at all looks have the p-values of their sequence") {
  const VerdictRule rule{.at_all_looks = true};
  // Never seen: the mixture at 0.0043/1.02 and 0 of 4096. One fixed look would say 6e-8.
  const ComparisonRow none = compare_rate("rate", 0, 4096, 0.0043, rule, 4096);
  CHECK(none.verdict == "differs");
  CHECK(none.evidence.p_differs == stats::rate_sequence_p(0, 4096, 0.0043 / 1.02));
  CHECK(none.evidence.p_differs == Approx(0.0103).epsilon(0.01));
  CHECK(none.evidence.p_agrees == 1);
  const ComparisonRow open = compare_rate("rate", 0, 4096, 0.001, rule, 4096);
  CHECK(open.verdict == "undecided");
  CHECK(open.evidence.p_differs > 0.05);
  // Many hits: the verdict of the interval, and no extrapolation of its width.
  const ComparisonRow many = compare_rate("rate", 40, 4096, 0.1, rule, 4096);
  CHECK(many.verdict == "differs");
  CHECK(many.evidence.p_differs < 1e-30);
  const ComparisonRow right = compare_rate("rate", 200'000, 400'000, 0.5, rule, 400'000);
  CHECK(right.verdict == "agrees");
  CHECK(right.evidence.p_differs == 1);
  CHECK(right.evidence.p_agrees < 1e-20);
}

TEST_CASE("A quantile is judged by order statistics") {
  const stats::HistogramBins bins{4096, 4.0 / 4096};
  const auto rayleigh = [&](int n) {
    std::vector<std::uint64_t> counts(bins.bins, 0);
    for (int i = 0; i < n; ++i) ++counts[bins.bin(std::sqrt(-std::log1p(-(i + 0.5) / n)))];
    return counts;
  };
  const VerdictRule rule;
  const double q95 = std::sqrt(-std::log(0.05));
  // Twenty values of which all lie below 1.2 are no proof of a 95 % quantile below 1.73: P(20 of 20 below) is 0.36.
  std::vector<std::uint64_t> few(bins.bins, 0);
  few[bins.bin(1.19)] = 20;
  const ComparisonRow open = compare_quantile("q", "1", bins, few.data(), 0.95, q95, rule, 20);
  CHECK(open.interval.hi == kInfinity);
  CHECK(open.verdict == "undecided");
  CHECK(open.evidence.p_differs == Approx(2 * std::pow(0.95, 20)).epsilon(1e-9));
  // Interval and p-value say the same at the margin: a prediction just beyond the bound, and just before it.
  const std::vector<std::uint64_t> many = rayleigh(40'000);
  const ComparisonRow found = compare_quantile("q", "1", bins, many.data(), 0.95, q95, rule, 40'000);
  CHECK(found.verdict == "agrees");
  CHECK(found.evidence.p_agrees < 0.05);
  for (const auto& [factor, verdict] : {std::pair(1.0001, "differs"), {0.9999, "undecided"}}) {
    const ComparisonRow row =
        compare_quantile("q", "1", bins, many.data(), 0.95, found.interval.hi * 1.02 * factor, rule, 40'000);
    CHECK(row.verdict == verdict);
    CHECK((row.evidence.p_differs < 0.05) == (row.verdict == "differs"));
    CHECK(row.evidence.p_differs == Approx(0.05).epsilon(0.15));
  }
  VerdictRule looks = rule;
  looks.at_all_looks = true;
  CHECK(compare_quantile("q", "1", bins, many.data(), 0.95, 1.5 * q95, looks, 40'000).evidence.p_differs < 1e-20);
  CHECK(std::isnan(compare_quantile("q", "1", bins, rayleigh(0).data(), 0.95, q95, rule, 0).interval.hi));
}

TEST_CASE("A predicted probability stays within [0, 1]") {
  const VerdictRule rule;
  CHECK(compare_rate("rate", 10, 10, 1 + 1e-15, rule, 10).analytic == 1);
  CHECK(compare_rate("rate", 0, 10, -1e-17, rule, 10).analytic == 0);
  CHECK(compare_rate("rate", 5, 10, 0.25, rule, 10).analytic == 0.25);
  CHECK(std::isnan(compare_rate("rate", 5, 10, std::nan(""), rule, 10).analytic));
}
