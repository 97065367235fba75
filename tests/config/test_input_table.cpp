#include <clocale>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "config/input_table.h"
#include "message_of.h"

using surveymc::InputError;
using surveymc::config::InputTable;
using surveymc::config::parse_csv;

namespace {

/// What parse_csv says about a bad file; empty if it accepts it.
std::string fault(const std::string& text) {
  return surveymc::message_of([&] { parse_csv(text, "traj.csv"); });
}

const std::string kHint = "decimal points and commas between cells are required";

}  // namespace

TEST_CASE("CSV: names, numbers and the line of every row") {
  const InputTable t =
      parse_csv("# a survey\n\nmd_m, inclination_deg ,azimuth_deg\n0,0,0\n# more\n\n 30 ,\t1.5,-2e1\n", "a/t.csv");
  CHECK(t.path == "a/t.csv");
  CHECK(t.names == std::vector<std::string>{"md_m", "inclination_deg", "azimuth_deg"});
  REQUIRE(t.columns.size() == 3);
  CHECK(t.columns[0] == std::vector<double>{0, 30});
  CHECK(t.columns[1] == std::vector<double>{0, 1.5});
  CHECK(t.columns[2] == std::vector<double>{0, -20});
  CHECK(t.lines == std::vector<int>{4, 7});
  CHECK(t.rows() == 2);
  CHECK(t.find("azimuth_deg") == 2);
  CHECK(t.find("azimuth") == -1);
}

TEST_CASE("CSV: byte order mark, CRLF, quotes, plus signs and a last line without an end") {
  const InputTable t = parse_csv("\xEF\xBB\xBF\"md_m\",\"a \"\"b\"\"\"\r\n\"+1.5\" , .5\r\n2.,+3E+2", "t.csv");
  CHECK(t.names == std::vector<std::string>{"md_m", "a \"b\""});
  CHECK(t.columns[0] == std::vector<double>{1.5, 2});
  CHECK(t.columns[1] == std::vector<double>{0.5, 300});
  CHECK(t.lines == std::vector<int>{2, 3});
}

TEST_CASE("CSV: a row with quotes is read as one without, blanks, empty cells and their mistakes included") {
  const std::string names = "md_m,note_1,azimuth_deg\n";
  for (const auto& [plain, quoted] : {std::pair<std::string, std::string>{"1,2,3", "\"1\",2,3"},
                                      {" 1 ,\t2, 3\t", "\" 1 \" ,\t2, \"3\"\t"},
                                      {"1,2,3,,", "1,\"2\",3,,"},
                                      {",,", "\"\",,"},
                                      {"1,,3", "1,\"\",3"},
                                      {"1,2", "1,\"2\""},
                                      {"1,2,3,4", "1,2,3,\"4\""},
                                      {"1,x,3", "1,\"x\",3"}}) {
    CAPTURE(plain, quoted);
    CHECK(fault(names + "0,0,0\n" + plain + "\n7,8,9") == fault(names + "0,0,0\n" + quoted + "\n7,8,9"));
    if (!fault(names + "0,0,0\n" + plain + "\n7,8,9").empty()) continue;
    const InputTable a = parse_csv(names + "0,0,0\n" + plain + "\n7,8,9", "t.csv"),
                     b = parse_csv(names + "0,0,0\n" + quoted + "\n7,8,9", "t.csv");
    CHECK(a.columns == b.columns);
    CHECK(a.lines == b.lines);
  }
}

TEST_CASE("CSV: numbers are read to the last bit, in every locale") {
  const char* const german = std::setlocale(LC_ALL, "de_DE.UTF-8");  // absent on many machines: then only "C" is tested
  const InputTable t = parse_csv("x,y\n0.1,5e-324\n51000.000000000007,1.7976931348623157e308\n", "t.csv");
  CHECK(t.columns[0] == std::vector<double>{0.1, 51000.000000000007});
  CHECK(t.columns[1] == std::vector<double>{5e-324, 1.7976931348623157e308});
  if (german) std::setlocale(LC_ALL, "C");
}

TEST_CASE("CSV: a cell that is not a finite number is named with its line and column") {
  const std::string head = "md_m,inclination_deg\n0,1\n";
  CHECK(fault(head + "1,abc\n") == "traj.csv:3: inclination_deg = \"abc\": must be a number");
  CHECK(fault(head + "1,\n") == "traj.csv:3: inclination_deg: is empty");
  CHECK(fault(head + "1,\"\"\n") == "traj.csv:3: inclination_deg: is empty");
  for (const std::string bad : {"1.5x", "1 2", "0x10", "1_000", "1d5", "+-1", "++1", "+", "-", "1e", "true"}) {
    CHECK(fault(head + "1," + bad + "\n") == "traj.csv:3: inclination_deg = \"" + bad + "\": must be a number");
  }
  for (const std::string bad : {"nan", "NaN", "-nan", "inf", "+inf", "-Infinity"}) {
    CHECK(fault(head + bad + ",1\n") == "traj.csv:3: md_m = \"" + bad + "\": must be a finite number");
  }
  CHECK(fault(head + "1e999,1\n") == "traj.csv:3: md_m = \"1e999\": is out of the range of floating-point numbers");
  const std::string longest(1000, 'x');
  CHECK(fault(head + "1," + longest + "\n").size() < 150);
}

TEST_CASE("CSV: every row is as long as the header") {
  CHECK(fault("a,b,c\n1,2,3\n1,2\n") == "traj.csv:3: 2 cells: must have 3 as the header");
  CHECK(fault("a,b,c\n1\n") == "traj.csv:2: 1 cell: must have 3 as the header");
  CHECK(fault("a,b,c\n1,2,3,4\n") == "traj.csv:2: 4 cells: must have 3 as the header");
}

TEST_CASE("CSV: the header must be there, and its names must differ") {
  CHECK(fault("") == "traj.csv: is empty: must have a line of column names, then rows");
  CHECK(fault("# only\n\n") == "traj.csv: is empty: must have a line of column names, then rows");
  CHECK(fault("a,b\n# none\n") == "traj.csv: has no rows below the column names");
  CHECK(fault("1,2\n3,4\n") == "traj.csv:1: column 1 = \"1\": the first line must name the columns");
  CHECK(fault("a,nan\n3,4\n") == "traj.csv:1: column 2 = \"nan\": the first line must name the columns");
  CHECK(fault("a,,c\n3,4,5\n") == "traj.csv:1: column 2 has no name");
  CHECK(fault("a,b,\n3,4,5\n") == "traj.csv:2: 3 cells: must have 2 as the header");
  CHECK(fault("#x\na,b,a\n3,4,5\n") == "traj.csv:2: a: two columns have this name");
}

TEST_CASE("CSV: files with decimal commas or other separators get a hint") {
  CHECK(fault("a,b\n1,\"12,5\"\n") == "traj.csv:2: b = \"12,5\": must be a number: " + kHint);
  CHECK(fault("md_m;inc_deg\n1;2\n") == "traj.csv:1: \"md_m;inc_deg\": " + kHint);
  CHECK(fault("md_m\tinc_deg\n1\t2\n") == "traj.csv:1: \"md_m\tinc_deg\": " + kHint);
  CHECK(fault("a,b\n1;2\n") == "traj.csv:2: 1 cell: must have 2 as the header (" + kHint + ")");
  CHECK(fault("a,b\n1,5,2,5\n") == "traj.csv:2: 4 cells: must have 2 as the header (" + kHint + ")");
  CHECK(fault("a\n1;2\n") == "traj.csv:2: a = \"1;2\": must be a number: " + kHint);
}

TEST_CASE("CSV: quotes are around whole cells, or the number would not be what the file says") {
  CHECK(fault("a,b\n1\"2,3\n") == "traj.csv:2: 1\"2: a quote inside a cell");
  CHECK(fault("a,b\n\"1\"2,3\n") == "traj.csv:2: text after a closing quote");
  CHECK(fault("a,b\n\"1\"\"2\",3\n") == "traj.csv:2: a = \"1\"2\": must be a number");
  CHECK(fault("a,b\n\"1,3\n") == "traj.csv:2: a quote is not closed on its line");
}

TEST_CASE("CSV: binary files and other encodings are refused") {
  using namespace std::string_literals;
  const std::string way = ": save the file as CSV in UTF-8";
  CHECK(fault("a,b\n1,\0002\n"s) == "traj.csv:2: is not plain UTF-8 text (byte 0x00)" + way);
  CHECK(fault("a,b\n1,2\n5\xB0\n") == "traj.csv:3: is not plain UTF-8 text (byte 0xb0)" + way);  // Latin-1
  CHECK(fault("\xFF\xFE"
              "a\0,\0"s) == "traj.csv:1: is not plain UTF-8 text (byte 0xff)" + way);  // UTF-16
  CHECK(fault("\x89HDF\r\n\x1a\n") == "traj.csv:1: is not plain UTF-8 text (byte 0x89)" + way);
  CHECK(fault("a\xC0\xAF,b\n1,2\n") == "traj.csv:1: is not plain UTF-8 text (byte 0xc0)" + way);      // overlong
  CHECK(fault("a\xED\xA0\x80,b\n1,2\n") == "traj.csv:1: is not plain UTF-8 text (byte 0xed)" + way);  // surrogate
  CHECK(fault("a,b\n1,2\n\xE2\x82") == "traj.csv:3: is not plain UTF-8 text (byte 0xe2)" + way);      // cut off
  CHECK(fault("Länge_m,b\n1,2\n# 5° \xF0\x9F\x9B\xA2\n").empty());
}

TEST_CASE("CSV: letters of comments may be of any encoding, for nothing of them is kept") {
  CHECK(parse_csv("# 5\xB0 dip\na,b\n1,2\n# \xE2\x82", "t.csv").rows() == 1);
  CHECK(fault("# \x01\na,b\n1,2\n").starts_with("traj.csv:1: is not plain UTF-8 text (byte 0x01)"));
}

TEST_CASE("CSV: lines may end with CR, and keep their numbers") {
  const InputTable t = parse_csv("# old\ra,b\r1,2\r\r3,4\r", "t.csv");
  CHECK(t.columns[1] == std::vector<double>{2, 4});
  CHECK(t.lines == std::vector<int>{3, 5});
  CHECK(fault("a,b\r1,2\r3,x\r") == "traj.csv:3: b = \"x\": must be a number");
}

TEST_CASE("CSV: empty cells that spreadsheets write behind rows and between them hold nothing") {
  const InputTable t = parse_csv(",,,\na,b,,\n1,2,,\n,,\n3,4\n\"\",\n", "t.csv");
  CHECK(t.names == std::vector<std::string>{"a", "b"});
  CHECK(t.columns[0] == std::vector<double>{1, 3});
  CHECK(t.lines == std::vector<int>{3, 5});
  CHECK(t.names_line == 2);
  CHECK(fault("a,b,c\n1,2,,\n") == "traj.csv:2: c: is empty");
  CHECK(fault("a,b,c\n1,,3\n") == "traj.csv:2: b: is empty");
  CHECK(fault("a,b\n1,2,,3\n") == "traj.csv:2: 4 cells: must have 2 as the header (" + kHint + ")");
}

TEST_CASE("CSV: the names can be judged before the cells") {
  const auto refuse = [](const InputTable& t) { throw InputError("no " + t.names.back()); };
  CHECK_THROWS_WITH(parse_csv("a,remark\n1,x\n", "t.csv", refuse), "no remark");
}

TEST_CASE("CSV: a row whose first cell a spreadsheet could not compute is no comment") {
  for (const std::string cell : {"#N/A", "#REF!", "#VALUE!", "#DIV/0!", "#NAME?", "#NUM!", "#NULL!", "#NV", " #N/A "})
    CHECK(fault("a,b\n1,2\n" + cell + ",3\n").starts_with("traj.csv:3: a = \"#"));
  for (const std::string comment : {"#N/A in the log", "#A,B", "# NOTE!", "#note!", "#!", "#", "#MD,INC"})
    CHECK(parse_csv("a,b\n1,2\n" + comment + "\n", "t.csv").rows() == 1);
}
