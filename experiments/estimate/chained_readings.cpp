#include "estimate/chained_readings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "chained/attitude.h"
#include "chained/axial_profile.h"
#include "chained/basic_solution.h"
#include "chained/mode_search.h"
#include "chained/reading_tests.h"
#include "chained/smoother.h"
#include "compare/table_rows.h"
#include "compare/verdict.h"
#include "config/meanings.h"
#include "config/readings_csv.h"
#include "estimate/run_tables.h"
#include "scenario/chain_sizes.h"
#include "scenario/input_remarks.h"
#include "scenario/scenario.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::studies::estimate {
namespace {

constexpr std::array<const char*, 6> kReadings{"gx", "gy", "gz", "bx", "by", "bz"};

struct Run {
  survey::ReferenceField field;
  survey::SixAxisReadings file;
  double accelerometer_sign = -1;  ///< from specific force to the sign of the file
  chained::Readings readings;
  chained::Model model;
  bool filter = false;
  chained::Gate gate;
  double confidence = 0.95, alpha = 0.05;
  config::ConfigPlace place;  ///< of the file
};

Run read_run(config::ConfigReader& c) {
  Run r;
  r.field = scenario::read_field(c);
  const bool gravity = c.choice("accelerometers", {"gravity", "specific_force"}, config::meaning::kAccelerometers,
                                "gravity") == "gravity";
  r.file = config::readings_from_table(
      scenario::read_readings_table(c),
      {gravity ? config::AccelerometerSign::gravity : config::AccelerometerSign::specific_force, r.field.gravity,
       r.field.total, 1});
  scenario::remark_on_readings(c, r.file, r.field);
  r.accelerometer_sign = -r.file.accelerometer_sign;
  for (std::size_t k = 0; k < r.file.md.size(); ++k) {
    const survey::Vec3<double>&g = r.file.gravity_T[k], &b = r.file.magnetic_T[k];
    r.readings.y.push_back({-g.x, -g.y, -g.z, b.x, b.y, b.z});
  }
  const bool chained = c.choice("estimator.references", {"chained", "independent"},
                                "'independent': references are observed anew at every station", "chained") == "chained";
  const chained::ChainSizes sizes = scenario::read_chain_sizes(c, r.field, !chained);
  const auto stations = static_cast<std::int64_t>(r.file.md.size());
  const int offset_stations =
      static_cast<int>(c.integer("model.offset_stations", 1, 100'000, config::meaning::kOffsetStations, stations));
  r.model = chained::make_model(sizes, offset_stations,
                                chained ? chained::ChainReferences::chained : chained::ChainReferences::independent);
  r.filter = c.choice("estimator.mode", {"smoother", "filter"},
                      "'filter': stations and parameters by the filter; tests and modes stay the smoother's",
                      "smoother") == "filter";
  r.confidence =
      c.number("confidence", config::Range::open(0, 1), config::meaning::kConfidenceOfIntervals, r.confidence);
  r.alpha = c.number("tests.alpha", config::Range::open(0, 1), "level of the tests of the whole run", r.alpha);
  r.gate.gate = c.number("tests.gate", config::Range::open(0, 100),
                         "a reading is rejected beyond this normalised residual", r.gate.gate);
  r.gate.dominance = c.number("tests.dominance", config::Range::non_negative(),
                              "a reading dominates if its squared residual is so much above the next of its station",
                              r.gate.dominance);
  c.require(!c.has("noise"), "noise", "estimator \"chained\" takes its sizes from [model]");
  if (c.has("trials")) c.integer("trials", 0, 1'000'000'000'000, config::meaning::kUnusedTrials);
  r.place = c.place("readings");
  c.finish();
  return r;
}

/// The solution: all modes of the smoother; the filter, if asked for, from the lowest mode's attitudes.
struct Answer {
  chained::Modes modes;
  chained::Solution solution;
  chained::ReadingTests tests;  ///< of the smoother's residuals, whichever was asked for
  chained::Suspect suspect;
  std::vector<chained::AxialProfile> profiles;  ///< of the smoother
};

/// Profiles of every station; in long runs of a hundred stations, so that the work stays linear in stations.
std::vector<chained::AxialProfile> profiles_of(const Run& r, const chained::Modes& modes) {
  constexpr int kMost = 100;
  std::vector<chained::AxialProfile> out;
  const int n = r.readings.stations(), most = std::min(n, kMost);
  chained::AxialProfileOptions options;
  options.confidence = r.confidence;
  for (int i = 0; i < most; ++i) {
    const int k = most < 2 ? 0 : static_cast<int>(static_cast<std::int64_t>(i) * (n - 1) / (most - 1));
    out.push_back(chained::profile_azimuth(r.model, r.readings, modes.modes, k, options));
  }
  return out;
}

Answer answer_of(const Run& r) {
  Answer a;
  chained::SearchOptions options;
  options.attitudes = r.readings.stations() <= 200;  // the basic solution begins well enough in long runs
  a.modes = chained::find_modes(r.model, r.readings, options);
  require(!a.modes.modes.empty(), "chained: no minimum was found: are units, signs and reference those of the run?");
  a.solution = a.modes.modes.front();
  a.tests = chained::reading_tests(r.model, r.readings, a.solution);
  a.suspect = chained::find_suspect(a.tests, r.gate);
  a.profiles = profiles_of(r, a.modes);
  if (r.filter) {
    a.solution = chained::run_filter(r.model, r.readings, chained::point_of(a.solution));
    require(a.solution.converged, "chained: the filter does not converge at some station ({}): use mode = \"smoother\"",
            stats::kDescentStatusNames[static_cast<std::size_t>(a.solution.status)]);
  }
  return a;
}

double degrees_of(double angle) {
  const double x = std::remainder(angle, 2 * kPi) / kDegree;
  return x < 0 ? x + 360 : x;
}

store::Table stations_table(const Run& r, const Answer& a) {
  compare::TableRows t("stations", "attitude of every station, one standard deviation each");
  const auto angle = [&](const char* name, const char* meaning, double x) { t.number(name, "deg", meaning, x); };
  for (std::size_t k = 0; k < r.readings.y.size(); ++k) {
    const chained::StationEstimate& s = a.solution.stations[k];
    const survey::Attitude at = chained::attitude_of(s.frame),
                           raw = chained::attitude_of(chained::basic_station(r.readings.y[k]).frame);
    const Eigen::Matrix3d c = s.covariance.topLeftCorner<3, 3>(), g = chained::attitude_derivatives(s.frame);
    const Eigen::Vector3d sd = chained::attitude_sd(s.frame, c);
    const double correlation = g.row(0).dot(c * g.row(1).transpose()) / (sd[0] * sd[1]),
                 true_azimuth = at.azimuth + r.field.declination;
    t.number("md_m", "m", "measured depth", r.file.md[k]);
    angle("inclination_deg", "toolface from y", at.inclination / kDegree);
    angle("toolface_deg", "toolface from y", degrees_of(at.toolface));
    angle("raw_azimuth_magnetic_deg", "basic solution of the readings as they are", degrees_of(raw.azimuth));
    angle("azimuth_magnetic_deg", "from magnetic north", degrees_of(at.azimuth));
    angle("azimuth_true_deg", "from true north", degrees_of(true_azimuth));
    angle("azimuth_grid_deg", "from grid north", degrees_of(true_azimuth - r.field.convergence));
    angle("sd_inclination_deg", "one standard deviation", sd[0] / kDegree);
    angle("sd_toolface_deg", "one standard deviation; absent in a vertical hole", sd[2] / kDegree);
    angle("sd_azimuth_deg", "one standard deviation; absent in a vertical hole", sd[1] / kDegree);
    t.number("correlation_azimuth_inclination", "1", "of the two errors", std::isfinite(sd[1]) ? correlation : kNaN);
    for (std::size_t i = 0; i < 6; ++i)
      t.number(std::string("w_") + kReadings[i], "1", "normalised residual: standard normal if nothing is wrong",
               a.tests.w[k][i] * (i < 3 ? r.accelerometer_sign : 1));
  }
  return t.take();
}

store::Table parameters_table(const Run& r, const Answer& a) {
  static constexpr std::array<const char*, chained::kChainStates> kNames{"gravity_error_mg",
                                                                         "horizontal_error_nT",
                                                                         "down_error_nT",
                                                                         "accelerometer_bias_x_mg",
                                                                         "accelerometer_bias_y_mg",
                                                                         "accelerometer_bias_z_mg",
                                                                         "bias_x_nT",
                                                                         "bias_y_nT",
                                                                         "bias_z_nT"};
  compare::TableRows t(
      "parameters",
      "errors of the reference (truth less reference) and biases of the sensors (in the sign of the file), "
      "station by station" +
          compare::at_confidence(r.confidence));
  const double z = stats::normal_quantile((1 + r.confidence) / 2);
  for (std::size_t k = 0; k < r.readings.y.size(); ++k)
    for (std::size_t i = 0; i < chained::kChainStates; ++i) {
      const auto state = static_cast<Eigen::Index>(i);
      const bool accelerometer = i >= chained::kAccelerometerOffset && i < chained::kMagnetometerOffset;
      const double unit = i == chained::kGravityError || accelerometer ? kMilliG : 1;
      const chained::StationEstimate& s = a.solution.stations[k];
      const double x = s.chain[state] / unit * (accelerometer ? r.accelerometer_sign : 1),
                   sd = std::sqrt(s.covariance(3 + state, 3 + state)) / unit;
      t.count("station", "number of the station, from 1", k + 1);
      t.number("md_m", "m", "measured depth", r.file.md[k]);
      t.word("quantity", "with its unit: mg or nT", kNames[i]);
      t.number("estimate", "1", "in the unit of the quantity", x, "ci_low ci_high");
      t.number("sd", "1", "one standard deviation", sd);
      t.number("ci_low", "1", "lower bound of the confidence interval", x - z * sd);
      t.number("ci_high", "1", "upper bound of the confidence interval", x + z * sd);
    }
  return t.take();
}

store::Table fit_table(const Run& r, const Answer& a) {
  compare::TableRows t("fit", "the minimum, and whether there is another");
  const double equations = 3.0 * r.readings.stations();
  const chained::Solution& best = a.modes.modes.front();
  t.count("stations", "stations of the run", r.readings.stations());
  t.count("redundancy", "equations less unknowns: three a station", 3 * r.readings.stations());
  t.number("cost", "1", "sum of the squared whitened equations at the lowest minimum", best.cost);
  t.number("p_value", "1", "of the cost under chi-squared(redundancy), upper tail",
           stats::chi_squared_upper_tail(equations, best.cost));
  t.count("iterations", "of the solver", best.iterations);
  t.count("modes", "different minima found", a.modes.modes.size());
  t.count("ambiguous", "1: a second minimum explains the readings almost as well", a.modes.ambiguous);
  t.number("cost_of_second", "1", "its cost", a.modes.modes.size() > 1 ? a.modes.modes[1].cost : kNaN);
  return t.take();
}

/// Every minimum of the smoother, so that a user who knows the well can choose.
store::Table modes_table(const Run& r, const Answer& a) {
  compare::TableRows t("modes", "minima of the smoother, lowest cost first; bias_z is the mean over the stations");
  for (std::size_t i = 0; i < a.modes.modes.size(); ++i) {
    const chained::Solution& m = a.modes.modes[i];
    double bias = 0;
    for (const chained::StationEstimate& s : m.stations)
      bias += s.chain[chained::kMagnetometerOffset + 2] / static_cast<double>(m.stations.size());
    for (std::size_t k = 0; k < m.stations.size(); ++k) {
      const survey::Attitude at = chained::attitude_of(m.stations[k].frame);
      t.count("mode", "from 1", i + 1);
      t.number("cost", "1", "J", m.cost);
      t.number("bias_z_nT", "nT", "axial magnetometer bias", bias);
      t.count("station", "number of the station, from 1", k + 1);
      t.number("md_m", "m", "measured depth", r.file.md[k]);
      t.number("inclination_deg", "deg", "of the station in this mode", at.inclination / kDegree);
      t.number("azimuth_magnetic_deg", "deg", "of the station in this mode", degrees_of(at.azimuth));
    }
  }
  return t.take();
}

/// Whether the claims hold, and the intervals that hold where the claims do not.
store::Table profile_table(const Run& r, const Answer& a) {
  compare::TableRows t(
      "profile",
      "the smoother's claims against the cost, minimised at values of the station's axial bias; azimuth: by the "
      "covariance where the claims hold, else by the mixture over the bias" +
          compare::at_confidence(r.confidence));
  const auto angle = [&](const char* name, const char* meaning, double x) { t.number(name, "deg", meaning, x); };
  for (const chained::AxialProfile& p : a.profiles) {
    t.count("station", "number of the station, from 1", p.station + 1);
    t.number("md_m", "m", "measured depth", r.file.md[static_cast<std::size_t>(p.station)]);
    t.count("claims_hold", "1: the cost rises as the covariance says, and there is one minimum", p.parabola);
    t.number("cost_rise_low", "1", "of the cost at the axial bias less 2 claimed sd: 4 where the claims hold",
             p.rise_low);
    t.number("cost_rise_high", "1", "of the cost at the axial bias and 2 claimed sd: 4 where the claims hold",
             p.rise_high);
    t.number("bias_z_nT", "nT", "axial bias at the lowest minimum", p.bias);
    t.number("claimed_sd_bias_z_nT", "nT", "by the covariance", p.claimed_sd);
    t.number("sd_bias_z_nT", "nT", "by the profile", p.sd_bias);
    angle("azimuth_magnetic_deg", "at the lowest minimum", degrees_of(p.azimuth));
    angle("claimed_sd_azimuth_deg", "by the covariance", p.azimuth_claimed_sd / kDegree);
    angle("mean_azimuth_magnetic_deg", "by the profile", degrees_of(p.azimuth_mean));
    angle("sd_azimuth_deg", "by the profile", p.azimuth_sd / kDegree);
    angle("azimuth_magnetic_ci_low_deg", "lower bound of the confidence interval by the profile",
          degrees_of(p.azimuth_low));
    angle("azimuth_magnetic_ci_high_deg", "upper bound; below the lower one where the interval contains north",
          degrees_of(p.azimuth_high));
    t.count("complete", "0: a part of the profile was not found", p.complete);
  }
  return t.take();
}

/// A row of the table `tests`: the run as a whole, or a reading.
struct TestRow {
  std::string test, component, unit;
  std::size_t station = 0;  ///< from 1; 0 for the run
  double md = kNaN, statistic, low, high, p_value, error = kNaN, error_sd = kNaN, detectable = kNaN;
  std::string note;
};

store::Table tests_table(const Run& r, const Answer& a) {
  const double equations = 3.0 * r.readings.stations(), cost = a.modes.modes.front().cost,
               low = stats::chi_squared_quantile(equations, r.alpha / 2),
               high = stats::chi_squared_quantile(equations, 1 - r.alpha / 2),
               tail = stats::chi_squared_upper_tail(equations, cost);
  std::vector<TestRow> rows{{"cost", "", "", 0, kNaN, cost, low, high, 2 * std::min(tail, 1 - tail), kNaN, kNaN, kNaN,
                             cost > high  ? "more than the noise of the model: a gross error, a wrong reference, or "
                                            "more noise"
                             : cost < low ? "less than the noise of the model: its sizes are too large"
                                          : ""}};
  for (std::size_t k = 0; k < a.tests.w.size(); ++k)
    for (std::size_t i = 0; i < 6; ++i) {
      const double x = a.tests.w[k][i], s = a.tests.sensitivity[k][i], unit = i < 3 ? kMilliG : 1,
                   sign = i < 3 ? r.accelerometer_sign : 1, sd = r.model.noise[i] / s / unit;
      const bool suspect = a.suspect.found && a.suspect.station == static_cast<int>(k) && a.suspect.axis == i;
      rows.push_back({"reading", kReadings[i], i < 3 ? "mg" : "nT", k + 1, r.file.md[k], sign * x, -r.gate.gate,
                      r.gate.gate, 2 * stats::normal_upper_tail(std::abs(x)), sign * x * sd, sd,
                      chained::minimal_detectable(r.model, a.tests, k, i, r.gate.gate) / unit,
                      !suspect             ? ""
                      : a.suspect.dominant ? "the suspect; it dominates its station clearly"
                                           : "the station is suspect; which of its readings is not clear"});
    }
  compare::TableRows t("tests", "does the run as a whole, and does every reading, fit the model");
  for (const TestRow& x : rows) {
    t.word("test", "cost (chi-squared of the run) or reading (w, standard normal)", x.test);
    t.count("station", "number of the station, from 1; 0 for the run as a whole", x.station);
    t.number("md_m", "m", "measured depth of the station", x.md);
    t.word("component", "accelerometer g, magnetometer b, axis", x.component);
    t.test(x.statistic, x.low, x.high, x.p_value);
    t.word("unit", "of error and minimal_detectable_error", x.unit);
    t.number("error", "1", "size of the error in this reading, if it is the only one", x.error);
    t.number("sd_error", "1", "its standard deviation", x.error_sd);
    t.number("minimal_detectable_error", "1", "found with a probability of 80 %", x.detectable);
    t.word("decision", "accepted or rejected", x.statistic < x.low || x.statistic > x.high ? "rejected" : "accepted");
    t.word("note", "what follows", x.note);
  }
  return t.take();
}

std::vector<analysis::Warning> warnings_of(const Run& r, const Answer& a) {
  std::vector<analysis::Warning> warnings;
  const double equations = 3.0 * r.readings.stations(), cost = a.modes.modes.front().cost;
  if (a.modes.ambiguous)
    warnings.push_back({"severe", fmt::format("ambiguous: a second minimum has cost {:.2f}, the first {:.2f}; table "
                                              "`modes` has both: choose by what is known of the well",
                                              a.modes.modes[1].cost, cost)});
  const chained::AxialProfile* worst = nullptr;
  std::size_t unheld = 0;
  for (const chained::AxialProfile& p : a.profiles) {
    if (p.parabola || std::isnan(p.azimuth_claimed_sd)) continue;
    ++unheld;
    if (!worst || p.azimuth_sd / p.azimuth_claimed_sd > worst->azimuth_sd / worst->azimuth_claimed_sd) worst = &p;
  }
  if (worst)
    warnings.push_back(
        {"severe",
         fmt::format(
             "the claimed sd do not hold at {} of {} stations looked at: the cost is no parabola along the axial "
             "bias. At station {} the azimuth's sd is {:.3g} deg, not {:.3g}: use the intervals of table "
             "`profile`{}",
             unheld, a.profiles.size(), worst->station + 1, worst->azimuth_sd / kDegree,
             worst->azimuth_claimed_sd / kDegree,
             worst->complete ? "" : ", which is incomplete: a wider one cannot be excluded")});
  if (cost > stats::chi_squared_quantile(equations, 1 - r.alpha / 2))
    warnings.push_back(
        {"severe", fmt::format("cost {:.2f} (expected {:.0f}): a gross error, a wrong reference, or more "
                               "noise than [model] says",
                               cost, equations)});
  if (a.suspect.found)
    warnings.push_back(
        {"warning",
         fmt::format("station {} (md {:g} m) is suspect: {} has w = {:.2f} (gate {:g}){}", a.suspect.station + 1,
                     r.file.md[static_cast<std::size_t>(a.suspect.station)], kReadings[a.suspect.axis],
                     a.suspect.w * (a.suspect.axis < 3 ? r.accelerometer_sign : 1), r.gate.gate,
                     a.suspect.dominant ? "" : "; another of its readings is nearly as bad: do not delete one alone")});
  if (r.filter)
    warnings.push_back({"info", "stations and parameters are those of the filter; tests and modes of the smoother"});
  return warnings;
}

std::vector<store::Table> tables_of(const Run& r) {
  const Answer a = answer_of(r);
  return {parameters_table(r, a),
          fit_table(r, a),
          modes_table(r, a),
          stations_table(r, a),
          profile_table(r, a),
          tests_table(r, a),
          warnings_table(warnings_of(r, a))};
}

}  // namespace

std::unique_ptr<study::PointPlan> chained_readings_result(config::ConfigReader& config) {
  return std::make_unique<EstimatePlan<Run, tables_of>>(read_run(config));
}

}  // namespace surveymc::studies::estimate
