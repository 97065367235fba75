#include "config/sensor_csv.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include <catch2/catch.hpp>

#include "base/error.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Contains;

namespace {
const SensorCsvOptions kOptions{"t_min", {"a_kPa", "b_kPa"}};

InputFile held(const std::string& text) {
  return {"w.csv", std::make_shared<const std::string>(text), {}, text.size()};
}

struct AllRows : SensorBlock, SensorQuality {};

/// All of a file, read in blocks of `most` rows.
AllRows read_all(const InputFile& file, const SensorCsvOptions& options, std::size_t most) {
  SensorCsvReader reader(file, options);
  AllRows all;
  SensorBlock block;
  while (reader.next(block, most)) {
    all.time_h.insert(all.time_h.end(), block.time_h.begin(), block.time_h.end());
    all.values.insert(all.values.end(), block.values.begin(), block.values.end());
  }
  static_cast<SensorQuality&>(all) = reader.found();
  return all;
}
AllRows read_all(const std::string& text, const SensorCsvOptions& options = kOptions) {
  return read_all(held(text), options, 1000);
}
}  // namespace

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
  const AllRows csv = read_all(text);
  CHECK(csv.values == std::vector<double>{1, 10, 2, 11, 10, 18});
  REQUIRE(csv.time_h.size() == 3);
  CHECK(csv.time_h[2] == 7.0 / 60);
  CHECK(csv.good_rows == 3);
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
  CHECK_NOTHROW(reject_findings(read_all(clean), "w.csv"));
  const AllRows gap = read_all(clean + "9,1,2\n10,1,2\n");
  CHECK(gap.gaps.lines == std::vector<std::int64_t>{5});
  CHECK(gap.time_h.size() == 5);
  CHECK_THROWS_WITH(reject_findings(gap, "w.csv"), Contains("gaps in time: 1 (line 5)"));
}

TEST_CASE("A file on the disk is read as one that is held, whatever the pieces", "[sensor_csv]") {
  // 200,000 rows are 3 MB: several buffers of 1 MiB, and more steps than the median is taken of.
  std::string text = "\xEF\xBB\xBF# comment\r\nt_min,a_kPa,b_kPa\r\n";
  std::mt19937 gen(40);
  for (int i = 0; i < 200'000; ++i) {
    const auto kind = gen() % 1000;
    text += kind == 0   ? fmt::format("{},,1\n", i)
            : kind == 1 ? fmt::format("{},x,1\n", i)
            : kind == 2 ? fmt::format("{},2,1\n", i - 5)
            : kind == 3 ? "\n"
                        : fmt::format("{},{},{}\n", i, 1 + gen() % 100'000, 1 + gen() % 10);
  }
  const auto place = std::filesystem::temp_directory_path() / fmt::format("surveymc_csv_{}.csv", getpid());
  { std::ofstream(place, std::ios::binary) << text; }
  const InputFile on_disk{"w.csv", nullptr, place, text.size()};
  const AllRows a = read_all(held(text), kOptions, 1'000'000), b = read_all(on_disk, kOptions, 777);
  CHECK(a.time_h == b.time_h);
  CHECK(a.values == b.values);
  CHECK(a.good_rows > 199'000);
  CHECK(a.gaps.rows == b.gaps.rows);
  CHECK(a.gaps.lines == b.gaps.lines);
  CHECK(a.gaps.rows > 500);
  for (int d = 0; d < kRowDefects; ++d) {
    CHECK(a.defects[d].rows == b.defects[d].rows);
    CHECK(a.defects[d].lines == b.defects[d].lines);
  }
  const InputReference r = describe_file("w.csv", place);
  CHECK(r.size == text.size());
  CHECK(r.header == "t_min,a_kPa,b_kPa");
  CHECK(r.hash.size() == 32);

  SECTION("a file that is edited gives no rows under the hash of the old one") {
    const InputFile named{"w.csv", nullptr, place, text.size(), r.hash};
    CHECK(read_all(named, kOptions, 777).good_rows == a.good_rows);
    const std::size_t last = text.find_last_of("0123456789");
    text[last] = text[last] == '9' ? '8' : '9';  // one digit: size and number of rows stay
    { std::ofstream(place, std::ios::binary) << text; }
    CHECK_THROWS_WITH(read_all(named, kOptions, 777), Contains("w.csv: was changed while it was read"));
    SensorCsvReader first_rows(named, kOptions);
    SensorBlock block;
    CHECK(first_rows.next(block, 10));
    CHECK_THROWS_AS(first_rows.skip_to_end(), InputError);
  }
  SECTION("what is appended meanwhile is not read, a file that shrinks is an error, and so is a line without end") {
    { std::ofstream(place, std::ios::app) << "300000,1,1\n"; }
    CHECK(read_all(on_disk, kOptions, 777).good_rows == a.good_rows);
    CHECK(describe_file("w.csv", place).hash != r.hash);
    std::filesystem::resize_file(place, text.size() / 2);
    CHECK_THROWS_WITH(read_all(on_disk, kOptions, 777), Contains("was changed"));
    { std::ofstream(place, std::ios::trunc) << "t_min,a_kPa,b_kPa\n" << std::string(2'000'000, '1'); }
    CHECK_THROWS_WITH(read_all({"w.csv", nullptr, place, 2'000'018}, kOptions, 777), Contains("w.csv:2: is longer"));
  }
  std::filesystem::remove(place);
  CHECK_THROWS_AS(read_all(on_disk, kOptions, 777), IoError);
}

TEST_CASE("The typical step is that of the first 65536, and gaps are found before and after them", "[sensor_csv]") {
  std::string text = "t_min,a_kPa,b_kPa\n";
  for (int i = 0; i < 140'000; ++i)
    text += fmt::format("{},1,1\n", i < 100 ? i : i < 70'000 ? i + 3 : 70'000 + 2 * i);  // later on, every two minutes
  const AllRows csv = read_all(text);
  CHECK(csv.median_step_h == Approx(1.0 / 60).epsilon(1e-9));
  CHECK(csv.gaps.rows == 1 + 70'000);
  CHECK(csv.gaps.lines.front() == 102);  // header, 100 rows, then the row after the gap
}

TEST_CASE("Zeros are readings where the user says so", "[sensor_csv]") {
  SensorCsvOptions options = kOptions;
  options.zero_is_defect = false;
  CHECK(read_all("t_min,a_kPa,b_kPa\n0,0,2\n1,1,2\n", options).good_rows == 2);
}

TEST_CASE("Clocks are ISO 8601, across days and leap days", "[sensor_csv]") {
  const SensorCsvOptions options{"timestamp", {"a"}};
  const AllRows csv =
      read_all("timestamp,a\n2020-02-28 23:59:30.000000,1\n2020-02-29T00:00:30,2\n2020-03-01 00:00:30.5,3\n", options);
  REQUIRE(csv.time_h.size() == 3);
  CHECK(csv.time_h[1] == 60.0 / 3600);
  CHECK(csv.time_h[2] == (86400 + 60.5) / 3600);
  for (const char* bad : {"2019-02-29 00:00:00", "2020-03-02 24:00:00", "2020/03/02 01:00:00", "12", ""})
    CHECK(read_all("timestamp,a\n2019-01-01 00:00:00,1\n2019-01-01 00:01:00,1\n" + std::string(bad) + ",1\n", options)
              .defects[static_cast<int>(RowDefect::bad_time)]
              .rows == 1);
}

TEST_CASE("Clocks with an offset from UTC are read in UTC, and are not mixed with others", "[sensor_csv]") {
  const SensorCsvOptions options{"timestamp", {"a"}};
  // The hour of 02:00 to 03:00 comes twice where summer time ends.
  const AllRows autumn = read_all(
      "timestamp,a\n2020-10-25 02:30:00+02:00,1\n2020-10-25 02:00:00+01:00,2\n"
      "2020-10-25T01:15Z,3\n2020-10-24 22:00:00 -0330,4\n2020-10-25 02:45:00.0+01,5\n",
      options);
  CHECK(autumn.time_h == std::vector<double>{0, 0.5, 0.75, 1, 1.25});
  const AllRows mixed = read_all(
      "timestamp,a\n2020-01-01 00:00:00Z,1\n2020-01-01 00:01:00,2\n"
      "2020-01-01 01:02:00+01:00,3\n2020-01-01 00:03:00,4\n",
      options);
  CHECK(mixed.time_h == std::vector<double>{0, 2.0 / 60});
  CHECK(mixed.defects[static_cast<int>(RowDefect::bad_time)].lines == std::vector<std::int64_t>{3, 5});
  CHECK_THROWS_WITH(reject_findings(mixed, "w.csv"), Contains("some times have an offset from UTC and some have none"));
  for (const char* bad : {"+15:00", "+1:00", "+01:60", "+0a:00", "+01:00Z", "+", "CET"})
    CHECK(read_all("timestamp,a\n2019-01-01 00:00:00" + std::string(bad) + ",1\n", options)
              .defects[static_cast<int>(RowDefect::bad_time)]
              .rows == 1);
}

TEST_CASE("Columns that are not there, or twice, and files without rows are refused", "[sensor_csv]") {
  CHECK_THROWS_WITH(read_all("t_min,a_kPa\n0,1\n"), Contains("w.csv:1: no column \"b_kPa\""));
  CHECK_THROWS_WITH(
      read_all("t_min;a_kPa;b_kPa\n0;1;2\n"),
      Catch::EndsWith("there are t_min;a_kPa;b_kPa: cells must be separated by commas, with decimal points"));
  CHECK_THROWS_WITH(read_all("t_min,a_kPa,b_kPa,a_kPa\n"), Contains("two columns"));
  CHECK_THROWS_WITH(read_all(""), Contains("is empty"));
  CHECK(read_all("t_min,a_kPa,b_kPa\n0,1,2\n").good_rows == 1);
  CHECK(sensor_unit_of_name("pt_f_kPa") == "kPa");
  CHECK(sensor_unit_of_name("P-PDG").empty());
  CHECK(sensor_unit_of_name("_kPa").empty());
}
