#include "scenario/reference_field.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config_text.h"
#include "earth/geodesy.h"
#include "scenario/adjustment_scenario.h"
#include "scenario/scenario.h"

using namespace surveymc;
using namespace surveymc::scenario;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kPlace = "latitude_deg = 60.5\nlongitude_deg = 2.5\n";
const std::string kWmm = "model = 'wmm2025'\ndate = 2026-07-01\n";

survey::ReferenceField field_of(const std::string& field, std::vector<config::Remark>* remarks = nullptr) {
  return test::read_config(
      "[field]\n" + field, [](config::ConfigReader& c) { return read_field(c); }, remarks);
}

}  // namespace

TEST_CASE("A field by its numbers is what it was, grid or not") {
  const survey::ReferenceField f = field_of("total_nT = 50000\ndip_deg = 72\nconvergence_deg = 1");
  CHECK(f.total == 50000);
  CHECK(f.gravity == 9.80665);
  CHECK(f.convergence == 1 * kDegree);
  const survey::ReferenceField g =
      field_of("total_nT = 50000\ndip_deg = 72\ngrid = { crs = 'utm', zone = 31 }\n" + kPlace);
  CHECK(g.convergence == earth::utm_convergence({60.5 * kDegree, 2.5 * kDegree, 0}, 31));
}

TEST_CASE("A field of a place is the model's, with normal gravity and the grid's convergence") {
  std::vector<config::Remark> remarks;
  const survey::ReferenceField f = field_of(kWmm + kPlace + "height_m = 120\ngrid = { crs = 'utm' }", &remarks);
  const earth::Place place{60.5 * kDegree, 2.5 * kDegree, 120};
  // 1 July is day 182 of 365: 181 days are over.
  const earth::MagneticElements e = earth::magnetic_elements(earth::wmm2025().field(place, 2026 + 181.0 / 365).vector);
  CHECK(f.total == e.total);
  CHECK(f.dip == e.dip);
  CHECK(f.declination == e.declination);
  CHECK(f.gravity == earth::normal_gravity(place));
  CHECK(f.convergence == earth::utm_convergence(place, 31));
  REQUIRE(remarks.size() == 1);
  CHECK_FALSE(remarks.front().is_warning);
  CHECK_THAT(remarks.front().text(), StartsWith("reference field of wmm2025 at 60.5 N, 2.5 E, 120 m, 2026.50: "));
}

TEST_CASE("A table has the place in the degrees of the config, to the last digit") {
  for (const char* degrees : {"58.4", "-33.7", "2.3", "0.1", "89.99", "61.123456789012"}) {
    const std::vector<store::Table> tables =
        test::read_config("[field]\n" + kWmm + "blackout = 'allow'\nlatitude_deg = " + degrees +
                              "\nlongitude_deg = " + degrees + "\nconvergence_deg = " + degrees,
                          [](config::ConfigReader& c) { return field_tables(*read_placed_field(c)); });
    for (const char* column : {"latitude_deg", "longitude_deg", "convergence_deg"})
      CHECK(tables.front().number(column, 0) == std::stod(degrees));
  }
}

TEST_CASE("Dates are days, quoted or not, or decimal years, in the life of the model") {
  const auto total = [](const std::string& date) {
    return field_of("model = 'wmm2025'\n" + kPlace + "date = " + date).total;
  };
  CHECK(total("2026-07-01") == total("'2026-07-01'"));
  CHECK(total("2026-01-01") == total("2026"));
  CHECK(total("2028-12-31") == total(fmt::format("{:.17g}", 2028 + 365.0 / 366)));
  CHECK_NOTHROW(total("2025.0"));
  CHECK_NOTHROW(total("2030-01-01"));
  const std::string life = "wmm2025 is valid from 2025.0 to 2030.0";
  CHECK_THROWS_WITH(total("2024-12-31"), "t.toml:6: field.date = 2024-12-31: " + life);
  CHECK_THROWS_WITH(total("2030-01-02"), Contains(life));
  CHECK_THROWS_WITH(total("2030.001"), Contains(life));
  for (const char* bad : {"'2026-02-30'", "'2026-7-1'", "'July 2026'", "true", "2026-07-01T10:00:00", "'2026-07-01 '"})
    CHECK_THROWS_WITH(total(bad), Contains("must be a date, 2026-07-01, or a decimal year, 2026.5"));
}

TEST_CASE("What stands beside a model, or without one, is refused with place, value and rule") {
  CHECK_THROWS_WITH(
      field_of(kWmm + kPlace + "dip_deg = 72"),
      "t.toml:7: field.dip_deg = 72: not together with field.model = \"wmm2025\", which gives it: take one away");
  CHECK_THROWS_WITH(field_of(kWmm + "latitude_deg = 91\nlongitude_deg = 0"), Contains("must be in [-90, 90]"));
  CHECK_THROWS_WITH(field_of(kWmm + "latitude_deg = 1"), Contains("field.longitude_deg: missing"));
  CHECK_THROWS_WITH(field_of(kWmm + kPlace + "height_m = -5000"), Contains("must be in [-1000, 850000]"));
  CHECK_THROWS_WITH(field_of("model = 'igrf14'\n" + kPlace), Contains("must be \"wmm2025\""));
  CHECK_THROWS_WITH(field_of("total_nT = 50000\ndip_deg = 72\ndate = 2026-01-01"), Contains("only with field.model"));
  CHECK_THROWS_WITH(field_of("total_nT = 50000\ndip_deg = 72\n" + kPlace),
                    Contains("only with field.model = \"wmm2025\" or field.grid"));
  CHECK_THROWS_WITH(field_of(kWmm + kPlace + "convergence_deg = 1\ngrid = { crs = 'utm' }"),
                    Contains("not together with grid"));
  CHECK_THROWS_WITH(field_of(kWmm + kPlace + "grid = { crs = 'rd' }"), Contains("must be \"utm\""));
  CHECK_THROWS_WITH(field_of(kWmm + kPlace + "grid = { crs = 'utm', zone = 33 }"),
                    Contains("12.5 degrees from the central meridian") && Contains("that of the place is 31"));
  CHECK_THROWS_WITH(field_of(kWmm + "latitude_deg = -85\nlongitude_deg = 10\ngrid = { crs = 'utm' }"),
                    Contains("there is no UTM grid"));
}

TEST_CASE("The blackout zone is refused by its name unless allowed, the caution zone is a warning") {
  const std::string blackout = kWmm + "latitude_deg = 86\nlongitude_deg = 160\n";
  CHECK_THROWS_WITH(field_of(blackout), Contains("t.toml:5: field.latitude_deg = 86: the horizontal field there is") &&
                                            Contains("blackout zone of wmm2025 about the north magnetic pole") &&
                                            Contains("field.blackout = \"allow\""));
  std::vector<config::Remark> remarks;
  field_of(blackout + "blackout = 'allow'", &remarks);
  REQUIRE(remarks.size() == 2);
  CHECK(remarks.front().is_warning);
  CHECK_THAT(remarks.front().text(), Contains("t.toml:5: field.latitude_deg = 86: ") && Contains("blackout"));
  field_of(kWmm + "latitude_deg = -63\nlongitude_deg = 142\n", &remarks);
  CHECK_THAT(remarks.front().text(), Contains("caution zone of wmm2025 about the south magnetic pole (below 6000 nT)"));
}

TEST_CASE("A study of magnetic azimuths takes a place without its declination") {
  const auto magnetic = [](config::ConfigReader& c) { return read_field_of_magnetic_north(c); };
  CHECK(test::read_config("[field]\n" + kWmm + kPlace, magnetic).declination == 0);
  CHECK_THROWS_WITH(test::read_config("[field]\ntotal_nT = 50000\ndip_deg = 72\ndeclination_deg = 3", magnetic),
                    Contains("field.declination_deg = 3: must be 0"));
}

TEST_CASE("The model's uncertainty is one draw a run of the reference, or the sigmas of an adjustment") {
  const auto noise = [](config::ConfigReader& c) { return read_noise(c); };
  const sensor::NoiseModel n = test::read_config("[noise]\nmagnetometer_nT = 70\nreference = 'wmm2025'", noise);
  CHECK(n.reference == sensor::ReferenceNoise::per_run);
  CHECK(n.reference_total == 138);
  CHECK(n.reference_dip == Approx(0.20 * kDegree).epsilon(1e-15));
  const sensor::NoiseModel m = test::read_config(
      "[noise]\nmagnetometer_nT = 70\nscale = 2\nreference = { name = 'wmm2025', per = 'station', dip_deg = 0.1 }",
      noise);
  CHECK(m.reference == sensor::ReferenceNoise::per_station);
  CHECK(m.reference_total == 276);
  CHECK(m.reference_dip == Approx(0.2 * kDegree).epsilon(1e-15));
  CHECK_THROWS_WITH(test::read_config("[noise]\nmagnetometer_nT = 70\nreference = 'igrf'", noise),
                    Contains("must be \"wmm2025\""));

  const reliability::AdjustmentModel a =
      test::read_config("mode = 'sse'\n[sigma]\nreference = 'wmm2025'\n[field]\n" + kWmm + kPlace,
                        [](config::ConfigReader& c) { return read_adjustment_model(c); });
  CHECK(a.sigma.total_field == 138);
  CHECK(a.sigma.dip == Approx(0.20 * kDegree).epsilon(1e-15));
  CHECK(a.field.total == field_of(kWmm + kPlace).total);
}

TEST_CASE("The field of many places is at each that of the place, by true north") {
  const auto read = [](const std::string& field) {
    return test::read_config("[field]\n" + field, [](config::ConfigReader& c) { return read_field_of_places(c); });
  };
  const survey::ReferenceField many = read(kWmm + "height_m = 120").at(60.5 * kDegree, 2.5 * kDegree);
  const survey::ReferenceField one = field_of(kWmm + kPlace + "height_m = 120");
  CHECK(many.total == one.total);
  CHECK(many.dip == one.dip);
  CHECK(many.declination == one.declination);
  CHECK(many.gravity == one.gravity);
  CHECK(many.convergence == 0);
  // Beside the north magnetic pole, where a survey would be refused.
  CHECK(read(kWmm).at(85 * kDegree, 138 * kDegree).dip > 88 * kDegree);
  CHECK_THROWS_WITH(read(kWmm + kPlace),
                    Contains("field.latitude_deg") && Contains("not together with places of a map"));
  CHECK_THROWS_WITH(read(kWmm + "dip_deg = 72"), Contains("which gives it"));
  CHECK_THROWS_WITH(read("date = 2026-01-01"), Contains("field.model: missing"));
}
