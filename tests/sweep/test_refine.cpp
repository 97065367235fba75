/// Rounds of a sweep along a boundary.
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include "message_of.h"
#include "sweep/refine.h"

using namespace surveymc;
using namespace surveymc::sweep;

namespace {

int side_of_circle(double x, double y) { return x * x + y * y >= 0.5 ? 1 : -1; }

/// Table `t` with the column `value` at these points of the keys x and y.
store::Result result_at(const std::string& config, const std::vector<std::pair<double, double>>& points) {
  std::vector<double> x, y, value;
  for (const auto& [a, b] : points) {
    x.push_back(a);
    y.push_back(b);
    value.push_back(a * a + b * b);
  }
  return {.provenance = {.experiment = "e", .config = config},
          .tables = {{"t", "", {{"x", "1", "sweep key", x}, {"y", "1", "sweep key", y}, {"value", "1", "", value}}}}};
}

constexpr const char* kConfig =
    "experiment = 'e'\nseed = 1\n[refine]\nquantity = 't.value'\nlevel = 0.5\ncell = 0.02\n"
    "[sweep]\nx = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]\ny = { from = 0, to = 1, step = 0.25 }\n";

}  // namespace

TEST_CASE("Rounds follow a boundary: the same cells as the full grid, from fewer points") {
  const std::vector<std::string> axes{"x", "y"};
  const std::map<std::string, std::vector<double>> grid{{"x", {0, 0.2, 0.4, 0.6, 0.8, 1}},
                                                        {"y", {0, 0.25, 0.5, 0.75, 1}}};
  std::map<std::vector<double>, double> side;
  for (const double x : grid.at("x"))
    for (const double y : grid.at("y")) side[{x, y}] = side_of_circle(x, y);
  NextPoints next;
  int rounds = 0;
  while (!(next = next_points(axes, grid, 0.02, side)).points.empty()) {
    for (const auto& p : next.points) {
      const std::vector<double> at{p.at("x"), p.at("y")};
      CHECK(side.emplace(at, side_of_circle(at[0], at[1])).second);  // no point twice
    }
    ++rounds;
    REQUIRE(rounds < 10);
  }
  CHECK(rounds == 4);  // 0.25 / 16 <= 0.02, and one round a halving
  // The full grid of the smallest cells: 80 x 64 of them
  std::size_t crossed = 0;
  for (int i = 0; i < 80; ++i)
    for (int j = 0; j < 64; ++j) {
      int sum = 0;
      for (const int di : {0, 1})
        for (const int dj : {0, 1}) sum += side_of_circle((i + di) / 80.0, (j + dj) / 64.0);
      crossed += std::abs(sum) != 4;
    }
  CHECK(next.crossed == crossed);
  CHECK(side.size() < 81 * 65 / 9);
}

TEST_CASE("Rounds follow a valley that is narrower than the cells of the first grid") {
  // Below 1 in a valley round a sine, which is as wide as a cell at x = 0 and ever narrower
  const auto distance = [](double x, double y) {
    const double off = std::abs(y - 0.5 - 0.3 * std::sin(4 * x)),
                 value = 0.5 + off / (0.03 + 0.12 * std::pow(1 - x, 2));
    return (value - 1) / (value + 1);
  };
  std::vector<double> lines;
  for (int i = 0; i <= 8; ++i) lines.push_back(i / 8.0);
  const std::map<std::string, std::vector<double>> grid{{"x", lines}, {"y", lines}};
  std::map<std::vector<double>, double> known, sides;
  for (const double x : lines)
    for (const double y : lines) known[{x, y}] = distance(x, y);
  for (const auto& [at, v] : known) sides[at] = v >= 0 ? 1 : -1;
  const auto all_rounds = [&](std::map<std::vector<double>, double>& points, bool only_sides) {
    NextPoints next;
    while (!(next = next_points({"x", "y"}, grid, 1.0 / 64, points)).points.empty())
      for (const auto& p : next.points) {
        const double v = distance(p.at("x"), p.at("y"));
        points[{p.at("x"), p.at("y")}] = !only_sides ? v : v >= 0 ? 1 : -1;
      }
    return next.crossed;
  };
  std::size_t crossed = 0;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j) {
      int above = 0;
      for (const int di : {0, 1})
        for (const int dj : {0, 1}) above += distance((i + di) / 64.0, (j + dj) / 64.0) >= 0;
      crossed += above % 4 != 0;
    }
  CHECK(all_rounds(known, false) == crossed);
  CHECK(all_rounds(sides, true) < crossed);  // sides alone lose the valley where it is narrow
  CHECK(known.size() < 65 * 65 / 5);
}

TEST_CASE("The next round of a result is a config with a table of points") {
  std::vector<std::pair<double, double>> points;
  for (const double x : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0})
    for (const double y : {0.0, 0.25, 0.5, 0.75, 1.0}) points.emplace_back(x, y);
  const store::Result r = result_at(kConfig, points);
  const NextRound next = next_round(r, "t.h5", "n.points.csv");
  CHECK(next.count > 10);
  CHECK(next.points.starts_with("x,y\n"));
  CHECK(next.config == next_round(r, "t.h5", "n.points.csv").config);
  const config::Config c = config::Config::from_text(next.config, "n.toml", {}, {{"n.points.csv", next.points}});
  CHECK(c.point_count() == next.count);
  const config::RefineRule rule = config::refine_rule_of(next.config, "n.toml");
  CHECK(rule.grid.at("y") == std::vector<double>{0, 0.25, 0.5, 0.75, 1});
  // Nothing to do where the level is crossed nowhere
  std::string high = kConfig;
  high.replace(high.find("level = 0.5"), 11, "level = 9.5");
  CHECK(next_round(result_at(high, points), "t.h5", "n.points.csv").count == 0);
}

TEST_CASE("What cannot be refined is named") {
  const auto fault = [](const std::string& from, const std::string& to) {
    std::string text = kConfig;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    return message_of([&] { next_round(result_at(text, {{0, 0}, {0, 1}, {1, 0}, {1, 1}}), "t.h5", "n.points.csv"); });
  };
  CHECK(fault("", "").empty());
  CHECK(fault("'t.value'", "'value'") ==
        "t.h5:4: refine.quantity = \"value\": must be TABLE.COLUMN, such as summary.ratio_best");
  CHECK(fault("'t.value'", "'u.value'") == "t.h5:3: refine.quantity: the result has no table u");
  CHECK(fault("'t.value'", "'t.z'") == "t.h5:3: refine: table t has no column z; it has x, y, value");
  CHECK(fault("cell = 0.02", "cell = 2") == "t.h5:6: refine.cell = 2: must be in (0, 1): a share of the axis");
  CHECK(fault("cell = 0.02", "verdict = 'agrees'") == "t.h5:3: refine.level: give either level or verdict");
  CHECK(fault("cell = 0.02", "axes = ['z']") == "t.h5:3: refine.axes: z is no numeric key of the sweep");
  CHECK(fault("cell = 0.02", "sell = 1") == "t.h5:6: refine.sell: unknown key: did you mean refine.cell?");
  CHECK(fault("[refine]\nquantity = 't.value'\nlevel = 0.5\ncell = 0.02\n", "") ==
        "t.h5: refine: missing table [refine], which names the boundary to follow");
}
