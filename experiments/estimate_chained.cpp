#include "estimate_chained.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "chained_scenario.h"
#include "config/readings_csv.h"
#include "estimate/chained_attitude.h"
#include "estimate/chained_profile.h"
#include "estimate/chained_search.h"
#include "estimate/chained_smoother.h"
#include "estimate/chained_start.h"
#include "estimate/chained_tests.h"
#include "estimate_warnings.h"
#include "stats/intervals.h"
#include "study/table_writer.h"

namespace surveymc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 6> kReadings{"gx", "gy", "gz", "bx", "by", "bz"};

struct Run {
  ReferenceField field;
  SixAxisReadings file;
  double accelerometer_sign = -1;  ///< from specific force to the sign of the file
  ChainedReadings readings;
  ChainedModel model;
  bool filter = false;
  ChainedGate gate;
  double confidence = 0.95, alpha = 0.05;
  ConfigPlace place;  ///< of the file
};

Run read_run(ConfigReader& c) {
  Run r;
  r.field = read_field(c);
  const bool gravity = c.choice("accelerometers", {"gravity", "specific_force"}, "gravity") == "gravity";
  r.file = readings_from_table(
      c.csv("readings"),
      {gravity ? AccelerometerSign::gravity : AccelerometerSign::specific_force, r.field.gravity, r.field.total});
  r.accelerometer_sign = gravity ? -1 : 1;
  for (std::size_t k = 0; k < r.file.md.size(); ++k) {
    const Vec3<double>&g = r.file.gravity_T[k], &b = r.file.magnetic_T[k];
    r.readings.y.push_back({-g.x, -g.y, -g.z, b.x, b.y, b.z});
  }
  const ChainSizes sizes = read_chain_sizes(c, r.field);
  const auto stations = static_cast<std::int64_t>(r.file.md.size());
  const int offset_stations = static_cast<int>(c.integer("model.offset_stations", 1, 100'000, stations));
  const bool chained = c.choice("estimator.references", {"chained", "independent"}, "chained") == "chained";
  r.model = chained_model(sizes, offset_stations, chained ? ChainReferences::chained : ChainReferences::independent);
  r.filter = c.choice("estimator.mode", {"smoother", "filter"}, "smoother") == "filter";
  r.confidence = c.number("confidence", Range::open(0, 1), r.confidence);
  r.alpha = c.number("tests.alpha", Range::open(0, 1), r.alpha);
  r.gate.gate = c.number("tests.gate", Range::open(0, 100), r.gate.gate);
  r.gate.dominance = c.number("tests.dominance", Range::non_negative(), r.gate.dominance);
  c.require(!c.has("noise"), "noise", "estimator \"chained\" takes its sizes from [model]");
  if (c.has("trials")) c.integer("trials", 0, 1'000'000'000'000);
  r.place = c.place("readings");
  c.finish();
  return r;
}

/// The answer: all modes of the smoother; the filter, if asked for, from the lowest mode's attitudes.
struct Answer {
  ChainedModes modes;
  ChainedSolution solution;
  ChainedReadingTests tests;  ///< of the smoother's residuals, whichever was asked for
  ChainedSuspect suspect;
  std::vector<ChainedProfile> profiles;  ///< of the smoother
};

/// Of every station; in long runs of a hundred along it, so that the work stays linear in stations.
std::vector<ChainedProfile> profiles_of(const Run& r, const ChainedModes& modes) {
  constexpr int kMost = 100;
  std::vector<ChainedProfile> out;
  const int n = r.readings.stations(), most = std::min(n, kMost);
  ChainedProfileOptions options;
  options.confidence = r.confidence;
  for (int i = 0; i < most; ++i) {
    const int k = most < 2 ? 0 : static_cast<int>(static_cast<std::int64_t>(i) * (n - 1) / (most - 1));
    out.push_back(profile_azimuth(r.model, r.readings, modes.modes, k, options));
  }
  return out;
}

Answer answer_of(const Run& r) {
  Answer a;
  ChainedSearchOptions options;
  options.attitudes = r.readings.stations() <= 200;  // the basic solution begins well enough in long runs
  a.modes = find_chained_modes(r.model, r.readings, options);
  require(!a.modes.modes.empty(), "chained: no minimum was found: are units, signs and reference those of the run?");
  a.solution = a.modes.modes.front();
  a.tests = chained_reading_tests(r.model, r.readings, a.solution);
  a.suspect = find_suspect(a.tests, r.gate);
  a.profiles = profiles_of(r, a.modes);
  if (r.filter) {
    a.solution = filter_chained(r.model, r.readings, point_of(a.solution));
    require(a.solution.converged, "chained: the filter does not converge at some station ({}): use mode = \"smoother\"",
            kChainedStatusNames[static_cast<std::size_t>(a.solution.status)]);
  }
  return a;
}

double degrees_of(double angle) {
  const double x = std::remainder(angle, 2 * kPi) / kDegree;
  return x < 0 ? x + 360 : x;
}

Table stations_table(const Run& r, const Answer& a) {
  Table t{"stations", "attitude of every station, one standard deviation each"};
  const auto number = [&](const char* name, const char* unit, const char* meaning) {
    t.columns.push_back(number_column(name, unit, meaning));
  };
  number("md_m", "m", "measured depth");
  for (const char* name : {"inclination_deg", "toolface_deg"}) number(name, "deg", "toolface from y");
  number("raw_azimuth_magnetic_deg", "deg", "basic solution of the readings as they are");
  number("azimuth_magnetic_deg", "deg", "from magnetic north");
  number("azimuth_true_deg", "deg", "from true north");
  number("azimuth_grid_deg", "deg", "from grid north");
  number("sd_inclination_deg", "deg", "one standard deviation");
  number("sd_toolface_deg", "deg", "one standard deviation; absent in a vertical hole");
  number("sd_azimuth_deg", "deg", "one standard deviation; absent in a vertical hole");
  number("correlation_azimuth_inclination", "1", "of the two errors");
  for (const char* name : kReadings)
    number((std::string("w_") + name).c_str(), "1", "normalised residual: standard normal if nothing is wrong");
  TableWriter w(std::move(t));
  for (std::size_t k = 0; k < r.readings.y.size(); ++k) {
    const StationEstimate& s = a.solution.stations[k];
    const Attitude at = attitude_of(s.frame), raw = attitude_of(basic_station(r.readings.y[k]).frame);
    const Eigen::Matrix3d c = s.covariance.topLeftCorner<3, 3>(), g = attitude_derivatives(s.frame);
    const Eigen::Vector3d sd = attitude_sd(s.frame, c);
    const double correlation = g.row(0).dot(c * g.row(1).transpose()) / (sd[0] * sd[1]);
    w << r.file.md[k] << at.inclination / kDegree << degrees_of(at.toolface) << degrees_of(raw.azimuth)
      << degrees_of(at.azimuth) << degrees_of(at.azimuth + r.field.declination)
      << degrees_of(at.azimuth + r.field.declination - r.field.convergence) << sd[0] / kDegree << sd[2] / kDegree
      << sd[1] / kDegree << (std::isfinite(sd[1]) ? correlation : kNaN);
    for (std::size_t i = 0; i < 6; ++i) w << a.tests.w[k][i] * (i < 3 ? r.accelerometer_sign : 1);
  }
  return w.take();
}

Table parameters_table(const Run& r, const Answer& a) {
  static constexpr std::array<const char*, kChainStates> kNames{"gravity_error_mg",
                                                                "horizontal_error_nT",
                                                                "down_error_nT",
                                                                "accelerometer_bias_x_mg",
                                                                "accelerometer_bias_y_mg",
                                                                "accelerometer_bias_z_mg",
                                                                "bias_x_nT",
                                                                "bias_y_nT",
                                                                "bias_z_nT"};
  Table t{"parameters",
          "errors of the reference (truth less reference) and biases of the sensors (in the sign of the "
          "file), station by station" +
              at_confidence(r.confidence)};
  t.columns = {count_column("station", "number of the station, from 1"),
               number_column("md_m", "m", "measured depth"),
               word_column("quantity", "with its unit: mg or nT"),
               number_column("estimate", "1", "in the unit of the quantity", "ci_low ci_high"),
               number_column("sd", "1", "one standard deviation"),
               number_column("ci_low", "1", "lower bound of the confidence interval"),
               number_column("ci_high", "1", "upper bound of the confidence interval")};
  TableWriter w(std::move(t));
  const double z = normal_quantile((1 + r.confidence) / 2);
  for (std::size_t k = 0; k < r.readings.y.size(); ++k)
    for (std::size_t i = 0; i < kChainStates; ++i) {
      const auto state = static_cast<Eigen::Index>(i);
      const bool accelerometer = i >= kAccelerometerOffset && i < kMagnetometerOffset;
      const double unit = i == kGravityError || accelerometer ? kMilliG : 1;
      const StationEstimate& s = a.solution.stations[k];
      const double x = s.chain[state] / unit * (accelerometer ? r.accelerometer_sign : 1),
                   sd = std::sqrt(s.covariance(3 + state, 3 + state)) / unit;
      w << static_cast<std::int64_t>(k + 1) << r.file.md[k] << std::string(kNames[i]) << x << sd << x - z * sd
        << x + z * sd;
    }
  return w.take();
}

Table fit_table(const Run& r, const Answer& a) {
  Table t{"fit", "the minimum, and whether there is another"};
  t.columns = {count_column("stations", "stations of the run"),
               count_column("redundancy", "equations less unknowns: three a station"),
               number_column("cost", "1", "sum of the squared whitened equations at the lowest minimum"),
               number_column("p_value", "1", "of the cost under chi-squared(redundancy), upper tail"),
               count_column("iterations", "of the solver"),
               count_column("modes", "different minima found"),
               count_column("ambiguous", "1: a second minimum explains the readings almost as well"),
               number_column("cost_of_second", "1", "its cost")};
  TableWriter w(std::move(t));
  const double equations = 3.0 * r.readings.stations();
  const ChainedSolution& best = a.modes.modes.front();
  w << static_cast<std::int64_t>(r.readings.stations()) << static_cast<std::int64_t>(equations) << best.cost
    << chi_squared_upper_tail(equations, best.cost) << static_cast<std::int64_t>(best.iterations)
    << static_cast<std::int64_t>(a.modes.modes.size()) << static_cast<std::int64_t>(a.modes.ambiguous)
    << (a.modes.modes.size() > 1 ? a.modes.modes[1].cost : kNaN);
  return w.take();
}

/// Every minimum of the smoother, so that one who knows the well can choose.
Table modes_table(const Run& r, const Answer& a) {
  Table t{"modes", "minima of the smoother, lowest cost first; bias_z is the mean over the stations"};
  t.columns = {count_column("mode", "from 1"),
               number_column("cost", "1", "J"),
               number_column("bias_z_nT", "nT", "axial magnetometer bias"),
               count_column("station", "number of the station, from 1"),
               number_column("md_m", "m", "measured depth"),
               number_column("inclination_deg", "deg", "of the station in this mode"),
               number_column("azimuth_magnetic_deg", "deg", "of the station in this mode")};
  TableWriter w(std::move(t));
  for (std::size_t i = 0; i < a.modes.modes.size(); ++i) {
    const ChainedSolution& m = a.modes.modes[i];
    double bias = 0;
    for (const StationEstimate& s : m.stations)
      bias += s.chain[kMagnetometerOffset + 2] / static_cast<double>(m.stations.size());
    for (std::size_t k = 0; k < m.stations.size(); ++k) {
      const Attitude at = attitude_of(m.stations[k].frame);
      w << static_cast<std::int64_t>(i + 1) << m.cost << bias << static_cast<std::int64_t>(k + 1) << r.file.md[k]
        << at.inclination / kDegree << degrees_of(at.azimuth);
    }
  }
  return w.take();
}

/// Do the claims hold, and what holds where they do not.
Table profile_table(const Run& r, const Answer& a) {
  Table t{"profile",
          "the smoother's claims against the cost, minimised at values of the station's axial bias; azimuth: by the "
          "covariance where the claims hold, else by the mixture over the bias" +
              at_confidence(r.confidence)};
  const auto number = [&](const char* name, const char* unit, const char* meaning) {
    t.columns.push_back(number_column(name, unit, meaning));
  };
  t.columns = {count_column("station", "number of the station, from 1")};
  number("md_m", "m", "measured depth");
  t.columns.push_back(
      count_column("claims_hold", "1: the cost rises as the covariance says, and there is one minimum"));
  number("cost_rise_low", "1", "of the cost at the axial bias less 2 claimed sd: 4 where the claims hold");
  number("cost_rise_high", "1", "of the cost at the axial bias and 2 claimed sd: 4 where the claims hold");
  number("bias_z_nT", "nT", "axial bias at the lowest minimum");
  number("claimed_sd_bias_z_nT", "nT", "by the covariance");
  number("sd_bias_z_nT", "nT", "by the profile");
  number("azimuth_magnetic_deg", "deg", "at the lowest minimum");
  number("claimed_sd_azimuth_deg", "deg", "by the covariance");
  number("mean_azimuth_magnetic_deg", "deg", "by the profile");
  number("sd_azimuth_deg", "deg", "by the profile");
  number("azimuth_magnetic_ci_low_deg", "deg", "lower bound of the confidence interval by the profile");
  number("azimuth_magnetic_ci_high_deg", "deg", "upper bound; below the lower one where the interval contains north");
  t.columns.push_back(count_column("complete", "0: a part of the profile was not found"));
  TableWriter w(std::move(t));
  for (const ChainedProfile& p : a.profiles)
    w << static_cast<std::int64_t>(p.station + 1) << r.file.md[static_cast<std::size_t>(p.station)]
      << static_cast<std::int64_t>(p.parabola) << p.rise_low << p.rise_high << p.bias << p.claimed_sd << p.sd_bias
      << degrees_of(p.azimuth) << p.azimuth_claimed_sd / kDegree << degrees_of(p.azimuth_mean) << p.azimuth_sd / kDegree
      << degrees_of(p.azimuth_low) << degrees_of(p.azimuth_high) << static_cast<std::int64_t>(p.complete);
  return w.take();
}

Table tests_table(const Run& r, const Answer& a) {
  Table t{"tests", "does the run as a whole, and does every reading, fit the model"};
  t.columns = {word_column("test", "cost (chi-squared of the run) or reading (w, standard normal)"),
               count_column("station", "number of the station, from 1; 0 for the run as a whole"),
               number_column("md_m", "m", "measured depth of the station"),
               word_column("component", "accelerometer g, magnetometer b, axis"),
               number_column("statistic", "1", "what is tested"),
               number_column("critical_low", "1", "rejected below"),
               number_column("critical_high", "1", "rejected above"),
               number_column("p_value", "1", "probability of a statistic as extreme, by noise alone"),
               word_column("unit", "of error and minimal_detectable_error"),
               number_column("error", "1", "size of the error in this reading, if it is the only one"),
               number_column("sd_error", "1", "its standard deviation"),
               number_column("minimal_detectable_error", "1", "found with a probability of 80 %"),
               word_column("decision", "accepted or rejected"),
               word_column("note", "what follows")};
  TableWriter w(std::move(t));
  const double equations = 3.0 * r.readings.stations(), cost = a.modes.modes.front().cost,
               low = chi_squared_quantile(equations, r.alpha / 2),
               high = chi_squared_quantile(equations, 1 - r.alpha / 2), tail = chi_squared_upper_tail(equations, cost);
  w << std::string("cost") << std::int64_t{0} << kNaN << std::string() << cost << low << high
    << 2 * std::min(tail, 1 - tail) << std::string() << kNaN << kNaN << kNaN
    << std::string(cost < low || cost > high ? "rejected" : "accepted")
    << std::string(cost > high  ? "more than the noise of the model: a gross error, a wrong reference, or more noise"
                   : cost < low ? "less than the noise of the model: its sizes are too large"
                                : "");
  for (std::size_t k = 0; k < a.tests.w.size(); ++k)
    for (std::size_t i = 0; i < 6; ++i) {
      const double x = a.tests.w[k][i], s = a.tests.sensitivity[k][i], unit = i < 3 ? kMilliG : 1,
                   sign = i < 3 ? r.accelerometer_sign : 1, sd = r.model.noise[i] / s / unit;
      const bool suspect = a.suspect.found && a.suspect.station == static_cast<int>(k) && a.suspect.axis == i;
      w << std::string("reading") << static_cast<std::int64_t>(k + 1) << r.file.md[k] << std::string(kReadings[i])
        << sign * x << -r.gate.gate << r.gate.gate << std::erfc(std::abs(x) / std::sqrt(2.0))
        << std::string(i < 3 ? "mg" : "nT") << sign * x * sd << sd
        << minimal_detectable(r.model, a.tests, k, i, r.gate.gate) / unit
        << std::string(std::abs(x) > r.gate.gate ? "rejected" : "accepted")
        << std::string(!suspect             ? ""
                       : a.suspect.dominant ? "the suspect; it dominates its station clearly"
                                            : "the station is suspect; which of its readings is not clear");
    }
  return w.take();
}

Table warnings_table(const Run& r, const Answer& a) {
  std::vector<EstimateWarning> warnings;
  const double equations = 3.0 * r.readings.stations(), cost = a.modes.modes.front().cost;
  if (a.modes.ambiguous)
    warnings.push_back({"severe", fmt::format("ambiguous: a second minimum has cost {:.2f}, the first {:.2f}; table "
                                              "`modes` has both: choose by what is known of the well",
                                              a.modes.modes[1].cost, cost)});
  const ChainedProfile* worst = nullptr;
  std::size_t unheld = 0;
  for (const ChainedProfile& p : a.profiles) {
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
  if (cost > chi_squared_quantile(equations, 1 - r.alpha / 2))
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
  Table t{"warnings", "what to know before the estimate is used"};
  t.columns = {word_column("severity", "severe, warning or info"),
               word_column("message", "what is wrong, and what to do")};
  TableWriter w(std::move(t));
  for (const EstimateWarning& x : warnings) w << x.severity << x.message;
  return w.take();
}

class ChainedEstimate final : public StudyPoint {
 public:
  ChainedEstimate(Run run, Answer answer) : r_(std::move(run)), a_(std::move(answer)) {}
  PointResult report(const Tally&, const RunOptions&) const override {
    PointResult result;
    result.tables = {parameters_table(r_, a_), fit_table(r_, a_),   modes_table(r_, a_),
                     stations_table(r_, a_),   profile_table(r_, a_), tests_table(r_, a_), warnings_table(r_, a_)};
    return result;
  }

 private:
  Run r_;
  Answer a_;
};

class ChainedEstimatePlan final : public PointPlan {
 public:
  explicit ChainedEstimatePlan(Run run) : r_(std::move(run)) {}
  std::unique_ptr<StudyPoint> prepare(const RunOptions&) const override {
    try {
      return std::make_unique<ChainedEstimate>(r_, answer_of(r_));
    } catch (const InputError& e) {  // what the readings as a whole do not tell: say which file, in which case
      r_.place.fail(e.what());
    }
  }

 private:
  Run r_;
};

}  // namespace

std::unique_ptr<PointPlan> estimate_chained(ConfigReader& config) {
  return std::make_unique<ChainedEstimatePlan>(read_run(config));
}

}  // namespace surveymc
