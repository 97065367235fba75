#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "base/units.h"
#include "render/csv.h"
#include "render/table_text.h"
#include "render/text.h"
#include "store/table.h"

using namespace surveymc;
using namespace surveymc::render;
using store::Column;
using store::Table;

namespace {

using Numbers = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::size_t code_points(const std::string& text) {
  std::size_t n = 0;
  for (const char c : text) n += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  return n;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Every study's main table, with the widest cells that occur.
Table comparison_table(const std::string& note) {
  return {"parameters",
          "sd of gains and biases",
          {{"quantity", "", "", Texts{"gain_x", "bias_x_nT"}},
           {"unit", "", "", Texts{"1", "nT"}},
           {"monte_carlo", "1", "", Numbers{0.000123456789, 12.3456789}, "monte_carlo_ci_low monte_carlo_ci_high"},
           {"monte_carlo_ci_low", "1", "", Numbers{0.000121234, 12.1234}},
           {"monte_carlo_ci_high", "1", "", Numbers{0.000125678, 12.5678}},
           {"analytic", "1", "", Numbers{0.000123123, 12.3123}},
           {"ratio", "1", "", Numbers{1.00271, 1.00271}, "ratio_ci_low ratio_ci_high"},
           {"ratio_ci_low", "1", "", Numbers{0.984321, 0.984321}},
           {"ratio_ci_high", "1", "", Numbers{1.020123, 1.020123}},
           {"published", "1", "", Numbers{0.000124, 12.4}},
           {"published_ratio", "1", "", Numbers{0.995619, 0.995619}},
           {"verdict", "", "", Texts{"agrees", "agrees"}},
           {"expected", "", "", Texts{"agrees", "agrees"}},
           {"note", "", "", Texts{note, note}}}};
}

}  // namespace

TEST_CASE("format_table aligns numbers right and text left, with units below the names") {
  const Table t{"field",
                "what was measured",
                {{"station", "", "", Texts{"a", "long name"}},
                 {"total_nT", "nT", "", Numbers{51000.25, -3}},
                 {"trials", "1", "", Integers{20000, 7}}}};
  CHECK(format_table(t) ==
        "field: what was measured\n"
        "station    total_nT  trials\n"
        "               [nT]\n"
        "---------------------------\n"
        "a           51000.2   20000\n"
        "long name        -3       7\n");
}

TEST_CASE("format_table shows a missing value as a dash and infinity as inf") {
  const Table t{"t", "", {{"mde", "1", "", Numbers{kNaN, kInf, -kInf, -0.0}}}};
  CHECK(format_table(t) == "t\n mde\n----\n   -\n inf\n-inf\n   0\n");
}

TEST_CASE("format_table leaves out columns without any value, and only those") {
  const Table t{"t",
                "",
                {{"a", "1", "", Numbers{1, 2}},
                 {"published", "nT", "", Numbers{kNaN, kNaN}},
                 {"note", "", "", Texts{"", ""}},
                 {"estimator", "", "", Texts{"msa", "msa"}},
                 {"half", "1", "", Numbers{kNaN, 3}}}};
  const std::string text = format_table(t);
  CHECK_FALSE(contains(text, "published"));
  CHECK_FALSE(contains(text, "nT"));
  CHECK_FALSE(contains(text, "note"));
  CHECK(contains(text, "estimator"));
  CHECK(contains(text, "half"));
}

TEST_CASE("format_table joins interval columns behind their value") {
  const Table t{"t",
                "",
                {{"sd", "nT", "", Numbers{70.1, kNaN}},
                 {"sd_ci_low", "nT", "", Numbers{69.5, kNaN}},
                 {"sd_ci_high", "nT", "", Numbers{70.7, kNaN}},
                 {"lone_ci_low", "nT", "", Numbers{1, 2}}}};
  const auto lines = lines_of(format_table(t));
  REQUIRE(lines.size() == 6);
  CHECK(contains(lines[1], "sd      interval"));
  CHECK_FALSE(contains(lines[1], "sd_ci"));
  CHECK(contains(lines[1], "lone_ci_low"));  // no value and no other end: a column like any other
  CHECK(contains(lines[4], "70.1  69.5 .. 70.7"));
  CHECK(contains(lines[5], "   -             -"));
}

TEST_CASE("A narrow interval around a large value prints as two different numbers") {
  const Table t{"t",
                "",
                {{"total", "nT", "", Numbers{51000.125}},
                 {"total_ci_low", "nT", "", Numbers{51000.12}},
                 {"total_ci_high", "nT", "", Numbers{51000.13}}}};
  CHECK(contains(format_table(t), "51000.12 .. 51000.13"));
}

TEST_CASE("format_table counts letters, not bytes, and keeps control characters off the terminal") {
  const Table t{
      "t", "", {{"s", "", "", Texts{"ärger σ°", "plain678", "a\n\x1b[2J"}}, {"x", "1", "", Numbers{1, 2, 3}}}};
  const auto lines = lines_of(format_table(t));
  REQUIRE(lines.size() == 6);
  CHECK(lines[3] == "ärger σ°  1");
  CHECK(lines[4] == "plain678  2");
  CHECK(lines[5] == "a  [2J    3");
}

TEST_CASE("The comparison table fits a wide terminal, whatever its notes") {
  const std::string long_note =
      "eq. 24 omits the covariance between gains and biases; the published value is from Table 7";
  for (const std::string& note : {std::string("short"), long_note}) {
    const auto lines = lines_of(format_table(comparison_table(note)));
    for (const std::string& line : lines) CHECK(code_points(line) <= 160);
    std::size_t with_note = 0;
    for (const std::string& line : lines) with_note += contains(line, note);
    CHECK(with_note == (note == long_note ? 1u : 2u));  // equal footnotes are written once
  }
  CHECK(contains(format_table(comparison_table("short")), "0.000123457"));
}

TEST_CASE("format_table prints tables without rows, without columns and without values") {
  CHECK(format_table({"t", "", {{"a", "m", "", Numbers{}}}}) == "t\n  a\n[m]\n---\n(no rows)\n");
  CHECK(format_table({"t", "none"}) == "t: none\n(no rows)\n");
  CHECK(format_table({"t", "", {{"a", "m", "", Numbers{kNaN, kNaN}}}}) == "t\n(2 rows without values)\n");
}

TEST_CASE("to_csv quotes what RFC 4180 wants quoted and leaves missing values empty") {
  const Table t{"t",
                "",
                {{"a,b", "", "", Texts{"plain", "with \"quotes\"", "two\nlines", ""}},
                 {"x", "1", "", Numbers{0.1, kNaN, -kInf, 1e-300}},
                 {"n", "1", "", Integers{1, -2, std::numeric_limits<std::int64_t>::max(), 0}}}};
  CHECK(to_csv(t) ==
        "\"a,b\",x,n\n"
        "plain,0.1,1\n"
        "\"with \"\"quotes\"\"\",,-2\n"
        "\"two\nlines\",-inf,9223372036854775807\n"
        ",1e-300,0\n");
  CHECK(to_csv({"t", "", {{"x", "1", "", Numbers{kNaN, 1}}}}) == "x\n\"\"\n1\n");
  CHECK(to_csv({"t", ""}).empty());
}

TEST_CASE("Numbers in CSV read back to the same bits") {
  const Numbers values = {1.0 / 3, 51000.000000000007, 5e-324, std::numeric_limits<double>::max(),
                          123456789012345678.0};
  const auto lines = lines_of(to_csv({"t", "", {{"x", "1", "", values}}}));
  REQUIRE(lines.size() == values.size() + 1);
  for (std::size_t i = 0; i < values.size(); ++i) CHECK(std::strtod(lines[i + 1].c_str(), nullptr) == values[i]);
}

TEST_CASE("A table too wide for a terminal puts equal counts above and sentences below it") {
  Table t{"t", "wide"};
  for (int c = 0; c < 12; ++c) t.columns.push_back({"a_long_column_name", "1", "", Numbers{1.23456789, 2.3456789}});
  t.columns.push_back({"verdict", "", "", std::vector<std::string>{"agrees", "differs"}});
  t.columns.push_back({"note", "", "", std::vector<std::string>{"", "a sentence of more than twenty characters"}});
  t.columns.push_back({"trials", "1", "", std::vector<std::int64_t>{20000, 20000}});
  t.columns.push_back({"seen", "1", "", std::vector<std::int64_t>{1, 2}});
  const std::string text = format_table(t);
  CHECK(contains(text, "(trials 20000)\n"));
  CHECK(contains(text, "  (1)  "));
  CHECK(contains(text, "\n(1) a sentence of more than twenty characters\n"));
  CHECK(contains(text, "seen"));
}

TEST_CASE("A verdict that is not the expected one is marked and counted; others are not") {
  const Table t{"t",
                "",
                {{"quantity", "", "", Texts{"a", "b", "c", "d"}},
                 {"verdict", "", "", Texts{"agrees", "differs", "differs", ""}},
                 {"expected", "", "", Texts{"", "differs", "agrees", "agrees"}}}};
  const auto lines = lines_of(format_table(t));
  REQUIRE(lines.size() == 8);
  CHECK(lines[3] == "a         agrees");
  CHECK(lines[4] == "b         differs      differs");
  CHECK(lines[5] == "c         differs (!)  agrees");
  CHECK(lines[6] == "d         none (!)     agrees");
  CHECK(lines[7] == "(!) 2 not as expected");
}

TEST_CASE("A long table shows its first and last rows and says how many are left out") {
  Numbers x;
  for (int i = 0; i < 100; ++i) x.push_back(i);
  const Table t{"t", "", {{"x", "1", "", x}}};
  TableFormat format{.most_rows = 5};
  CHECK(format_table(t, format) == "t\n x\n--\n 0\n 1\n 2\n... 95 of 100 rows left out ...\n98\n99\n");
  format.most_rows = 100;
  CHECK(format_table(t, format) == format_table(t));
}

TEST_CASE("A table is cut to as few rows as asked, down to one and to none") {
  const Table t{"t", "", {{"x", "1", "", Numbers{10, 11, 12}}}};
  TableFormat format{.most_rows = 2};
  CHECK(format_table(t, format) == "t\n x\n--\n10\n... 1 of 3 rows left out ...\n12\n");
  format.most_rows = 1;
  CHECK(format_table(t, format) == "t\n x\n--\n10\n... 2 of 3 rows left out ...\n");
  format.left_out = 97;  // of a table whose other rows are on the disk
  CHECK(format_table(first_and_last(t, 1), format) == "t\n x\n--\n10\n... 97 of 98 rows left out ...\n");
  format.left_out = format.most_rows = 0;
  CHECK(format_table(t, format) == "t\nx\n-\n... 3 of 3 rows left out ...\n");
}

TEST_CASE("Only the notes of rows that are shown become footnotes") {
  Table t{"t", "wide", {{"row", "", "", Texts{}}, {"note", "", "", Texts{}}}};
  for (int i = 0; i < 9; ++i) {
    std::get<Texts>(t.columns[0].values).push_back(fmt::format("r{}", i));
    std::get<Texts>(t.columns[1].values).push_back(fmt::format("the sentence that belongs to row {}", i));
  }
  const std::string text = format_table(t, {.width = 30, .most_rows = 2});
  CHECK(contains(text, "\n(1) the sentence that belongs to row 0\n(2) the sentence that belongs to row 8\n"));
  CHECK_FALSE(contains(text, "(3)"));
}

TEST_CASE("A long table with a note of its own in each row has all of them below") {
  constexpr int kRows = 60'000;  // in time that grows with the rows: with their square it would be hours
  Table t{"t", "wide", {{"row", "", "", Texts{}}, {"note", "", "", Texts{}}}};
  for (int i = 0; i < kRows; ++i) {
    std::get<Texts>(t.columns[0].values).push_back(fmt::format("r{}", i));
    std::get<Texts>(t.columns[1].values).push_back(fmt::format("the sentence of row {}", i - i % 2));
  }
  const std::vector<std::string> lines = lines_of(format_table(t, {.width = 20}));
  REQUIRE(lines.size() == 3 + kRows + kRows / 2);
  CHECK(lines[3 + kRows - 1] == "r59999  (30000)");
  CHECK(lines[3 + kRows] == "(1) the sentence of row 0");
  CHECK(lines.back() == "(30000) the sentence of row 59998");
}

TEST_CASE("Columns are as wide as the rows that are shown need") {
  const Table t{"t", "", {{"x", "1", "", Numbers{1, 123456, 2}}, {"y", "", "", Texts{"a", "long word", ""}}}};
  CHECK(format_table(t, {.most_rows = 2}) == "t\nx  y\n----\n1  a\n... 1 of 3 rows left out ...\n2\n");
}

TEST_CASE("Verdicts that are not as expected are counted in rows that are not shown, too") {
  const Table t{"t",
                "",
                {{"quantity", "", "", Texts{"a", "b", "c"}},
                 {"verdict", "", "", Texts{"agrees", "differs", "differs"}},
                 {"expected", "", "", Texts{"agrees", "agrees", "agrees"}}}};
  const std::string text = format_table(t, {.most_rows = 2});
  CHECK(contains(text, "c         differs (!)  agrees\n"));
  CHECK(contains(text, "(!) 2 not as expected\n"));
}

TEST_CASE("A split table is as narrow as asked, loses no column, and names the rows in every part") {
  Table t{"t", "", {{"formulation", "", "", Texts{"joint", "random"}}, {"quantity", "", "", Texts{"north", "east"}}}};
  for (int c = 0; c < 20; ++c) t.columns.push_back({fmt::format("x{}", c), "m", "", Numbers{c + 0.25, c + 0.5}});
  for (const std::size_t width : {50, 61, 80, 1000}) {
    const std::string text = format_table(t, {.width = width, .split = true});
    for (const std::string& line : lines_of(text)) CHECK(code_points(line) <= width);
    for (int c = 0; c < 20; ++c) CHECK(contains(text, fmt::format("{}.25", c)));
    std::size_t parts = 0, named = 0;
    for (const std::string& line : lines_of(text)) {
      parts += contains(line, "formulation  quantity");
      named += contains(line, "joint        north");
    }
    CHECK(named == parts);
    CHECK((parts > 1) == (width < 1000));
  }
}

TEST_CASE("The verdict stands behind the columns that name the row, and what is expected behind it") {
  const auto heads = [](const Table& t, const TableFormat& format) {
    std::vector<std::string> out;
    for (const std::string& line : lines_of(format_table(t, format)))
      if (contains(line, "quantity") || contains(line, "formulation")) out.push_back(line);
    return out;
  };
  Table t = comparison_table("");
  CHECK(contains(heads(t, {}).at(0), "quantity   verdict  expected  unit "));
  const TableFormat narrow{.width = 60, .split = true};
  CHECK(heads(t, narrow).at(0).starts_with("quantity   verdict  expected  unit"));
  CHECK_FALSE(contains(heads(t, narrow).at(1), "verdict"));
  std::erase_if(t.columns, [](const Column& c) { return c.name == "quantity"; });
  t.columns.insert(t.columns.begin(), {"formulation", "", "", Texts{"joint", "random"}});
  t.columns.insert(t.columns.begin(), {"noise.scale", "1", "sweep key", Numbers{0.5, 1}});
  CHECK(contains(heads(t, {}).at(0), "noise.scale  formulation  verdict  expected  unit "));
}

TEST_CASE("Names of rows never become footnotes; those that are too wide stand above their rows") {
  const std::string long_name = "a quantity whose name is longer than a sentence";
  Table t{"t",
          "",
          {{"case", "", "", Texts{"a case with a long name", "a case with a long name", "another"}},
           {"quantity", "", "", Texts{"north", long_name, "north"}}}};
  for (int c = 0; c < 20; ++c)
    t.columns.push_back({fmt::format("x{}", c), "m", "", Numbers{c + 0.25, c + 0.5, c + 0.75}});
  for (const bool split : {false, true}) {
    const TableFormat format{.width = 60, .split = split, .fold = split};
    std::string text = format_table(t, format);
    CHECK_FALSE(contains(text, "(1)"));
    if (!split) {
      CHECK(contains(text, long_name));
      continue;
    }
    CHECK(contains(text,
                   "case: a case with a long name; quantity: a quantity whose\n  name is longer than a sentence\n"));
    std::size_t groups = 0, others = 0;
    for (const std::string& line : lines_of(text)) {
      CHECK(code_points(line) <= format.width);
      groups += line == "case: a case with a long name; quantity: north";
      others += line == "case: another; quantity: north";
    }
    CHECK(groups > 1);  // in every part
    CHECK(groups == others);
  }
}

TEST_CASE("Only the rows' first names move above them when the others fit") {
  Table t{"t",
          "",
          {{"case", "", "", Texts{"a case with a long name", "a case with a long name", "another"}},
           {"quantity", "", "", Texts{"north", "east", "north"}}}};
  for (int c = 0; c < 6; ++c) t.columns.push_back({fmt::format("x{}", c), "m", "", Numbers{0.25, 0.5, 0.75}});
  CHECK(format_table(t, {.width = 50, .split = true}) ==
        "t\n"
        "quantity    x0    x1    x2    x3    x4    x5\n"
        "           [m]   [m]   [m]   [m]   [m]   [m]\n"
        "--------------------------------------------\n"
        "case: a case with a long name\n"
        "north     0.25  0.25  0.25  0.25  0.25  0.25\n"
        "east       0.5   0.5   0.5   0.5   0.5   0.5\n"
        "case: another\n"
        "north     0.75  0.75  0.75  0.75  0.75  0.75\n");
}

TEST_CASE("Folded text keeps its words, its first blanks and the width") {
  CHECK(folded("", 10) == "");
  CHECK(folded("one two", 7) == "one two");
  CHECK(folded("one two", 6, 2) == "one\n  two");
  CHECK(folded("  one two three", 9, 4) == "  one two\n    three");
  CHECK(folded("a/very/long/path b", 5, 1) == "a/very/long/path\n b");
  CHECK(folded("σσσσ σσσσ", 9) == "σσσσ σσσσ");  // letters, not bytes
}
