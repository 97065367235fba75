#include "config/observatory.h"

#include <cmath>

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"

using namespace surveymc;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

disturbance::Series minutes_of(const std::string& text) {
  config::InputFile file{"made_up.min", std::make_shared<const std::string>(text)};
  file.size = text.size();
  return config::observatory_series(file);
}

/// A made-up record of ten minutes.
std::string iaga_text(const std::string& elements, const std::string& row_5 = "") {
  std::string text = fmt::format(
      " Format                 IAGA-2002                                    |\n"
      " Station Name           Made up                                      |\n"
      " Reported               {}F                                         |\n"
      "DATE       TIME         DOY     MUP1      MUP2      MUP3      MUPF   |\n",
      elements);
  for (int k = 0; k < 10; ++k) {
    if (k == 5 && !row_5.empty()) {
      text += row_5 == "none" ? "" : row_5 + "\n";
      continue;
    }
    text += fmt::format("2024-05-31 23:{:02}:00.000 152     {:.2f} {:.2f} {:.2f} 99999.00\n", 50 + k, 20000.0 + k,
                        300.0 - 2 * k, 45000.0 + k * k);
  }
  return text;
}

std::string csv_text(const std::string& row_3 = "2024-05-31T00:03:00Z,20003,297,45000") {
  return "time,x_nT,y_nT,z_nT\n2024-05-31T00:01:00Z,20001,299,45000\n2024-05-31T00:02:00Z,20002,298,45000\n" + row_3 +
         "\n2024-05-31T00:04:00Z,20004,296,45000\n2024-05-31T00:05:00Z,20005,295,45000\n";
}

}  // namespace

TEST_CASE("Minutes in IAGA-2002: H and E as they are, X and Y along the mean field, D as an angle") {
  const disturbance::Series hez = minutes_of(iaga_text("HEZ"));
  CHECK(hez.step == 60);
  REQUIRE(hez.field.cols() == 10);
  CHECK(hez.field.col(3) == Eigen::Vector3d(20003, 294, 45009));
  const disturbance::Series xyz = minutes_of(iaga_text("XYZ"));
  CHECK_THAT(xyz.field.row(1).mean(), WithinAbs(0, 1e-9));
  for (int k = 0; k < 10; ++k)
    CHECK_THAT(xyz.field.col(k).head<2>().norm(), WithinAbs(std::hypot(20000.0 + k, 300.0 - 2 * k), 1e-9));
  const disturbance::Series hdz = minutes_of(iaga_text("HDZ"));  // minutes of arc, 282 to 300
  const double turn = (294 - 291) / 60.0 * kDegree;
  CHECK_THAT(hdz.field(0, 3), WithinAbs(20003 * std::cos(turn), 1e-9));
  CHECK_THAT(hdz.field(1, 3), WithinAbs(20003 * std::sin(turn), 1e-9));
}

TEST_CASE("A gap in a series is refused with its place") {
  CHECK_THROWS_WITH(
      minutes_of(iaga_text("HEZ", "2024-05-31 23:55:00.000 152     20005.00 99999.00  45025.00 99999.00")),
      Contains("made_up.min:10: 2024-05-31 23:55:00.000: MUP2 is missing"));
  CHECK_THROWS_WITH(minutes_of(iaga_text("HEZ", "none")),
                    Contains("made_up.min:10: 2024-05-31 23:56:00.000: a gap: 120 s after the row before"));
  CHECK_THROWS_WITH(minutes_of(iaga_text("HEZ", "2024-05-31 23:54:00.000 152     20005.00 290.00  45025.00 99999.00")),
                    Contains("made_up.min:10: 2024-05-31 23:54:00.000: not later"));
  CHECK_THROWS_WITH(minutes_of(iaga_text("HEZ", "2024-05-31 23:55:00.000 152     20005.00 2x")),
                    Contains("made_up.min:10"));
  CHECK_THROWS_WITH(minutes_of(iaga_text("FDI")), Contains("must be of XYZ, HEZ, HDZ"));
  CHECK_THROWS_WITH(minutes_of(csv_text("2024-05-31T00:03:00Z,,297,45000")), Contains("made_up.min:4: empty"));
  CHECK_THROWS_WITH(minutes_of(csv_text("# none")), Contains("made_up.min:5: a gap"));
  for (const char* missing : {"99999", "88888.00"})
    CHECK_THROWS_WITH(minutes_of(csv_text(fmt::format("2024-05-31T00:03:00Z,20003,{},45000", missing))),
                      Contains("made_up.min: y_nT = ") && Contains("missing values"));
}

TEST_CASE("Minutes in CSV") {
  const disturbance::Series s = minutes_of(csv_text());
  CHECK(s.step == 60);
  REQUIRE(s.field.cols() == 5);
  CHECK_THAT(s.field.col(0).head<2>().norm(), WithinAbs(std::hypot(20001.0, 299.0), 1e-9));
}
