#include <catch2/catch.hpp>

#include "compare/annotations.h"
#include "config/config.h"

namespace surveymc::compare {
namespace {

config::Config two_points() {
  return config::Config::from_text(R"(
experiment = "none"
[noise]
scale = 1.0
[sweep]
noise.scale = [1.0, 0.1]
[[published]]
source = "a paper, table 2"
table = "position"
at = { "noise.scale" = 1.0 }
values = { sigma3_north = 4.5 }
[[published]]
source = "a paper, table 3"
table = "position"
at = { "noise.scale" = 0.1 }
values = { sigma3_north = 0.45, sigma3_east = 0.3 }
[[expect]]
table = "position"
quantities = ["sigma3_east"]
verdict = "differs"
at = { "noise.scale" = 0.1 }
)",
                                   "two_points.toml", {});
}

}  // namespace

TEST_CASE("Published values and expected verdicts are those of their point of the sweep") {
  config::Config config = two_points();
  const std::vector<Row> names{{"position", "", "sigma3_north"}, {"position", "", "sigma3_east"}};
  for (std::size_t point = 0; point < 2; ++point) {
    config::ConfigReader reader = config.reader(point);
    reader.number("noise.scale", {}, "");
    const Annotations annotations = Annotations::read(reader, names);
    reader.finish();
    CHECK(annotations.has_published());
    std::vector<ComparisonRow> rows{{.quantity = "sigma3_north"}, {.quantity = "sigma3_east"}};
    annotations.apply("position", rows);
    CHECK(rows[0].published == (point == 0 ? 4.5 : 0.45));
    CHECK(rows[0].expected.empty());
    if (point == 0)
      CHECK(std::isnan(rows[1].published));
    else
      CHECK(rows[1].published == 0.3);
    CHECK(rows[1].expected == (point == 0 ? "" : "differs"));
  }
}

}  // namespace surveymc::compare
