#include "compare/row.h"

#include <catch2/catch.hpp>

#include "compare/calibration.h"
#include "config_text.h"

using namespace surveymc;
using namespace surveymc::compare;

namespace {

const std::vector<Row>& rows() {
  using enum Statistic;
  static const std::vector<Row> list{
      {.table = "t",
       .quantity = "mean_x",
       .unit = "m",
       .statistic = mean,
       .component = 0,
       .offset = 10,
       .prediction = 11},
      {.table = "t",
       .formulation = "f",
       .quantity = "sigma3_y",
       .statistic = sd,
       .component = 1,
       .sigmas = 3,
       .prediction = 2},
      {.table = "t",
       .quantity = "nees",
       .statistic = squared_distance,
       .component = 0,
       .prediction = 1,
       .predicted = false},
      {.table = "t", .quantity = "absent", .statistic = mean, .component = 7, .available = false},
      {.table = "other", .quantity = "mean_x", .statistic = mean, .component = 0},
      {.table = "calibration", .formulation = "f", .quantity = "x", .component = 0, .calibrated = true},
      {.table = "calibration", .quantity = "absent", .calibrated = true, .available = false}};
  return list;
}

std::vector<std::string> quantities(const std::vector<Row>& of) {
  std::vector<std::string> names;
  for (const Row& row : of) names.push_back(row.table + "." + row.quantity);
  return names;
}

CalibrationRule rule_of(const std::string& text) {
  return test::read_config("seed = 1\n" + text, [](config::ConfigReader& c) { return read_calibration(c, rows()); });
}

}  // namespace

TEST_CASE("A declared row is compared by its statistic, component and prediction") {
  Eigen::MatrixXd values(4, 2);
  values << 0, -4, 2, 4, 1, 0, 1, 0;
  const std::vector<ComparisonRow> found = compare_rows(rows(), "t", {}, 4, stats::Moments::of(values));
  REQUIRE(found.size() == 3);  // neither those of another table nor one that is not there
  CHECK(found[0].quantity == "mean_x");
  CHECK(found[0].unit == "m");
  CHECK(found[0].monte_carlo == 11);  // mean 1 and offset 10
  CHECK(found[0].analytic == 11);
  CHECK(found[1].formulation == "f");
  CHECK(found[1].monte_carlo == Approx(3 * std::sqrt(32 / 3.0)).epsilon(1e-15));
  CHECK(found[1].analytic == 6);
  CHECK(found[2].monte_carlo == 1);
  CHECK(found[2].margin == Approx(VerdictRule{}.nees_margin));
}

TEST_CASE("Calibrated rows are those that the scenario has and the config asks for") {
  const CalibrationRule off = rule_of(""), on = rule_of("[calibration]\nmargin = 0.02");
  CHECK(calibrated_rows(rows(), off).empty());
  CHECK(quantities(calibrated_rows(rows(), on)) == std::vector<std::string>{"calibration.x"});
  CHECK(annotated_rows(rows(), off).size() == 5);
  CHECK(quantities(annotated_rows(rows(), on)).back() == "calibration.x");
  CHECK_THROWS_WITH(rule_of("[calibration]\nquantities = ['absent']"), Catch::Matchers::Contains("is none of x"));
}
