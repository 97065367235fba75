#include "compare/table_rows.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::compare;

namespace {

const std::vector<double>& numbers(const store::Table& t, const std::string& column) {
  return std::get<std::vector<double>>(t.column(column).values);
}

struct Sensor {
  std::string name = {};
  int alarms = 0;
};

store::Table table_of(const std::vector<Sensor>& sensors) {
  TableRows t("alarms", "alarms of every sensor");
  write_rows(t, sensors, [&](const Sensor& s) {
    t.word("sensor", "whose alarms", s.name);
    t.count("alarms", "how many", s.alarms);
    t.number("per_h", "1/h", "in ten hours", s.alarms / 10.0);
  });
  return t.take();
}

}  // namespace

TEST_CASE("The first row makes the columns, further ones add to them", "[study]") {
  const store::Table t = table_of({{"a", 3}, {"b", 0}});
  REQUIRE(t.columns.size() == 3);
  CHECK(t.rows() == 2);
  CHECK(t.columns[0].unit.empty());
  CHECK(t.columns[1].unit == "1");
  CHECK(t.columns[2].unit == "1/h");
  CHECK(t.columns[2].long_name == "in ten hours");
  CHECK(std::get<std::vector<std::string>>(t.column("sensor").values) == std::vector<std::string>{"a", "b"});
  CHECK(std::get<std::vector<std::int64_t>>(t.column("alarms").values) == std::vector<std::int64_t>{3, 0});
  CHECK(numbers(t, "per_h") == std::vector<double>{0.3, 0});
}

TEST_CASE("A table without rows has the columns of one with rows", "[study]") {
  const store::Table none = table_of({}), one = table_of({{"a", 1}});
  CHECK(none.rows() == 0);
  REQUIRE(none.columns.size() == one.columns.size());
  for (std::size_t i = 0; i < one.columns.size(); ++i) {
    CHECK(none.columns[i].name == one.columns[i].name);
    CHECK(none.columns[i].values.index() == one.columns[i].values.index());
  }
}

TEST_CASE("A share has the exact binomial interval beside it", "[study]") {
  TableRows t("t", "");
  t.share("p", "share", 3, 10, 0.95);
  t.share("p", "share", 0, 0, 0.95);
  const store::Table table = t.take();
  CHECK(table.column("p").ancillary == "p_ci_low p_ci_high");
  CHECK(numbers(table, "p")[0] == 0.3);
  CHECK(numbers(table, "p_ci_low")[0] == stats::binomial_interval(3, 10, 0.95).lo);
  CHECK(numbers(table, "p_ci_high")[0] == stats::binomial_interval(3, 10, 0.95).hi);
  for (const char* column : {"p", "p_ci_low", "p_ci_high"}) CHECK(std::isnan(numbers(table, column)[1]));
}

TEST_CASE("A covariance becomes its six elements in the names of the axes", "[study]") {
  Eigen::Matrix3d c;
  c << 1, 4, 5, 4, 2, 6, 5, 6, 3;
  TableRows t("t", "");
  t.covariance("hla", "covariance", c);
  const store::Table table = t.take();
  double expected = 1;
  for (const char* column : {"hh_m2", "ll_m2", "aa_m2", "hl_m2", "ha_m2", "la_m2"})
    CHECK(numbers(table, column)[0] == expected++);
}

TEST_CASE("Values row by row become columns", "[study]") {
  const store::Table t =
      table_of_numbers({"t", "", {number_column("a", "m", ""), number_column("b", "m", "")}}, {1, 2, 3, 4});
  CHECK(numbers(t, "a") == std::vector<double>{1, 3});
  CHECK(numbers(t, "b") == std::vector<double>{2, 4});
}
