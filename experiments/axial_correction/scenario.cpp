#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "axial_correction/study.h"
#include "base/error.h"
#include "base/units.h"
#include "compare/trial_plan.h"
#include "config/meanings.h"
#include "config/suggest.h"
#include "scenario/reference_field.h"
#include "scenario/station_sigmas.h"

namespace surveymc::studies::axial_correction {
namespace {

constexpr std::size_t kMostPoints = 4'000'000, kMostStations = 200;
constexpr double kVertical = 1e-15;  // sin I below this is the rounding of pi

std::vector<single_station::StationMethod> read_methods(config::ConfigReader& c,
                                                        const single_station::StationSigmas& sigmas) {
  const std::vector<std::string>& known = single_station::station_method_names();
  const std::vector<std::string> names =
      c.has("methods") ? c.texts("methods", "methods of the correction; without it all but 'optimising'")
                       : std::vector<std::string>{"basic", "simple", "extended", "extended_bh"};
  std::vector<single_station::StationMethod> methods;
  for (const std::string& n : names) {
    c.require(std::find(known.begin(), known.end(), n) != known.end(), "methods", config::none_of(n, known));
    c.require(std::count(names.begin(), names.end(), n) == 1, "methods", n + " is in the list twice");
    methods.push_back(single_station::station_method(n));
    scenario::require_station_sigmas(c, "methods", methods.back(), sigmas);
  }
  c.require(!methods.empty(), "methods", "must name at least one");
  return methods;
}

void read_stations(config::ConfigReader& c, Scenario& s) {
  const std::vector<double> inclination = c.grid("monte_carlo.inclination_deg", config::Range::closed(0, 180),
                                                 "inclinations at which trials are drawn"),
                            azimuth = c.grid("monte_carlo.magnetic_azimuth_deg", config::Range::closed(-360, 360),
                                             "azimuths at which trials are drawn");
  const auto add = [&](double inclination_deg, double azimuth_deg) {
    s.station_inclination_deg.push_back(inclination_deg);
    s.station_azimuth_deg.push_back(azimuth_deg);
    survey::Attitude at{inclination_deg * kDegree, azimuth_deg * kDegree, s.toolface};
    if (std::sin(at.inclination) < kVertical) at.toolface = 0;  // there only azimuth + toolface can be read
    s.stations.push_back(at);
  };
  if (c.choice("monte_carlo.stations", {"product", "profile"},
               "'product': each inclination with each azimuth; 'profile': the two lists side by side",
               "product") == "profile") {
    c.require(azimuth.size() == inclination.size() || azimuth.size() == 1, "monte_carlo.magnetic_azimuth_deg",
              "of a profile: one for all stations, or as many as inclinations");
    for (std::size_t k = 0; k < inclination.size(); ++k) add(inclination[k], azimuth[azimuth.size() == 1 ? 0 : k]);
  } else {
    for (const double i : inclination)
      for (const double a : azimuth) add(i, a);
  }
  c.require(s.stations.size() <= kMostStations, "monte_carlo.inclination_deg",
            fmt::format("{} attitudes: at most {}", s.stations.size(), kMostStations));
}

std::vector<ExpectedVerdict> read_expected(config::ConfigReader& c, const Scenario& s) {
  std::vector<ExpectedVerdict> all;
  for (config::ConfigReader& e :
       c.tables("expect_attitude", "verdicts that are expected of attitudes in the table `verification`")) {
    ExpectedVerdict x;
    x.methods = e.texts("methods", "methods that are meant");
    x.quantities = e.texts("quantities", "quantities that are meant");
    for (const std::string& m : x.methods) {
      std::vector<std::string> known;
      for (std::size_t k = 0; k < s.methods.size(); ++k) known.push_back(s.name_of(k));
      e.require(std::find(known.begin(), known.end(), m) != known.end(), "methods",
                fmt::format("\"{}\" is not among the methods of this config{}", m, config::suggestion(m, known)));
    }
    for (const std::string& q : x.quantities)
      e.require(q == "azimuth" || q == "axial_magnetisation" || q == "over_tolerance", "quantities",
                config::none_of(q, {"azimuth", "axial_magnetisation", "over_tolerance"}));
    if (e.has("inclination_deg"))
      x.inclination_deg = e.number_or_list("inclination_deg", config::Range::closed(0, 180),
                                           "inclinations that are meant; without it all");
    if (e.has("magnetic_azimuth_deg"))
      x.azimuth_deg = e.number_or_list("magnetic_azimuth_deg", config::Range::closed(-360, 360),
                                       "azimuths that are meant; without it all");
    x.verdict = e.choice("verdict", {"agrees", "differs", "undecided"}, config::meaning::kExpectedVerdict);
    if (e.matches_point("at")) all.push_back(std::move(x));
  }
  return all;
}

}  // namespace

const std::array<ProfileQuantity, kProfileQuantities>& profile_quantities() {
  static constexpr std::array<ProfileQuantity, kProfileQuantities> all{{{"azimuth", "deg", 1 / kDegree},
                                                                        {"inclination", "deg", 1 / kDegree},
                                                                        {"toolface", "deg", 1 / kDegree},
                                                                        {"gravity", "mg", 1000 / 9.80665},
                                                                        {"horizontal_field", "nT", 1},
                                                                        {"vertical_field", "nT", 1},
                                                                        {"axial_magnetisation", "nT", 1}}};
  return all;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.field = scenario::read_field_of_magnetic_north(c);
  c.require(std::abs(s.field.dip) < 89.999 * kDegree, "field.dip_deg", "must leave a horizontal field: |dip| < 89.999");
  s.sigmas = scenario::read_station_sigmas(c);
  s.methods = read_methods(c, s.sigmas);
  const config::Range any = config::Range::closed(-1e6, 1e6);
  const std::vector<double> bias = c.numbers(
      "error.magnetometer_bias_nT", any, "constant bias of the magnetometers x, y, z", 3, std::vector<double>{0, 0, 0});
  s.errors = {
      {bias[0], bias[1], bias[2]},
      c.number("error.axial_magnetisation_nT", any, "constant axial magnetisation", 0.0),
      c.number("error.horizontal_nT", any, "constant error of the horizontal reference field, reference less truth",
               0.0),
      c.number("error.vertical_nT", any, "constant error of the vertical reference field, reference less truth", 0.0)};
  s.toolface = c.number("toolface_deg", config::Range::closed(-360, 360),
                        "toolface from y; matters for `error.magnetometer_bias_nT` only", 0.0) *
               kDegree;
  s.inclination_deg = c.grid("inclination_deg", config::Range::closed(0, 180), "inclinations of the maps");
  s.azimuth_deg = c.grid("magnetic_azimuth_deg", config::Range::closed(-360, 360), "magnetic azimuths of the maps");
  c.require(s.inclination_deg.size() * s.azimuth_deg.size() * s.methods.size() <= kMostPoints, "inclination_deg",
            fmt::format("more than {} points in all", kMostPoints));
  s.tolerance = c.number("tolerance.azimuth_deg", config::Range{0, 180, true, false},
                         "largest azimuth error that is accepted, in the table `failures`", 1.0) *
                kDegree;
  std::vector<compare::Row> rows;
  if (c.has("monte_carlo")) {
    s.trials = static_cast<std::uint64_t>(c.integer("trials", 20, 1'000'000'000'000, config::meaning::kTrials));
    read_stations(c, s);
    s.axial_is_drawn =
        c.choice("monte_carlo.axial_magnetisation", {"drawn", "given"},
                 "'drawn': at every station by its sigma, without constant errors; 'given': the errors of `[error]`",
                 "drawn") == "drawn";
    for (std::size_t m = 0; m < s.methods.size(); ++m)
      for (const ProfileQuantity& q : profile_quantities()) rows.push_back({"profile", s.name_of(m), q.name});
  } else {
    c.integer("trials", 0, 1'000'000'000'000, config::kMeaningElsewhere, 0);  // nothing is drawn
  }
  s.verdict = compare::read_verdict_rule(c);
  s.expected = read_expected(c, s);
  s.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return s;
}

sensor::StationTruth station_truth(const Scenario& s, const survey::Attitude& given, const ConstantErrors& e) {
  survey::Attitude at = given;
  if (std::sin(at.inclination) < kVertical) at.toolface = 0;
  survey::Vec3<double> down = survey::down_T(at);
  if (std::sin(at.inclination) < kVertical) down = {0, 0, std::cos(at.inclination)};
  const double bh = s.field.total * std::cos(s.field.dip), bd = s.field.total * std::sin(s.field.dip);
  return {
      scale(s.field.gravity, down),
      survey::magnetic_T(at, s.field.total, s.field.dip) + e.magnetometer_bias + survey::Vec3<double>{0, 0, e.axial},
      s.field.gravity,
      bh + e.horizontal,
      bd + e.vertical,
      e.axial};
}

Prediction predict_azimuth_errors(const Scenario& s, const survey::Attitude& at, single_station::StationMethod method,
                                  const ConstantErrors& errors, const single_station::StationSigmas& actual) {
  const sensor::StationTruth t = station_truth(s, at, errors);
  Prediction p;
  p.solution = single_station::solve_station(t.gravity_T, t.magnetic_T, {t.reference_gravity, t.horizontal, t.vertical},
                                             s.sigmas, method);
  if (!p.solution.determined) {
    p.azimuth_error = p.axial_error = kInfinity;
    p.covariance.setConstant(kInfinity);
    return p;
  }
  p.azimuth_error = std::remainder(p.solution.attitude.azimuth - at.azimuth, 2 * kPi);
  p.axial_error = p.solution.axial - errors.axial;
  p.covariance = single_station::station_covariance(p.solution, s.sigmas, method, actual);
  return p;
}

}  // namespace surveymc::studies::axial_correction
