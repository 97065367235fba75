#include "compare/warnings.h"

#include <catch2/catch.hpp>

using namespace surveymc::compare;

TEST_CASE("Warnings that say the same are one, with its points and the first of them") {
  WarningList list;
  const Warning far{"warning", "w.csv:3", "md_m = 5", "far", "look at it"};
  for (std::uint64_t point = 0; point < 3; ++point) {
    Warning w = far;
    w.at = "k = " + std::to_string(point);
    list.add(w, point);
    list.add(w, point);  // as two pairs of wells say of one
  }
  list.add({"info", "", "", "other"}, 2);
  const std::vector<Warning> rows = warnings_of(list.table());
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].points == 3);
  CHECK(in_words(rows[0]) == "warning: w.csv:3: md_m = 5: far; look at it (3 points, the first: k = 0)");
  CHECK(in_words(rows[1]) == "info: other");
  CHECK(in_words({"warning", "field.dip_deg", "5", "odd"}) == "warning: field.dip_deg = 5: odd");
}

TEST_CASE("A table without warnings has its columns") {
  const surveymc::store::Table t = WarningList().table();
  CHECK(t.rows() == 0);
  CHECK(t.columns.size() == 7);
}

TEST_CASE("Of very many warnings the last row says how many are left out") {
  WarningList list;
  for (std::size_t i = 0; i < WarningList::kMost + 5; ++i) list.add({"warning", "", "", std::to_string(i)}, i);
  const std::vector<Warning> rows = warnings_of(list.table());
  REQUIRE(rows.size() == WarningList::kMost + 1);
  CHECK(rows.back().message == "5 warnings more of other points are left out");
}
