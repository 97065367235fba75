#include <catch2/catch.hpp>

#include <cmath>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "base/units.h"
#include "compare/claims.h"
#include "compare/comparison.h"
#include "compare/family.h"
#include "project_files.h"
#include "render/csv.h"
#include "store/row_spool.h"

using namespace surveymc;
using namespace surveymc::compare;

namespace {

using Words = std::vector<std::string>;

/// A row whose ratio is `ratio` with half width `half` of the logarithm at 95 %.
ComparisonRow row_of(double ratio, double half, const std::string& expected = "") {
  const VerdictRule rule;
  const Estimate found{1 / ratio, {std::exp(-half) / ratio, std::exp(half) / ratio}};
  ComparisonRow row = compare_value("q", "m", found, 1, rule, 40'000);
  row.expected = expected;
  return row;
}

Words family_of(const store::Table& t) { return std::get<Words>(t.column("family").values); }

}  // namespace

TEST_CASE("The p-values of a row stand on the side of its verdict") {
  constexpr double kQuantile = 1.959964;
  // 3 standard errors beyond the upper edge of the margin: P(|N| > 3) = 0.0026998.
  const double se = 0.01, half = kQuantile * se;
  const ComparisonRow beyond = row_of(1.02 * std::exp(3 * se), half);
  CHECK(beyond.verdict == "differs");
  CHECK(beyond.evidence.p_differs == Approx(0.0026998).epsilon(1e-4));
  CHECK(beyond.evidence.p_agrees == 1);
  const ComparisonRow below = row_of(0.98 * std::exp(-3 * se), half);
  CHECK(below.evidence.p_differs == Approx(0.0026998).epsilon(1e-4));
  // Just at the level of its interval.
  CHECK(row_of(1.02 * std::exp(1.000001 * half), half).verdict == "differs");
  CHECK(row_of(1.02 * std::exp(1.000001 * half), half).evidence.p_differs == Approx(0.05).epsilon(1e-4));
  const ComparisonRow narrow = row_of(1, 0.001 * kQuantile);
  CHECK(narrow.verdict == "agrees");
  CHECK(narrow.evidence.p_differs == 1);
  CHECK(narrow.evidence.p_agrees < 1e-50);
  // The nearer edge decides: two standard errors away, P(|N| > 2) = 0.0455003.
  CHECK(row_of(1.02 * std::exp(-2 * se), half).evidence.p_agrees == Approx(0.0455003).epsilon(1e-5));
  CHECK(row_of(1.02 * std::exp(-0.002), 0.001 * kQuantile).evidence.p_agrees == Approx(0.0455).epsilon(1e-3));
}

TEST_CASE("The evidence of a rate is exact, and agrees with its interval") {
  const VerdictRule rule{0.02, 0.95};
  // 40 of 1000 against 0.02: P(X >= 40), X binomial(1000, 0.02 / 0.98), twice.
  const ComparisonRow row = compare_rate("p", 40, 1000, 0.02, rule, 1000);
  CHECK(row.verdict == "differs");
  CHECK(row.evidence.p_differs == Approx(1.2e-4).epsilon(0.2));
  CHECK(row.evidence.p_agrees == Approx(1).epsilon(1e-3));
  const ComparisonRow none = compare_rate("p", 0, 1000, 0.02, rule, 1000);
  CHECK(none.verdict == "differs");
  CHECK(none.evidence.p_differs == Approx(2 * std::pow(1 - 0.02 / 1.02, 1000)).epsilon(1e-9));
}

// The report judges many files as one family, by the same procedures in Python: both are held to one table of cases
// (tests/report/test_reader.py reads it, too). Of {0.03, 0.01, 0.016, 0.9}: 0.01 < 0.05/4, 0.016 < 0.05/3, 0.03 >
// 0.05/2.
TEST_CASE("Holm and the share of wrong agreements give what the table of cases says") {
  std::istringstream lines(test::project_file("tests/compare/family_cases.csv"));
  std::string line;
  std::getline(lines, line);
  REQUIRE(line == "procedure,level,p,expected");
  const auto numbers = [](const std::string& cell) {
    std::istringstream in(cell);
    return std::vector<double>(std::istream_iterator<double>(in), {});
  };
  int cases = 0;
  for (; std::getline(lines, line); ++cases) {
    CAPTURE(line);
    std::istringstream cells(line);
    std::string procedure, level, p, expected;
    std::getline(cells, procedure, ','), std::getline(cells, level, ','), std::getline(cells, p, ',');
    std::getline(cells, expected);
    const std::vector<double> wanted = numbers(expected);
    if (procedure == "holm") {
      const std::vector<bool> rejected = holm(numbers(p), std::stod(level));
      CHECK(std::vector<double>(rejected.begin(), rejected.end()) == wanted);
    } else {
      REQUIRE(procedure == "agreement_share");
      CHECK(benjamini_hochberg_share(numbers(p), std::stod(level)) == Approx(wanted.at(0)).epsilon(1e-12));
    }
  }
  CHECK(cases == 11);
}

TEST_CASE("A family of a file marks what may be chance, and leaves out rows that are expected to differ") {
  // 60 rows; one differs by a little, one by much, one is expected to differ.
  std::vector<ComparisonRow> rows(57, row_of(1.001, 0.002));
  rows.push_back(row_of(1.06, 0.03));
  rows.push_back(row_of(1.2, 0.03));
  rows.push_back(row_of(1.2, 0.03, "differs"));
  std::vector<store::Table> tables{comparison_table("a", "", rows, 40'000, 0),
                                   comparison_table("b", "", {row_of(1.0, 0.05)}, 40'000, 0),
                                   {"other", "", {{"x", "1", "", std::vector<double>{1}}}}};
  apply_family(tables);
  const Words family = family_of(tables[0]);
  CHECK(family[57] == kMayBeChance);
  CHECK(family[58] == kDiffersInFamily);
  CHECK(family[59].empty());
  CHECK(family[0].empty());
  REQUIRE(tables.back().name == "family");
  CHECK(tables.back().number("verdicts", 0) == 60);  // 59 of the first table and one of the second
  CHECK(tables.back().number("agrees", 0) == 57);
  CHECK(tables.back().number("differs", 0) == 2);
  CHECK(tables.back().number("undecided", 0) == 1);
  CHECK(tables.back().number("differs_holm", 0) == 1);
  CHECK(tables.back().number("agrees_q", 0) < 1e-9);
}

TEST_CASE("A row without p_agrees says nothing of the share of wrong agreements") {
  // Three agree at p = 0.01, and so does a fourth, by a test without a margin.
  std::vector<ComparisonRow> rows(4, row_of(1.001, 0.002));
  for (ComparisonRow& row : rows) row.evidence = {1, 0.01};
  rows.back().evidence.p_agrees = kNaN;
  std::vector<store::Table> tables{comparison_table("a", "", rows, 40'000, 0)},
      alone{comparison_table("a", "", {rows.back()}, 40'000, 0)};
  apply_family(tables);
  CHECK(tables.back().number("verdicts", 0) == 4);
  CHECK(tables.back().number("agrees", 0) == 4);
  CHECK(tables.back().number("tests", 0) == 0);
  CHECK(tables.back().number("agrees_q", 0) == Approx(0.01).epsilon(1e-12));
  apply_family(alone);
  CHECK(alone.back().number("agrees", 0) == 1);
  CHECK(std::isnan(alone.back().number("agrees_q", 0)));
}

TEST_CASE("Wishart tests join the family with their own p, unless they are expected to differ") {
  const std::vector<double> p{0.4, kNaN, 1e-6, 0.03, 1e-9};
  const store::Table tests{"ellipse",
                           "",
                           {{"wishart_p", "1", "", p},
                            {"expected", "", "", Words{"", "", "", "", "differs"}},
                            {"wishart_family", "", "", Words(5)}}};
  std::vector<store::Table> tables{comparison_table("a", "", {row_of(1.0, 0.005)}, 40'000, 0), tests};
  apply_family(tables);
  CHECK(std::get<Words>(tables[1].column("wishart_family").values) ==
        Words{"", "", kDiffersInFamily, kMayBeChance, ""});  // 0.03 is above 0.05 / 3
  CHECK(tables.back().number("verdicts", 0) == 1);
  CHECK(tables.back().number("tests", 0) == 3);
  CHECK(tables.back().number("tests_holm", 0) == 1);
  CHECK(tables.back().number("differs_holm", 0) == 0);
}

TEST_CASE("A claim has p-values on the side of its verdict") {
  constexpr double kQuantile = 1.959964;
  const auto of = [&](double value, double bound, bool below, bool logarithmic) {
    const stats::Interval i =
        logarithmic ? stats::Interval{value * std::exp(-kQuantile * 0.1), value * std::exp(kQuantile * 0.1)}
                    : stats::Interval{value - kQuantile * 0.1, value + kQuantile * 0.1};
    return claim_evidence(value, i, bound, below, 0.95, logarithmic);
  };
  // Three standard errors above the bound: P(|N| > 3) = 0.0026998 against "below", and for "above".
  for (const bool below : {true, false}) {
    const Evidence e = of(1.3, 1, below, false);
    CHECK((below ? e.p_differs : e.p_agrees) == Approx(0.0026998).epsilon(1e-4));
    CHECK((below ? e.p_agrees : e.p_differs) == 1);
  }
  CHECK(of(std::exp(-0.2), 1, true, true).p_agrees == Approx(0.0455003).epsilon(1e-4));
  CHECK(std::isnan(claim_evidence(1, {kNaN, kNaN}, 1, true, 0.95, false).p_differs));
}

TEST_CASE("The mean of few realisations has the interval and the p-values of Student's t") {
  const std::vector<double> x{0.2, 0.5, 0.8};  // mean 0.5, standard error 0.3 / sqrt(3)
  const ComparisonRow row = mean_row("", "x", "1", x, 0.95);
  constexpr double kT = 4.302652729911275;  // 97.5 % of t with two degrees of freedom
  const double se = 0.3 / std::sqrt(3.0);
  CHECK(row.monte_carlo == Approx(0.5).epsilon(1e-12));
  CHECK(row.interval.hi - row.monte_carlo == Approx(kT * se).epsilon(1e-9));
  CHECK(row.monte_carlo - row.interval.lo == Approx(kT * se).epsilon(1e-9));
  // 1 lies 2.9 standard errors above: beyond a normal interval, and within this one.
  const ComparisonRow claim = judge_mean_claim("", "x", x, 1, true, 0.95, "below 1");
  CHECK(claim.verdict == "undecided");
  // P(|T| > t) with two degrees of freedom is 1 - t / sqrt(2 + t^2).
  const double t = 0.5 / se;
  CHECK(claim.evidence.p_agrees == Approx(1 - t / std::sqrt(2 + t * t)).epsilon(1e-9));
  CHECK(claim.evidence.p_differs == 1);
  // One value, or equal ones, do not show how much they scatter: no interval, no verdict.
  for (const std::vector<double>& alike : {std::vector<double>{0.5}, {0.5, 0.5}, {0.5, 0.5, 0.5}}) {
    const ComparisonRow none = judge_mean_claim("", "x", alike, 1, true, 0.95, "below 1");
    CHECK(none.monte_carlo == 0.5);
    CHECK(std::isnan(none.interval.lo));
    CHECK(none.verdict.empty());
    CHECK(std::isnan(none.evidence.p_agrees));
    CHECK(none.note == "below 1; no interval, no verdict: one realisation, or all alike");
  }
  // At the edge of the interval the p-value is that of its confidence.
  CHECK(judge_mean_claim("", "x", x, row.interval.hi, true, 0.95, "").evidence.p_agrees == Approx(0.05).epsilon(1e-9));
}

TEST_CASE("A family takes in rows that wait on the disk") {
  std::vector<ComparisonRow> rows(40, row_of(1.001, 0.002));
  rows.push_back(row_of(1.06, 0.03));
  rows.push_back(row_of(1.2, 0.03));
  std::vector<store::Table> held{comparison_table("a", "", rows, 40'000, 0)}, moved = held;
  store::move_to_disk(moved[0]);
  store::append_rows(moved[0], comparison_table("a", "", {row_of(1.2, 0.03)}, 40'000, 0));
  store::append_rows(held[0], comparison_table("a", "", {row_of(1.2, 0.03)}, 40'000, 0));
  apply_family(held);
  apply_family(moved);
  CHECK(render::to_csv(moved[0]) == render::to_csv(held[0]));
  CHECK(render::to_csv(moved[1]) == render::to_csv(held[1]));
  CHECK(family_of(held[0]).back() == kDiffersInFamily);
}

TEST_CASE("A check forgives a row that differs by chance, but neither a missing difference nor an open question") {
  std::vector<ComparisonRow> rows(20, row_of(1.001, 0.002, "agrees"));
  rows.push_back(row_of(1.055, 0.03, "agrees"));  // p 0.02: does not survive among 22
  rows.push_back(row_of(1.0, 0.05, "agrees"));
  rows.push_back(row_of(1.0, 0.002, "differs"));
  std::vector<store::Table> tables{comparison_table("a", "", rows, 40'000, 0)};
  CHECK(unexpected_verdicts(tables).size() == 3);
  apply_family(tables);
  const std::vector<std::string> unexpected = unexpected_verdicts(tables);
  REQUIRE(unexpected.size() == 2);
  CHECK(unexpected[0].find("undecided, expected agrees") != std::string::npos);
  CHECK(unexpected[1].find("agrees, expected differs") != std::string::npos);
}

TEST_CASE("Without rows that have a verdict there is no family") {
  std::vector<store::Table> tables{{"other", "", {{"x", "1", "", std::vector<double>{1}}}}};
  apply_family(tables);
  CHECK(tables.size() == 1);
}
