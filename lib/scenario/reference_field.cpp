#include "scenario/reference_field.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "config/meanings.h"
#include "earth/geodesy.h"

namespace surveymc::scenario {
namespace {

constexpr double kLowest = -1000, kHighest = 850'000;  // m: where WMM is specified

earth::Place read_place(config::ConfigReader& c) {
  earth::Place p;
  p.latitude = c.number("field.latitude_deg", config::Range::closed(-90, 90), config::meaning::kLatitude) * kDegree;
  p.longitude =
      c.number("field.longitude_deg", config::Range::closed(-180, 360), "longitude of the well, WGS84, east positive") *
      kDegree;
  return p;
}

std::string angle_text(double radians, char positive, char negative) {
  const double degrees = radians / kDegree;
  return fmt::format("{:.6g} {}", std::abs(degrees), degrees < 0 ? negative : positive);
}

std::string place_text(const earth::Place& p) {
  const double east = p.longitude > kPi ? p.longitude - 2 * kPi : p.longitude;
  return fmt::format("{}, {}, {:g} m", angle_text(p.latitude, 'N', 'S'), angle_text(east, 'E', 'W'), p.height);
}

/// "wmm2025: the horizontal field is 907 nT, which lies in the blackout zone of the north magnetic pole (...)".
std::string zone_text(const char* zone, double below, const earth::MagneticElements& e) {
  return fmt::format(
      "the horizontal field there is {:.0f} nT: in the {} zone of wmm2025 about the {} magnetic pole (below {:g} nT)",
      e.horizontal, zone, e.vector.down > 0 ? "north" : "south", below);
}

double convergence_of_grid(config::ConfigReader& c, const earth::Place& place) {
  c.choice("field.grid.crs", {"utm"},
           "grid of the map: Universal Transverse Mercator, between 80 deg south and 84 deg north; gives the "
           "convergence, also without `field.model`");
  c.require(earth::has_utm(place), "field.latitude_deg",
            "there is no UTM grid: it ends at 80 degrees south and 84 degrees north; give convergence_deg instead of "
            "grid");
  if (!c.has("field.grid.zone")) return earth::utm_convergence(place, earth::utm_zone(place));
  const auto zone = static_cast<int>(c.integer(
      "field.grid.zone", 1, 60,
      "zone of the grid, whose central meridian is at most 6 deg from the place; without it that of the place"));
  // A field that lies on both sides of a zone's edge is mapped in one of them: up to half a zone beyond the edge.
  constexpr double kFarthest = 6 * kDegree;
  const double distance = earth::distance_from_central_meridian(place, zone);
  c.require(
      distance <= kFarthest + 1e-9, "field.grid.zone",
      fmt::format("the place lies {:.4g} degrees from the central meridian of this zone, at most {:g} are in use; "
                  "that of the place is {}",
                  distance / kDegree, kFarthest / kDegree, earth::utm_zone(place)));
  return earth::utm_convergence(place, zone);
}

/// `place`: nothing if it has not been read.
double convergence_at(config::ConfigReader& c, const std::optional<earth::Place>& place) {
  if (!c.has("field.grid"))
    return c.number("field.convergence_deg", config::Range::closed(-180, 180), config::meaning::kConvergence, 0) *
           kDegree;
  if (c.has("field.convergence_deg")) c.fail("field.convergence_deg", "not together with grid, which gives it");
  return convergence_of_grid(c, place ? *place : read_place(c));
}

/// Of field.model, beside which stands nothing that it gives.
std::string read_model_name(config::ConfigReader& c) {
  const std::string name = c.choice(
      "field.model", kFieldModels,
      "model that gives total field, dip, declination and gravity of the place; these keys may not stand beside it");
  for (const char* key : {"field.total_nT", "field.dip_deg", "field.declination_deg", "field.gravity_mps2"})
    if (c.has(key))
      c.fail(key, fmt::format("not together with field.model = \"{}\", which gives it: take one away", name));
  return name;
}

double read_height(config::ConfigReader& c) {
  return c.number("field.height_m", config::Range::closed(kLowest, kHighest),
                  "height above the ellipsoid; heights above the sea differ by up to 100 m (2.5 nT)", 0);
}

double read_year(config::ConfigReader& c, const earth::GeomagneticModel& model, const std::string& name) {
  const double year = c.decimal_year("field.date", "day of the survey, within the model's life from 2025.0 to 2030.0");
  c.require(model.is_valid_in(year), "field.date",
            fmt::format("{} is valid from {:.1f} to {:.1f}", name, model.epoch(), model.end()));
  return year;
}

void refuse_blackout(config::ConfigReader& c, const PlacedField& f) {
  const bool allowed = c.choice("field.blackout", {"refuse", "allow"},
                                "a place in the blackout zone, where the horizontal field is below 2000 nT: 'refuse' "
                                "ends the run, 'allow' warns, as always in the caution zone, below 6000 nT",
                                "refuse") == "allow";
  const earth::MagneticElements e = earth::magnetic_elements(f.magnetic.vector);
  if (f.zone == earth::CompassZone::blackout) {
    const std::string text = zone_text("blackout", earth::kBlackoutBelow, e);
    if (!allowed)
      c.fail("field.latitude_deg",
             text + ", where the model is not for navigation; field.blackout = \"allow\" goes on with a warning");
    c.warn("field.latitude_deg", text, "survey with a gyro: the model is not for navigation there");
  } else if (f.zone == earth::CompassZone::caution) {
    c.warn("field.latitude_deg", zone_text("caution", earth::kCautionBelow, e) + ", where magnetic azimuths are poor",
           "survey with a gyro, or expect large errors of azimuth");
  }
}

}  // namespace

survey::ReferenceField FieldOfPlaces::at(double latitude, double longitude) const {
  const earth::Place place{latitude, longitude, height};
  const earth::MagneticElements e = earth::magnetic_elements(earth::wmm2025().field(place, year).vector);
  return {earth::normal_gravity(place), e.total, e.dip, e.declination, 0};
}

FieldOfPlaces read_field_of_places(config::ConfigReader& c) {
  const std::string name = read_model_name(c);
  for (const char* key : {"field.latitude_deg", "field.longitude_deg", "field.grid", "field.convergence_deg"})
    if (c.has(key)) c.fail(key, "not together with places of a map: azimuths are from true north there");
  FieldOfPlaces f;
  f.height = read_height(c);
  f.year = read_year(c, earth::wmm2025(), name);
  return f;
}

double read_convergence(config::ConfigReader& c) { return convergence_at(c, std::nullopt); }

std::optional<PlacedField> read_placed_field(config::ConfigReader& c) {
  if (!c.has("field.model")) {
    for (const char* key : {"field.date", "field.height_m", "field.blackout"})
      if (c.has(key)) c.fail(key, "only with field.model = \"wmm2025\"");
    // A latitude may stand alone: gyros need it. A study that reads none says so itself.
    if (!c.has("field.grid") && c.has("field.longitude_deg"))
      c.fail("field.longitude_deg", "only with field.model = \"wmm2025\" or field.grid");
    return std::nullopt;
  }
  const std::string name = read_model_name(c);
  const earth::GeomagneticModel& model = earth::wmm2025();
  PlacedField f;
  f.place = read_place(c);
  f.place.height = read_height(c);
  f.year = read_year(c, model, name);
  f.magnetic = model.field(f.place, f.year);
  const earth::MagneticElements e = earth::magnetic_elements(f.magnetic.vector);
  f.zone = earth::compass_zone(e.horizontal);
  refuse_blackout(c, f);
  c.require(std::abs(e.dip) < 89.99 * kDegree, "field.latitude_deg",
            "the horizontal field vanishes there: there is no magnetic azimuth");
  f.field = {earth::normal_gravity(f.place), e.total, e.dip, e.declination, convergence_at(c, f.place)};
  c.note(
      fmt::format("reference field of {} at {}, {:.2f}: {:.1f} nT, dip {:.3f} deg, declination {:.3f} deg (sd {:.2f}), "
                  "convergence {:.3f} deg, gravity {:.5f} m/s2",
                  name, place_text(f.place), f.year, e.total, e.dip / kDegree, e.declination / kDegree,
                  earth::wmm2025_uncertainty(e.horizontal).declination / kDegree, f.field.convergence / kDegree + 0.0,
                  f.field.gravity));
  return f;
}

survey::ReferenceField read_field(config::ConfigReader& c) {
  if (const std::optional<PlacedField> placed = read_placed_field(c)) return placed->field;
  survey::ReferenceField f;
  f.total = c.number("field.total_nT", config::Range::closed(1e3, 1e6), config::meaning::kTotalField);
  f.dip = c.number("field.dip_deg", config::Range::closed(-90, 90), config::meaning::kDip) * kDegree;
  c.require(std::abs(f.dip) < 89.99 * kDegree, "field.dip_deg",
            "the horizontal field vanishes: there is no magnetic azimuth");
  f.declination =
      c.number("field.declination_deg", config::Range::closed(-180, 180), config::meaning::kDeclination, 0) * kDegree;
  f.convergence = read_convergence(c);
  f.gravity = c.number("field.gravity_mps2", config::Range::closed(9.7, 9.9), config::meaning::kGravity, 9.80665);
  return f;
}

survey::ReferenceField read_field_of_magnetic_north(config::ConfigReader& c) {
  survey::ReferenceField f = read_field(c);
  if (c.has("field.model")) f.declination = 0;
  c.require(f.declination == 0, "field.declination_deg", "must be 0: azimuths are from magnetic north in this study");
  return f;
}

ReferenceSize reference_size(const std::string&) {
  const earth::MagneticUncertainty sd = earth::wmm2025_uncertainty(1);  // total and dip do not depend on the place
  return {sd.total, sd.dip};
}

namespace {

using Numbers = std::vector<double>;

/// Degrees as a config gave them, up to 15 digits: plain division may end in others, 58.4 in 58.400000000000006.
double given_degrees(double radians) {
  const double degrees = radians / kDegree;
  const std::string text = fmt::format("{:.15g}", degrees);
  double given = degrees;
  std::from_chars(text.data(), text.data() + text.size(), given);
  return given * kDegree == radians ? given : degrees;
}

/// Place, date and what studies take from them.
store::Table reference_field_table(const PlacedField& f, const earth::MagneticElements& now,
                                   const earth::MagneticUncertainty& sd) {
  const std::string zone = f.zone == earth::CompassZone::blackout  ? "blackout"
                           : f.zone == earth::CompassZone::caution ? "caution"
                                                                   : "none";
  return {"reference_field",
          "reference field by model, place and date; sd: of the model's error",
          {{"latitude_deg", "deg", "geodetic latitude, north positive", Numbers{given_degrees(f.place.latitude)}},
           {"longitude_deg", "deg", "longitude, east positive", Numbers{given_degrees(f.place.longitude)}},
           {"height_m", "m", "height above the ellipsoid", Numbers{f.place.height}},
           {"decimal_year", "1", "date as decimal year", Numbers{f.year}},
           {"total_nT", "nT", "total field", Numbers{now.total}},
           {"sd_total_nT", "nT", "one sd of the model's total field", Numbers{sd.total}},
           {"dip_deg", "deg", "dip, positive down", Numbers{now.dip / kDegree}},
           {"sd_dip_deg", "deg", "one sd of the model's dip", Numbers{sd.dip / kDegree}},
           {"declination_deg", "deg", "declination, positive east", Numbers{now.declination / kDegree}},
           {"sd_declination_deg", "deg", "one sd of the model's declination", Numbers{sd.declination / kDegree}},
           {"convergence_deg", "deg", "true azimuth less grid azimuth", Numbers{given_degrees(f.field.convergence)}},
           {"gravity_mps2", "mps2", "normal gravity", Numbers{f.field.gravity}},
           {"zone", "", "zone of the compass about the magnetic poles", std::vector<std::string>{zone}}}};
}

/// The seven elements, one row each: value, change in a year, sd of the model's error.
store::Table magnetic_elements_table(const PlacedField& f, const earth::MagneticElements& now,
                                     const earth::MagneticUncertainty& sd) {
  const earth::MagneticElements rate = earth::elements_per_year(f.magnetic.vector, f.magnetic.per_year);
  std::vector<std::string> names, units;
  Numbers values, rates, sds;
  const auto add = [&](const char* name, const char* unit, double value, double per_year, double one_sd) {
    const double size = std::string_view(unit) == "deg" ? kDegree : 1;
    names.emplace_back(name);
    units.emplace_back(unit);
    values.push_back(value / size);
    rates.push_back(per_year / size);
    sds.push_back(one_sd / size);
  };
  add("north", "nT", now.vector.north, rate.vector.north, sd.north);
  add("east", "nT", now.vector.east, rate.vector.east, sd.east);
  add("down", "nT", now.vector.down, rate.vector.down, sd.down);
  add("horizontal", "nT", now.horizontal, rate.horizontal, sd.horizontal);
  add("total", "nT", now.total, rate.total, sd.total);
  add("declination", "deg", now.declination, rate.declination, sd.declination);
  add("dip", "deg", now.dip, rate.dip, sd.dip);
  return {"magnetic_elements",
          "elements of the model's field there: X, Y, Z, H, F, D, I",
          {{"quantity", "", "element", names},
           {"unit", "", "of value and sd; of per_year by year", units},
           {"value", "1", "at the date, in the row's unit", values},
           {"per_year", "1", "its change in a year, in the row's unit", rates},
           {"sd", "1", "one sd, in the row's unit, of the model's error", sds}}};
}

}  // namespace

std::vector<store::Table> field_tables(const PlacedField& f) {
  const earth::MagneticElements now = earth::magnetic_elements(f.magnetic.vector);
  const earth::MagneticUncertainty sd = earth::wmm2025_uncertainty(now.horizontal);
  return {reference_field_table(f, now, sd), magnetic_elements_table(f, now, sd)};
}

}  // namespace surveymc::scenario
