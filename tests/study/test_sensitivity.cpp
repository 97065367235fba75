/// [sensitivity]: which keys of a sweep explain a quantity.
#include <cmath>

#include <catch2/catch.hpp>

#include "config/config.h"
#include "message_of.h"
#include "random/design_points.h"
#include "study/sensitivity.h"

using namespace surveymc;
using namespace surveymc::study;

namespace {

/// value = exp(2 a + tool x b): a alone .. tool and b only together.
std::vector<store::Table> sampled(std::size_t points) {
  std::vector<double> a, b, c, value;
  std::vector<std::string> tool, row;
  for (std::size_t i = 0; i < points; ++i) {
    a.push_back(random::latin_hypercube(i, points, 0, 7) - 0.5);
    b.push_back(random::latin_hypercube(i, points, 1, 7) - 0.5);
    c.push_back(random::latin_hypercube(i, points, 2, 7));
    const bool is_x = random::latin_hypercube(i, points, 3, 7) < 0.5;
    tool.push_back(is_x ? "x" : "y");
    value.push_back(std::exp(-2 * a.back() + 2 * (is_x ? b.back() : -b.back())));
    row.push_back("last");
  }
  return {{"t",
           "",
           {{"a", "1", "sweep key", a},
            {"b", "1", "sweep key", b},
            {"c", "1", "sweep key", c},
            {"tool", "", "sweep key", tool},
            {"row", "", "", row},
            {"value", "1", "", value}}}};
}

struct Found {
  double share, low, high, trend;
};

Found found(const store::Table& t, const std::string& order, const std::string& input) {
  for (std::size_t i = 0; i < t.rows(); ++i)
    if (t.word("order", i) == order && t.word("input", i) == input)
      return {t.number("share", i), t.number("share_ci_low", i), t.number("share_ci_high", i), t.number("trend", i)};
  FAIL("no row " + order + " " + input);
  return {};
}

config::SensitivityRule rule() { return {{{"t", "value"}}, {{"row", "last"}}, true, 0.95}; }

}  // namespace

TEST_CASE("A sensitivity table finds what a key explains alone, and what two explain only together") {
  const store::Table t = sensitivity_table(rule(), sampled(3000), 3000);
  // ln value = -2 a +- 2 b: half of the variance is of a, half of the pair of b and tool
  const Found a = found(t, "first", "a"), b = found(t, "first", "b"), pair = found(t, "pair", "b x tool"),
              c = found(t, "with pairs", "c"), with_pairs = found(t, "with pairs", "tool"), rest = found(t, "rest", "");
  CHECK(a.low < 0.5);
  CHECK(a.high > 0.5 * (1 - 1.0 / (14 * 14)));  // groups of a fourteenth leave that out
  CHECK(a.trend < -0.5);
  CHECK(b.low == 0);
  CHECK(pair.low < 0.5);
  CHECK(pair.high > 0.5 * (1 - 1.0 / (13 * 13)));
  CHECK(c.low == 0);
  CHECK(with_pairs.share > 0.45);
  CHECK(std::isnan(with_pairs.trend));
  CHECK(rest.low <= 0);  // the estimate itself may be below
  CHECK(a.high - a.low < 0.1);
  const auto& first = std::get<std::vector<std::string>>(t.column("input").values);
  CHECK(first.front() == "a");  // by falling share
  CHECK(t.rows() == 4 + 4 + 6 + 1);
}

TEST_CASE("Of a whole product a sensitivity table has the shares of its points") {
  std::vector<double> a, b, value;
  std::vector<std::string> tool, row(24, "last");
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 2; ++k)
      for (const char* word : {"x", "y"}) {
        a.push_back(10 * i);
        b.push_back(60 + 4 * k);
        tool.push_back(word);
        value.push_back(i + 0.5 * k + (*word == 'x' ? 0.25 : 0) * k);
      }
  std::vector<store::Table> tables{{"t",
                                    "",
                                    {{"a", "1", "sweep key", a},
                                     {"b", "1", "sweep key", b},
                                     {"tool", "", "sweep key", tool},
                                     {"row", "", "", row},
                                     {"value", "1", "", value}}}};
  config::SensitivityRule linear = rule();
  linear.of_logarithm = false;
  const store::Table t = sensitivity_table(linear, tables, 24);
  // Variances: of i 35/12; of .5 k + .125 k that is its mean over tools 5/8 halved squared; the tool .125 at k = 1
  const double of_a = 35.0 / 12, of_b = 0.3125 * 0.3125, of_tool = 0.0625 * 0.0625, of_pair = of_tool,
               all = of_a + of_b + of_tool + of_pair;
  const auto is_share = [&](const Found& f, double variance) {
    CHECK_THAT(f.share, Catch::WithinAbs(variance / all, 1e-14));
    CHECK(std::isnan(f.low));
    CHECK(std::isnan(f.high));
  };
  is_share(found(t, "first", "a"), of_a);
  is_share(found(t, "first", "b"), of_b);
  is_share(found(t, "first", "tool"), of_tool);
  is_share(found(t, "pair", "b x tool"), of_pair);
  is_share(found(t, "with pairs", "b"), of_b + of_pair);
  is_share(found(t, "rest", ""), 0);
  // A point that is missing makes it a sample.
  std::get<std::vector<double>>(tables[0].columns.back().values)[7] = std::nan("");
  CHECK(found(sensitivity_table(linear, tables, 24), "first", "a").high > 0);
}

TEST_CASE("Every interval of a sensitivity table has its estimate in it, and a width") {
  for (const std::size_t points : {20, 32, 60}) {
    const store::Table t = sensitivity_table(rule(), sampled(points), points);
    const auto numbers = [&](const char* name) { return std::get<std::vector<double>>(t.column(name).values); };
    const std::vector<double> share = numbers("share"), low = numbers("share_ci_low"), high = numbers("share_ci_high");
    for (std::size_t i = 0; i < t.rows(); ++i) {
      CAPTURE(points, i);
      CHECK(low[i] <= share[i]);
      CHECK(share[i] <= high[i]);
      CHECK(high[i] > low[i] + 0.01);
    }
  }
}

TEST_CASE("What a sensitivity table cannot be made of is named") {
  const auto fault = [](config::SensitivityRule r, std::size_t points, std::size_t in_sweep) {
    return message_of([&] { sensitivity_table(r, sampled(points), in_sweep); });
  };
  config::SensitivityRule r = rule();
  CHECK(fault(r, 40, 40).empty());
  CHECK(fault(r, 40, 20) == "sensitivity.quantity: a point has several rows in table t: choose one by where");
  CHECK(fault(r, 10, 10) == "sensitivity.quantity: 10 points have a finite t.value: must be at least 20");
  r.quantities = {{"u", "value"}};
  CHECK(fault(r, 40, 40) == "sensitivity.quantity: the result has no table u");
  r.quantities = {{"t", "other"}};
  CHECK(fault(r, 40, 40) == "sensitivity.quantity: table t has no column other; it has a, b, c, tool, row, value");
  r.quantities = {{"t", "row"}};
  CHECK(fault(r, 40, 40) == "sensitivity.quantity: t.row must be a column of numbers");
  r = rule();
  r.where = {{"a", "1"}};
  CHECK(fault(r, 40, 40) == "sensitivity.where: table t has no column a of words");
}

TEST_CASE("[sensitivity] of a config is checked before anything runs") {
  const auto fault = [](const std::string& sensitivity, const std::string& sweep) {
    return message_of([&] {
      config::Config::from_text("experiment = 'e'\n[sensitivity]\n" + sensitivity + "\n[sweep]\n" + sweep, "t.toml",
                                {});
    });
  };
  const std::string good = "quantity = 't.value'", points = "a = { from = 1, to = 20, step = 1 }";
  CHECK(fault(good, points).empty());
  CHECK(fault(good, "design = { kind = 'sobol', points = 32, seed = 1 }\na = { from = 0, to = 1 }").empty());
  const std::string rule =
      "t.toml:2: sensitivity: needs a sweep of at least 20 points whose keys vary independently: a product, "
      "latin_hypercube or sobol";
  CHECK(fault(good, "a = [1, 2]") == rule);
  CHECK(fault(good, "design = 'zip'\n" + points + "\nb = { from = 1, to = 20, step = 1 }") == rule);
  CHECK(fault("scale = 'log'", points) == "t.toml:2: sensitivity.quantity: missing");
  CHECK(fault("quantity = 'value'", points) ==
        "t.toml:3: sensitivity.quantity = \"value\": must be TABLE.COLUMN, such as covariance.semi_major_m");
  CHECK(fault(good + "\nscale = 'ln'", points) ==
        "t.toml:4: sensitivity.scale = \"ln\": must be \"linear\" or \"log\"");
  CHECK(fault(good + "\nconfidence = 1.0", points) == "t.toml:4: sensitivity.confidence = 1: must be in (0, 1)");
  CHECK(fault(good + "\nwhen = 1", points).starts_with("t.toml:4: sensitivity.when: unknown key"));
}
