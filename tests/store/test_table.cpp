#include "store/table.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

namespace surveymc::store {
namespace {

using Numbers = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("A table finds its columns by name and says which it lacks") {
  const Table t{"position", "", {{"md_m", "m", "", Numbers{1, 2, 3}}}};
  CHECK(t.rows() == 3);
  CHECK(t.column("md_m").size() == 3);
  CHECK_THROWS_AS(t.column("md_ft"), std::out_of_range);
  CHECK(Table{"empty", ""}.rows() == 0);
}

TEST_CASE("append_rows puts every type of value below, also those of the table itself") {
  Table t{"t", "", {{"a", "1", "", Numbers{1}}, {"n", "1", "", Integers{2}}, {"s", "", "", Texts{"x"}}}};
  append_rows(t, t);
  append_rows(t, {"more", "", {{"a", "1", "", Numbers{5}}, {"n", "1", "", Integers{6}}, {"s", "", "", Texts{"y"}}}});
  CHECK(std::get<Numbers>(t.column("a").values) == Numbers{1, 1, 5});
  CHECK(std::get<Integers>(t.column("n").values) == Integers{2, 2, 6});
  CHECK(std::get<Texts>(t.column("s").values) == Texts{"x", "x", "y"});
}

TEST_CASE("a cell of a held table is read by its column's name, and a column that is not there gives nothing",
          "[table]") {
  const Table t{
      .name = "t",
      .long_name = "",
      .columns = {{"a", "1", "", Numbers{.5, 1.5}}, {"n", "1", "", Integers{2, 3}}, {"s", "", "", Texts{"x", "y"}}}};
  CHECK(t.find_column("s") == &t.columns[2]);
  CHECK(t.find_column("a_m") == nullptr);
  CHECK(t.number("a", 1) == 1.5);
  CHECK(t.number("n", 1) == 3);
  CHECK(std::isnan(t.number("s", 0)));
  CHECK(std::isnan(t.number("b", 0)));
  CHECK(t.word("s", 1) == "y");
  CHECK(t.word("a", 0).empty());
}

}  // namespace surveymc::store
