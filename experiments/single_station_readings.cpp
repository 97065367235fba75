#include "single_station_readings.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/units.h"
#include "single_station_config.h"
#include "stats/intervals.h"
#include "study/table_writer.h"
#include "study/verdict.h"

namespace surveymc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double degrees_of_turn(double angle) {
  const double turn = std::fmod(angle / kDegree, 360.0);
  return turn < 0 ? turn + 360 : turn;
}

/// One station: by the method, and as the readings are (basic), which is what quality control looks at.
struct SolvedStation {
  double md = 0;
  StationSolution raw, solved;
  StationCovariance raw_covariance = StationCovariance::Zero(), covariance = StationCovariance::Zero();
  double axial_sd_without = 0;  ///< sd of the estimated Mz if there is none in truth
};

double sd(const StationCovariance& c, StationQuantity q) {
  const auto i = static_cast<Eigen::Index>(q);
  return std::sqrt(c(i, i));
}

std::vector<SolvedStation> solve(const SixAxisReadings& r, const StationReferences& ref, const StationEstimation& how) {
  StationSigmas without = how.sigmas;
  without.axial = 0;
  std::vector<SolvedStation> all;
  for (std::size_t k = 0; k < r.md.size(); ++k) {
    SolvedStation s;
    s.md = r.md[k];
    s.raw = solve_station(r.gravity_T[k], r.magnetic_T[k], ref, how.sigmas, StationMethod::basic);
    s.solved = solve_station(r.gravity_T[k], r.magnetic_T[k], ref, how.sigmas, how.method);
    if (s.raw.determined) s.raw_covariance = station_covariance(s.raw, how.sigmas, StationMethod::basic, without);
    if (s.solved.determined) {
      s.covariance = station_covariance(s.solved, how.sigmas, how.method);
      s.axial_sd_without = sd(station_covariance(s.solved, how.sigmas, how.method, without), StationQuantity::axial);
    }
    all.push_back(s);
  }
  return all;
}

bool estimates_axial(StationMethod m) {
  return m == StationMethod::simple || m == StationMethod::extended || m == StationMethod::extended_bh;
}

Table stations_table(const std::vector<SolvedStation>& stations, const ReferenceField& field, StationMethod method,
                     double confidence) {
  Table t{"stations", fmt::format("every station by itself, method {}{}",
                                  station_method_names()[static_cast<std::size_t>(method)], at_confidence(confidence))};
  const auto number = [&](const char* name, const char* unit, const char* meaning, const char* ancillary = "") {
    t.columns.push_back(number_column(name, unit, meaning, ancillary));
  };
  number("md_m", "m", "measured depth");
  t.columns.push_back(count_column("determined", "1; 0 where the method gives no answer"));
  number("inclination_deg", "deg", "inclination");
  number("sd_inclination_deg", "deg", "its standard deviation");
  number("toolface_deg", "deg", "from the tool's y axis; 0 in a vertical hole");
  number("sd_toolface_deg", "deg", "its standard deviation; inf in a vertical hole");
  number("raw_azimuth_magnetic_deg", "deg", "of the readings as they are (basic), from magnetic north");
  number("azimuth_magnetic_deg", "deg", "from magnetic north");
  number("azimuth_true_deg", "deg", "from true north");
  number("azimuth_grid_deg", "deg", "from grid north");
  number("azimuth_change_deg", "deg", "less that of the readings as they are");
  number("sd_azimuth_deg", "deg", "standard deviation; declination is taken as exact; inf in a vertical hole");
  number("sd_turn_deg", "deg", "of azimuth + toolface (- above the horizontal), which a vertical hole has, too");
  number("gravity_mps2", "mps2", "length of the gravity vector");
  number("horizontal_field_nT", "nT", "Bh");
  number("sd_horizontal_field_nT", "nT", "its standard deviation");
  number("vertical_field_nT", "nT", "Bd, down");
  number("sd_vertical_field_nT", "nT", "its standard deviation");
  const bool axial = estimates_axial(method);
  if (axial) {
    number("axial_magnetisation_nT", "nT", "Mz: what the string adds to bz",
           "axial_magnetisation_ci_low_nT axial_magnetisation_ci_high_nT");
    number("sd_axial_magnetisation_nT", "nT", "its standard deviation");
    number("axial_magnetisation_ci_low_nT", "nT", "lower bound of the confidence interval");
    number("axial_magnetisation_ci_high_nT", "nT", "upper bound of the confidence interval");
  }
  TableWriter w(std::move(t));
  const double z = normal_quantile((1 + confidence) / 2);
  for (const SolvedStation& s : stations) {
    const bool ok = s.solved.determined;
    const auto put = [&](double x) { w << (ok ? x : kNaN); };
    const Attitude& at = s.solved.attitude;
    const double true_azimuth = at.azimuth + field.declination;
    w << s.md << std::int64_t{ok};
    put(at.inclination / kDegree);
    put(sd(s.covariance, StationQuantity::inclination) / kDegree);
    put(at.toolface / kDegree);
    put(sd(s.covariance, StationQuantity::toolface) / kDegree);
    w << (s.raw.determined ? s.raw.attitude.azimuth / kDegree : kNaN);
    put(degrees_of_turn(at.azimuth));
    put(degrees_of_turn(true_azimuth));
    put(degrees_of_turn(true_azimuth - field.convergence));
    put(std::remainder((at.azimuth - s.raw.attitude.azimuth) / kDegree, 360.0));
    put(sd(s.covariance, StationQuantity::azimuth) / kDegree);
    put(sd(s.covariance, StationQuantity::turn) / kDegree);
    put(s.solved.gravity);
    put(s.solved.horizontal());
    put(sd(s.covariance, StationQuantity::horizontal));
    put(s.solved.vertical);
    put(sd(s.covariance, StationQuantity::vertical));
    if (!axial) continue;
    const double x = s.solved.axial, d = sd(s.covariance, StationQuantity::axial);
    put(x);
    put(d);
    put(x - z * d);
    put(x + z * d);
  }
  return w.take();
}

struct Rejections {
  std::int64_t references = 0, fit = 0, axial = 0, undetermined = 0;
};

Table tests_table(const std::vector<SolvedStation>& stations, const StationReferences& ref,
                  const StationEstimation& how, double alpha, Rejections& rejected) {
  Table t{"tests",
          "quality control of every station: the readings as they are against the references, what the method "
          "leaves over, and whether there is a magnetisation"};
  t.columns = {word_column("test",
                           "gravity, horizontal_field, vertical_field (readings less reference over its sd), fit "
                           "(chi-squared of the method's least squares), axial_magnetisation (Mz over its sd if none)"),
               count_column("station", "number of the station, from 1"),
               number_column("md_m", "m", "measured depth of the station"),
               number_column("difference", "1", "readings less reference, or Mz, in the row's unit"),
               number_column("sd", "1", "its standard deviation without any magnetisation, reference included"),
               word_column("unit", "of difference and sd"),
               number_column("statistic", "1", "what is tested"),
               number_column("critical_low", "1", "rejected below"),
               number_column("critical_high", "1", "rejected above"),
               number_column("p_value", "1", "probability of a statistic as extreme, by noise alone"),
               word_column("decision", "accepted, rejected or not tested")};
  TableWriter w(std::move(t));
  const double critical = normal_quantile(1 - alpha / 2);
  const auto normal = [&](const char* test, std::size_t k, double difference, double s, const char* unit,
                          std::int64_t& count) {
    const bool tested = std::isfinite(difference) && s > 0 && std::isfinite(s);
    const double x = tested ? difference / s : kNaN;
    const bool bad = tested && std::abs(x) > critical;
    count += bad;
    w << std::string(test) << static_cast<std::int64_t>(k + 1) << stations[k].md << difference << s << std::string(unit)
      << x << -critical << critical << (tested ? chi_squared_upper_tail(1, x * x) : kNaN)
      << std::string(!tested ? "not tested"
                     : bad   ? "rejected"
                             : "accepted");
  };
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const SolvedStation& s = stations[k];
    const bool raw = s.raw.determined;
    const auto with = [&](StationQuantity q, double reference_sd) {
      return raw ? std::hypot(sd(s.raw_covariance, q), reference_sd) : kNaN;
    };
    rejected.undetermined += !s.solved.determined;
    normal("gravity", k, raw ? s.raw.gravity - ref.gravity : kNaN, with(StationQuantity::gravity, how.sigmas.gravity),
           "mps2", rejected.references);
    normal("horizontal_field", k, raw ? s.raw.horizontal() - ref.horizontal : kNaN,
           with(StationQuantity::horizontal, how.sigmas.horizontal), "nT", rejected.references);
    normal("vertical_field", k, raw ? s.raw.vertical - ref.vertical : kNaN,
           with(StationQuantity::vertical, how.sigmas.vertical), "nT", rejected.references);
    if (s.solved.redundancy > 0) {
      const double high = chi_squared_quantile(s.solved.redundancy, 1 - alpha);
      const bool ok = s.solved.determined, bad = ok && s.solved.cost > high;
      rejected.fit += bad;
      w << std::string("fit") << static_cast<std::int64_t>(k + 1) << s.md << kNaN << kNaN << std::string("1")
        << (ok ? s.solved.cost : kNaN) << kNaN << high
        << (ok ? chi_squared_upper_tail(s.solved.redundancy, s.solved.cost) : kNaN)
        << std::string(!ok   ? "not tested"
                       : bad ? "rejected"
                             : "accepted");
    }
    if (estimates_axial(how.method))
      normal("axial_magnetisation", k, s.solved.determined ? s.solved.axial : kNaN,
             s.solved.determined ? s.axial_sd_without : kNaN, "nT", rejected.axial);
  }
  return w.take();
}

Table warnings_table(const std::vector<SolvedStation>& stations, const StationEstimation& how,
                     const Rejections& rejected, double alpha) {
  TableWriter w(Table{
      "warnings",
      "what to know before the estimate is used",
      {word_column("severity", "severe, warning or info"), word_column("message", "what is wrong, and what to do")}});
  const auto n = stations.size();
  const auto warn = [&](const char* severity, const std::string& message) { w << std::string(severity) << message; };
  if (rejected.undetermined > 0)
    warn("severe", fmt::format("{} of {} stations have no solution{}", rejected.undetermined, n,
                               how.method == StationMethod::simple
                                   ? ": the simple correction fails where cos I = 0; take method = \"extended\""
                                   : ": no gravity or no horizontal field"));
  if (rejected.fit > 0)
    warn("warning", fmt::format("{} of {} stations do not fit their sigmas (alpha {:g}): a gross error, a wrong "
                                "reference, or more noise or magnetisation than claimed",
                                rejected.fit, n, alpha));
  if (rejected.references > 0)
    warn(estimates_axial(how.method) ? "info" : "warning",
         fmt::format("{} of {} comparisons of the readings as they are with the references fail (alpha {:g}){}",
                     rejected.references, 3 * n, alpha,
                     estimates_axial(how.method) ? "" : ": is the string magnetised? See estimator axial_correction"));
  if (rejected.axial > 0)
    warn("info", fmt::format("{} of {} stations have an axial magnetisation that noise does not explain (alpha {:g})",
                             rejected.axial, n, alpha));
  if (how.method == StationMethod::simple) {
    std::size_t weak = 0;
    for (const SolvedStation& s : stations)
      weak += s.solved.determined && std::abs(std::cos(s.solved.attitude.inclination)) < 0.5;
    if (weak > 0)
      warn("warning", fmt::format("{} stations are beyond 60 deg from the vertical: the simple correction divides by "
                                  "cos I there; take method = \"extended\"",
                                  weak));
  }
  return w.take();
}

}  // namespace

const std::vector<std::string>& station_estimators() {
  static const std::vector<std::string> names{"single_station", "axial_correction"};
  return names;
}

StationEstimation read_station_estimation(ConfigReader& c) {
  StationEstimation how;
  const std::string name = c.choice("estimator.name", station_estimators());
  how.method = station_method(name == "single_station"
                                  ? c.choice("estimator.method", {"basic", "optimising"}, "basic")
                                  : c.choice("estimator.method", {"extended", "simple", "extended_bh"}, "extended"));
  how.sigmas = read_station_sigmas(c);
  if (estimates_axial(how.method) && how.method != StationMethod::simple)
    c.require(how.sigmas.axial > 0, c.has("sigma.axial_magnetisation_nT") ? "sigma.axial_magnetisation_nT" : "sigma",
              "axial_magnetisation_nT must be > 0: with 0 there is no magnetisation to correct for");
  require_station_sigmas(c, c.has("estimator.method") ? "estimator.method" : "estimator.name", how.method, how.sigmas);
  return how;
}

std::vector<Table> station_estimate_tables(const SixAxisReadings& readings, const ReferenceField& field,
                                           const StationEstimation& how, const TestLevels& levels) {
  const StationReferences ref{field.gravity, field.total * std::cos(field.dip), field.total * std::sin(field.dip)};
  const std::vector<SolvedStation> stations = solve(readings, ref, how);
  Rejections rejected;
  Table tests = tests_table(stations, ref, how, levels.alpha_w, rejected);
  return {stations_table(stations, field, how.method, levels.confidence), std::move(tests),
          warnings_table(stations, how, rejected, levels.alpha_w)};
}

}  // namespace surveymc
