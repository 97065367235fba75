#include "config/sensor_csv.h"

#include <catch2/catch.hpp>

#include "base/error.h"

using namespace surveymc;
using Catch::Contains;

namespace {
const SensorCsvOptions kOptions{"t_min", {"a_kPa", "b_kPa"}};
}

TEST_CASE("Every kind of bad row is counted with its line, and the rest is read", "[sensor_csv]") {
  const std::string text =
      "# from a historian\n"
      "t_min,tag,b_kPa,a_kPa\r\n"
      "0,x,10,1\n"
      "1,\"x, y\",11,2\n"
      "1,x,12,3\n"    // repeated, line 5
      "2,x,,4\n"      // empty, 6
      "3,x,14,off\n"  // text, 7
      "4,x,0,6\n"     // zero, 8
      "3.5,x,15,7\n"  // before line 8, 9
      "5,x,16\n"      // cells, 10
      "now,x,17,8\n"  // bad time, 11
      "6,x,nan,9\n"   // empty, 12
      "\n"
      "7,x,1.8e1,+10\n"  // after a gap, 14
      "8,x,19,inf\n"     // text, 15
      "9,x,0,bad\n";     // text comes before zero, 16
  const SensorCsv csv = read_sensor_csv(text, "w.csv", kOptions);
  CHECK(csv.values == std::vector<double>{1, 10, 2, 11, 10, 18});
  REQUIRE(csv.time_h.size() == 3);
  CHECK(csv.time_h[2] == 7.0 / 60);
  CHECK(csv.lines == std::vector<std::int64_t>{3, 4, 14});
  CHECK(csv.rows_read == 13);
  const auto lines = [&](RowDefect d) { return csv.defects[static_cast<int>(d)].lines; };
  using Lines = std::vector<std::int64_t>;
  CHECK(lines(RowDefect::repeated_time) == Lines{5});
  CHECK(lines(RowDefect::empty) == Lines{6, 12});
  CHECK(lines(RowDefect::text) == Lines{7, 15, 16});
  CHECK(lines(RowDefect::zero) == Lines{8});
  CHECK(lines(RowDefect::unsorted_time) == Lines{9});
  CHECK(lines(RowDefect::cells) == Lines{10});
  CHECK(lines(RowDefect::bad_time) == Lines{11});
  CHECK_THROWS_WITH(reject_findings(csv, "w.csv"), Contains("w.csv: rows with another") &&
                                                       Contains("rows with an empty sensor cell: 2 (lines 6, 12)"));
}

TEST_CASE("A clean file is not rejected; a gap is", "[sensor_csv]") {
  const std::string clean = "t_min,a_kPa,b_kPa\n0,1,2\n1,1,2\n2,1,2\n";
  CHECK_NOTHROW(reject_findings(read_sensor_csv(clean, "w.csv", kOptions), "w.csv"));
  const SensorCsv gap = read_sensor_csv(clean + "9,1,2\n10,1,2\n", "w.csv", kOptions);
  CHECK(gap.gaps.lines == std::vector<std::int64_t>{5});
  CHECK(gap.time_h.size() == 5);
  CHECK_THROWS_WITH(reject_findings(gap, "w.csv"), Contains("gaps in time: 1 (line 5)"));
}

TEST_CASE("Zeros are readings where the user says so", "[sensor_csv]") {
  SensorCsvOptions options = kOptions;
  options.zero_is_defect = false;
  CHECK(read_sensor_csv("t_min,a_kPa,b_kPa\n0,0,2\n1,1,2\n", "w.csv", options).lines.size() == 2);
}

TEST_CASE("Clocks are ISO 8601, across days and leap days", "[sensor_csv]") {
  const SensorCsvOptions options{"timestamp", {"a"}};
  const SensorCsv csv = read_sensor_csv(
      "timestamp,a\n2020-02-28 23:59:30.000000,1\n2020-02-29T00:00:30Z,2\n2020-03-01 00:00:30.5,3\n", "w.csv", options);
  REQUIRE(csv.time_h.size() == 3);
  CHECK(csv.time_h[1] == 60.0 / 3600);
  CHECK(csv.time_h[2] == (86400 + 60.5) / 3600);
  for (const char* bad : {"2019-02-29 00:00:00", "2020-03-02 24:00:00", "2020/03/02 01:00:00", "12", ""})
    CHECK(read_sensor_csv("timestamp,a\n2019-01-01 00:00:00,1\n2019-01-01 00:01:00,1\n" + std::string(bad) + ",1\n",
                          "w.csv", options)
              .defects[static_cast<int>(RowDefect::bad_time)]
              .rows == 1);
}

TEST_CASE("Columns that are not there, or twice, and files without rows are refused", "[sensor_csv]") {
  CHECK_THROWS_WITH(read_sensor_csv("t_min,a_kPa\n0,1\n", "w.csv", kOptions), Contains("w.csv:1: no column \"b_kPa\""));
  CHECK_THROWS_WITH(read_sensor_csv("t_min,a_kPa,b_kPa,a_kPa\n", "w.csv", kOptions), Contains("two columns"));
  CHECK_THROWS_WITH(read_sensor_csv("", "w.csv", kOptions), Contains("is empty"));
  CHECK_THROWS_WITH(read_sensor_csv("t_min,a_kPa,b_kPa\n0,1,2\n", "w.csv", kOptions), Contains("at least two"));
  CHECK(sensor_unit_of_name("pt_f_kPa") == "kPa");
  CHECK(sensor_unit_of_name("P-PDG").empty());
  CHECK(sensor_unit_of_name("_kPa").empty());
}
