#include <catch2/catch.hpp>

#include <limits>
#include <string>
#include <vector>

#include "base/units.h"
#include "render/json.h"

using namespace surveymc;
using namespace surveymc::render;
using namespace surveymc::store;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("JSON has null for a missing value and words for infinities") {
  CHECK(json_number(kNaN) == "null");
  CHECK(json_number(kInf) == "\"Infinity\"");
  CHECK(json_number(-kInf) == "\"-Infinity\"");
}

TEST_CASE("JSON numbers read back to the same bits and are numbers of RFC 8259") {
  for (const double x : {0.0, -0.0, 0.1, 1.0 / 3, 51000.000000000007, 5e-324, 1e22, -1e300,
                         std::numeric_limits<double>::max(), 123456789012345678.0}) {
    const std::string text = json_number(x);
    CAPTURE(text);
    CHECK(std::strtod(text.c_str(), nullptr) == x);
    CHECK(text.find_first_not_of("0123456789+-.e") == std::string::npos);
    CHECK(text.front() != '+');
    CHECK(text.front() != '.');
    CHECK(text.back() != '.');
  }
}

TEST_CASE("JSON texts are escaped, and bytes that are not UTF-8 replaced") {
  CHECK(json_string("plain σ°") == "\"plain σ°\"");
  CHECK(json_string("a\"b\\c\nd\x1b") == R"("a\"b\\c\u000ad\u001b")");
  CHECK(json_string("caf\xe9") == "\"caf\xef\xbf\xbd\"");
}

TEST_CASE("A table in JSON has its columns with units and values, or without values") {
  const Table t{"t",
                "a title",
                {{"x_m", "m", "length", std::vector<double>{1.5, kNaN}, "x_m_ci_low x_m_ci_high"},
                 {"n", "1", "count", std::vector<std::int64_t>{7, -2}},
                 {"s", "", "word", std::vector<std::string>{"a", ""}}}};
  CHECK(to_json(t) ==
        "{\"name\": \"t\", \"long_name\": \"a title\", \"rows\": 2, \"columns\": [\n"
        "  {\"name\": \"x_m\", \"unit\": \"m\", \"long_name\": \"length\", \"ancillary\": \"x_m_ci_low x_m_ci_high\", "
        "\"values\": [1.5,null]},\n"
        "  {\"name\": \"n\", \"unit\": \"1\", \"long_name\": \"count\", \"values\": [7,-2]},\n"
        "  {\"name\": \"s\", \"unit\": \"\", \"long_name\": \"word\", \"values\": [\"a\",\"\"]}]}");
  CHECK(to_json(t, false).find("values") == std::string::npos);
  CHECK(to_json({"e", ""}) == "{\"name\": \"e\", \"long_name\": \"\", \"rows\": 0, \"columns\": []}");
}

TEST_CASE("A map in JSON has axes with units and its shape") {
  const Map m{"r",
              "1",
              "ratio",
              {{"inclination", "deg", "", std::vector<double>{0, 90}},
               {"tool", "", "", std::vector<std::string>{"a", "b", "c"}}},
              {}};
  CHECK(map_members_json(m) ==
        "\"name\": \"r\", \"unit\": \"1\", \"long_name\": \"ratio\", \"shape\": [2, 3], \"axes\": ["
        "{\"name\": \"inclination\", \"unit\": \"deg\", \"long_name\": \"\", \"values\": [0,90]}, "
        "{\"name\": \"tool\", \"unit\": \"\", \"long_name\": \"\", \"values\": [\"a\",\"b\",\"c\"]}]");
}
