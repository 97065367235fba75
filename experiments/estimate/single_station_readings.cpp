#include "estimate/single_station_readings.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/table_rows.h"
#include "compare/verdict.h"
#include "estimate/run_tables.h"
#include "scenario/station_sigmas.h"
#include "stats/intervals.h"

namespace surveymc::studies::estimate {
namespace {

using single_station::StationMethod;
using single_station::StationQuantity;

/// One station, solved by the method, and by the basic solution of the uncorrected readings, which quality control
/// uses.
struct SolvedStation {
  double md = 0;
  single_station::StationSolution raw, solved;
  single_station::StationCovariance raw_covariance = single_station::StationCovariance::Zero(),
                                    covariance = single_station::StationCovariance::Zero();
  double axial_sd_without = 0;  ///< sd of the estimated Mz if there is none in truth
};

double sd(const single_station::StationCovariance& c, StationQuantity q) {
  const auto i = static_cast<Eigen::Index>(q);
  return std::sqrt(c(i, i));
}

std::vector<SolvedStation> solve(const survey::SixAxisReadings& r, const single_station::StationReferences& ref,
                                 const StationEstimation& how) {
  single_station::StationSigmas without = how.sigmas;
  without.axial = 0;
  std::vector<SolvedStation> all;
  for (std::size_t k = 0; k < r.md.size(); ++k) {
    SolvedStation s;
    s.md = r.md[k];
    s.raw = single_station::solve_station(r.gravity_T[k], r.magnetic_T[k], ref, how.sigmas, StationMethod::basic);
    s.solved = single_station::solve_station(r.gravity_T[k], r.magnetic_T[k], ref, how.sigmas, how.method);
    if (s.raw.determined)
      s.raw_covariance = single_station::station_covariance(s.raw, how.sigmas, StationMethod::basic, without);
    if (s.solved.determined) {
      s.covariance = single_station::station_covariance(s.solved, how.sigmas, how.method);
      s.axial_sd_without =
          sd(single_station::station_covariance(s.solved, how.sigmas, how.method, without), StationQuantity::axial);
    }
    all.push_back(s);
  }
  return all;
}

bool estimates_axial(StationMethod m) {
  return m == StationMethod::simple || m == StationMethod::extended || m == StationMethod::extended_bh;
}

store::Table stations_table(const std::vector<SolvedStation>& stations, const survey::ReferenceField& field,
                            StationMethod method, double confidence) {
  compare::TableRows t("stations", fmt::format("every station by itself, method {}{}",
                                               single_station::station_method_names()[static_cast<std::size_t>(method)],
                                               compare::at_confidence(confidence)));
  const bool axial = estimates_axial(method);
  const double z = stats::normal_quantile((1 + confidence) / 2);
  compare::write_rows(t, stations, [&](const SolvedStation& s) {
    const bool ok = s.solved.determined;
    const auto number = [&](const char* name, const char* unit, const char* meaning, double x,
                            const char* ancillary = "") { t.number(name, unit, meaning, ok ? x : kNaN, ancillary); };
    const auto sd_of = [&](StationQuantity q) { return sd(s.covariance, q); };
    const survey::Attitude& at = s.solved.attitude;
    const double true_azimuth = at.azimuth + field.declination;
    t.number("md_m", "m", "measured depth", s.md);
    t.count("determined", "1; 0 where the method gives no answer", ok);
    number("inclination_deg", "deg", "inclination", at.inclination / kDegree);
    number("sd_inclination_deg", "deg", "its standard deviation", sd_of(StationQuantity::inclination) / kDegree);
    number("toolface_deg", "deg", "from the tool's y axis; 0 in a vertical hole", at.toolface / kDegree);
    number("sd_toolface_deg", "deg", "its standard deviation; inf in a vertical hole",
           sd_of(StationQuantity::toolface) / kDegree);
    t.number("raw_azimuth_magnetic_deg", "deg", "of the readings as they are (basic), from magnetic north",
             s.raw.determined ? s.raw.attitude.azimuth / kDegree : kNaN);
    number("azimuth_magnetic_deg", "deg", "from magnetic north", compare::turn_in_degrees(at.azimuth));
    number("azimuth_true_deg", "deg", "from true north", compare::turn_in_degrees(true_azimuth));
    number("azimuth_grid_deg", "deg", "from grid north", compare::turn_in_degrees(true_azimuth - field.convergence));
    number("azimuth_change_deg", "deg", "less that of the readings as they are",
           std::remainder((at.azimuth - s.raw.attitude.azimuth) / kDegree, 360.0));
    number("sd_azimuth_deg", "deg", "standard deviation; declination is taken as exact; inf in a vertical hole",
           sd_of(StationQuantity::azimuth) / kDegree);
    number("sd_turn_deg", "deg", "of azimuth + toolface (- above the horizontal), which a vertical hole has, too",
           sd_of(StationQuantity::turn) / kDegree);
    number("gravity_mps2", "mps2", "length of the gravity vector", s.solved.gravity);
    number("horizontal_field_nT", "nT", "Bh", s.solved.horizontal());
    number("sd_horizontal_field_nT", "nT", "its standard deviation", sd_of(StationQuantity::horizontal));
    number("vertical_field_nT", "nT", "Bd, down", s.solved.vertical);
    number("sd_vertical_field_nT", "nT", "its standard deviation", sd_of(StationQuantity::vertical));
    if (!axial) return;
    const double x = s.solved.axial, d = sd_of(StationQuantity::axial);
    number("axial_magnetisation_nT", "nT", "Mz: what the string adds to bz", x,
           "axial_magnetisation_ci_low_nT axial_magnetisation_ci_high_nT");
    number("sd_axial_magnetisation_nT", "nT", "its standard deviation", d);
    number("axial_magnetisation_ci_low_nT", "nT", "lower bound of the confidence interval", x - z * d);
    number("axial_magnetisation_ci_high_nT", "nT", "upper bound of the confidence interval", x + z * d);
  });
  return t.take();
}

struct Rejections {
  std::int64_t gravity = 0, field = 0, fit = 0, axial = 0, undetermined = 0;
};

/// A row of the table `tests`.
struct StationTest {
  std::string test, unit;
  std::size_t station = 0;  ///< from 0
  double difference = kNaN, sd = kNaN, statistic = kNaN, low = kNaN, high = kNaN, p_value = kNaN;
};

store::Table tests_table(const std::vector<SolvedStation>& stations, const single_station::StationReferences& ref,
                         const StationEstimation& how, double alpha, Rejections& rejected) {
  std::vector<StationTest> rows;
  const auto is_bad = [](const StationTest& x) { return x.statistic < x.low || x.statistic > x.high; };
  const double critical = stats::normal_quantile(1 - alpha / 2);
  const auto normal = [&](const char* test, std::size_t k, double difference, double s, const char* unit,
                          std::int64_t& count) {
    const bool tested = std::isfinite(difference) && s > 0 && std::isfinite(s);
    const double x = tested ? difference / s : kNaN;
    rows.push_back({test, unit, k, difference, s, x, -critical, critical,
                    tested ? stats::chi_squared_upper_tail(1, x * x) : kNaN});
    count += is_bad(rows.back());
  };
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const SolvedStation& s = stations[k];
    const bool raw = s.raw.determined, ok = s.solved.determined;
    const auto with = [&](StationQuantity q, double reference_sd) {
      return raw ? std::hypot(sd(s.raw_covariance, q), reference_sd) : kNaN;
    };
    rejected.undetermined += !ok;
    normal("gravity", k, raw ? s.raw.gravity - ref.gravity : kNaN, with(StationQuantity::gravity, how.sigmas.gravity),
           "mps2", rejected.gravity);
    normal("horizontal_field", k, raw ? s.raw.horizontal() - ref.horizontal : kNaN,
           with(StationQuantity::horizontal, how.sigmas.horizontal), "nT", rejected.field);
    normal("vertical_field", k, raw ? s.raw.vertical - ref.vertical : kNaN,
           with(StationQuantity::vertical, how.sigmas.vertical), "nT", rejected.field);
    if (s.solved.redundancy > 0) {
      const double x = ok ? single_station::fit_statistic(s.solved, ref, how.sigmas, how.method) : kNaN;
      rows.push_back({"fit", "1", k, kNaN, kNaN, x, kNaN, stats::chi_squared_quantile(s.solved.redundancy, 1 - alpha),
                      ok ? stats::chi_squared_upper_tail(s.solved.redundancy, x) : kNaN});
      rejected.fit += is_bad(rows.back());
    }
    if (estimates_axial(how.method))
      normal("axial_magnetisation", k, ok ? s.solved.axial : kNaN, ok ? s.axial_sd_without : kNaN, "nT",
             rejected.axial);
  }
  compare::TableRows t(
      "tests",
      "quality control of every station: the readings as they are against the references, what the method "
      "leaves over, and whether there is a magnetisation");
  compare::write_rows(t, rows, [&](const StationTest& x) {
    t.word("test",
           "gravity, horizontal_field, vertical_field (readings less reference over its sd), fit "
           "(chi-squared of what the method leaves over), axial_magnetisation (Mz over its sd if none)",
           x.test);
    t.count("station", "number of the station, from 1", x.station + 1);
    t.number("md_m", "m", "measured depth of the station", stations.empty() ? kNaN : stations[x.station].md);
    t.number("difference", "1", "readings less reference, or Mz, in the row's unit", x.difference);
    t.number("sd", "1", "its standard deviation without any magnetisation, reference included", x.sd);
    t.word("unit", "of difference and sd", x.unit);
    t.test(x.statistic, x.low, x.high, x.p_value);
    t.word("decision", "accepted, rejected or not tested",
           std::isnan(x.statistic) ? "not tested"
           : is_bad(x)             ? "rejected"
                                   : "accepted");
  });
  return t.take();
}

std::vector<analysis::Warning> warnings_of(const std::vector<SolvedStation>& stations, const StationEstimation& how,
                                           const Rejections& rejected, double alpha) {
  std::vector<analysis::Warning> warnings;
  const auto n = stations.size();
  const auto warn = [&](const char* severity, const std::string& message) { warnings.push_back({severity, message}); };
  if (rejected.undetermined > 0)
    warn("severe", fmt::format("{} of {} stations have no solution{}", rejected.undetermined, n,
                               how.method == StationMethod::simple
                                   ? ": the simple correction fails where cos I = 0; take method = \"extended\""
                                   : ": no gravity or no horizontal field"));
  if (rejected.fit > 0)
    warn("warning", fmt::format("{} of {} stations do not fit their sigmas (alpha {:g}): a gross error, a wrong "
                                "reference, or more noise or magnetisation than claimed",
                                rejected.fit, n, alpha));
  if (rejected.gravity > 0)  // no magnetisation changes |g|
    warn("warning",
         fmt::format("{} of {} stations have another length of gravity than the reference (alpha {:g}): look "
                     "at the accelerometers, their unit and sigma, and at field.gravity_mps2",
                     rejected.gravity, n, alpha));
  if (rejected.field > 0)
    warn(
        estimates_axial(how.method) ? "info" : "warning",
        fmt::format("{} of {} comparisons of the magnetic readings as they are with the references fail (alpha {:g}){}",
                    rejected.field, 2 * n, alpha,
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
  return warnings;
}

}  // namespace

const std::vector<std::string>& station_estimators() {
  static const std::vector<std::string> names{"single_station", "axial_correction"};
  return names;
}

StationEstimation read_station_estimation(config::ConfigReader& c) {
  StationEstimation how;
  const std::string name = c.choice("estimator.name", station_estimators(), config::kMeaningElsewhere);
  how.method = single_station::station_method(
      name == "single_station"
          ? c.choice("estimator.method", {"basic", "optimising"},
                     "method of the solution: of 'single_station' 'basic' or 'optimising'; of 'axial_correction' "
                     "'extended', 'simple' or 'extended_bh'",
                     "basic")
          : c.choice("estimator.method", {"extended", "simple", "extended_bh"}, config::kMeaningElsewhere, "extended"));
  how.sigmas = scenario::read_station_sigmas(c);
  if (estimates_axial(how.method) && how.method != StationMethod::simple)
    c.require(how.sigmas.axial > 0, c.has("sigma.axial_magnetisation_nT") ? "sigma.axial_magnetisation_nT" : "sigma",
              "axial_magnetisation_nT must be > 0: with 0 there is no magnetisation to correct for");
  scenario::require_station_sigmas(c, c.has("estimator.method") ? "estimator.method" : "estimator.name", how.method,
                                   how.sigmas);
  return how;
}

std::vector<store::Table> station_estimate_tables(const survey::SixAxisReadings& readings,
                                                  const survey::ReferenceField& field, const StationEstimation& how,
                                                  const analysis::TestLevels& levels) {
  const single_station::StationReferences ref{field.gravity, field.total * std::cos(field.dip),
                                              field.total * std::sin(field.dip)};
  const std::vector<SolvedStation> stations = solve(readings, ref, how);
  Rejections rejected;
  store::Table tests = tests_table(stations, ref, how, levels.alpha_w, rejected);
  return {stations_table(stations, field, how.method, levels.confidence), std::move(tests),
          warnings_table(warnings_of(stations, how, rejected, levels.alpha_w))};
}

}  // namespace surveymc::studies::estimate
