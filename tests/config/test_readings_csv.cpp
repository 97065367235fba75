#include "config/readings_csv.h"

#include <catch2/catch.hpp>

#include "base/error.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

const std::string kHeader = "md_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT,bz_nT\n";
const std::string kRows =
    "100,-1,2,9.5,-8000,9000,48000\n"
    "130,1,2,9.5,8000,9000,48000\n"
    "160,2,-2,9.4,8000,-9000,48000\n";

survey::SixAxisReadings read(const std::string& text, AccelerometerSign sign = AccelerometerSign::gravity) {
  return readings_from_table(parse_csv(text, "run.csv"), {sign, 9.8, 50000});
}

}  // namespace

TEST_CASE("Readings are read in every unit and order of columns") {
  const survey::SixAxisReadings si = read(kHeader + kRows);
  REQUIRE(si.size() == 3);
  CHECK(si.md[1] == 130);
  CHECK(si.gravity_T[0].x == -1);
  CHECK(si.gravity_T[2].z == 9.4);
  CHECK(si.magnetic_T[2].y == -9000);
  // 1 mg is 9.80665e-3 m/s2: 1000 mg along z is standard gravity.
  const survey::SixAxisReadings other = read(
      "bz_uT,by_uT,bx_uT,gz_mg,gx_mg,gy_mg,md_ft\n48,9,-8,1000,-100,50,100\n48,9,8,990,100,50,200\n48,-9,8,990,9,-5,"
      "300\n");
  CHECK(other.md[0] == Approx(30.48).epsilon(1e-15));
  CHECK(other.gravity_T[0].z == Approx(9.80665).epsilon(1e-15));
  CHECK(other.gravity_T[0].x == Approx(-0.980665).epsilon(1e-15));
  CHECK(other.gravity_T[1].y == Approx(0.4903325).epsilon(1e-15));
  CHECK(other.magnetic_T[0].x == Approx(-8000).epsilon(1e-15));
  CHECK(other.magnetic_T[2].y == Approx(-9000).epsilon(1e-15));
}

TEST_CASE("Specific force is turned into gravity") {
  const survey::SixAxisReadings down = read(kHeader + kRows),
                                up = read(kHeader + kRows, AccelerometerSign::specific_force);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(up.gravity_T[k].x == -down.gravity_T[k].x);
    CHECK(up.gravity_T[k].z == -down.gravity_T[k].z);
    CHECK(up.magnetic_T[k].z == down.magnetic_T[k].z);
  }
}

TEST_CASE("A bad file of readings is refused with its place, value and rule") {
  const auto header = [](const std::string& from, const std::string& to) {
    std::string h = kHeader;
    h.replace(h.find(from), from.size(), to);
    return h + kRows;
  };
  CHECK_THROWS_WITH(read(header("gx_mps2", "gx")),
                    Equals("run.csv:1: column gx: the unit is missing: write gx_mps2 or gx_mg"));
  CHECK_THROWS_WITH(read(header("gx_mps2", "gx mps2")),
                    Equals("run.csv:1: column gx mps2: unknown unit: write gx_mps2 or gx_mg"));
  CHECK_THROWS_WITH(read(header("by_nT", "by_gauss")),
                    Equals("run.csv:1: column by_gauss: unknown unit: write by_nT or by_uT"));
  CHECK_THROWS_WITH(read(header("by_nT", "hy_nT")), StartsWith("run.csv:1: column hy_nT: unknown column"));
  CHECK_THROWS_WITH(read(header("md_m", "MD_m")), StartsWith("run.csv:1: column MD_m: unknown column"));
  CHECK_THROWS_WITH(read(header("gy_mps2", "gy_mg")),
                    Equals("run.csv:1: column gy_mg: gx is in mps2: the three axes share one unit"));
  CHECK_THROWS_WITH(read(header("by_nT", "bx_uT")), Equals("run.csv:1: column bx_uT: the file has bx twice"));
  CHECK_THROWS_WITH(read("md_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT\n1,1,2,9.5,1,2\n"),
                    Equals("run.csv:1: column bz_nT or bz_uT: missing"));
  CHECK_THROWS_WITH(read(kHeader + "100,-1,2,x,-8000,9000,48000\n"),
                    Equals("run.csv:2: gz_mps2 = \"x\": must be a number"));
  CHECK_THROWS_WITH(read(kHeader + "100,-1,2,nan,-8000,9000,48000\n"),
                    Equals("run.csv:2: gz_mps2 = \"nan\": must be a finite number"));
  CHECK_THROWS_WITH(read(kHeader + "100,-1,2,,-8000,9000,48000\n"), Equals("run.csv:2: gz_mps2: is empty"));
  CHECK_THROWS_AS(read(""), InputError);
  CHECK_THROWS_AS(read(kHeader), InputError);
  CHECK_THROWS_WITH(read(kHeader + kRows + "160,2,-2,9.4,8000,-9000,48000\n"),
                    Equals("run.csv:5: md_m = 160: must be greater than the one before (160)"));
  CHECK_THROWS_WITH(read(kHeader + "100,-1,2,9.5,-8000,9000,48000\n130,1,2,9.5,8000,9000,48000\n"),
                    StartsWith("run.csv: 2 stations: three gains and three biases need at least 3 stations"));
}

TEST_CASE("Readings that no tool reports are refused: swapped columns, another unit") {
  // Accelerometers and magnetometers swapped
  CHECK_THROWS_WITH(read("md_m,bx_nT,by_nT,bz_nT,gx_mps2,gy_mps2,gz_mps2\n" + kRows),
                    StartsWith("run.csv:2: gx_mps2, gy_mps2, gz_mps2: their vector is 4.949e+04 m/s2 long"));
  // mg under the name of m/s2, and uT under the name of nT
  CHECK_THROWS_WITH(read(kHeader + "100,-100,200,980,-8000,9000,48000\n"), StartsWith("run.csv:2: gx_mps2, gy_mps2"));
  CHECK_THROWS_WITH(read(kHeader + "100,-1,2,9.5,-8,9,48\n"), StartsWith("run.csv:2: bx_nT, by_nT, bz_nT: their"));
}
