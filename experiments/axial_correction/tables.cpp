/// Maps and tables of the study `axial_correction`.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "axial_correction/study.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "stats/normal_tail.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::axial_correction {
namespace {

using single_station::StationMethod;
using single_station::StationQuantity;

bool contains(const std::vector<std::string>& all, const std::string& x) {
  return std::find(all.begin(), all.end(), x) != all.end();
}
bool contains(const std::vector<double>& all, double x) {
  return all.empty() || std::any_of(all.begin(), all.end(), [x](double y) { return std::abs(x - y) < 1e-9; });
}

std::string expected_verdict(const Scenario& s, std::size_t m, std::size_t k, const std::string& quantity) {
  std::string verdict;
  for (const ExpectedVerdict& e : s.expected)  // later ones win
    if (contains(e.methods, s.name_of(m)) && contains(e.quantities, quantity) &&
        contains(e.inclination_deg, s.station_inclination_deg[k]) && contains(e.azimuth_deg, s.station_azimuth_deg[k]))
      verdict = e.verdict;
  return verdict;
}

/// An RMS and its prediction, both to be multiplied by `factor`.
compare::ComparisonRow compare_rms(const char* quantity, const char* unit, double factor, double mean_square,
                                   double variance, std::uint64_t count, double analytic,
                                   const compare::VerdictRule& rule, std::uint64_t trials) {
  compare::Estimate found = compare::rms_estimate(mean_square, variance, count, rule.confidence);
  found = {factor * found.value, {factor * found.interval.lo, factor * found.interval.hi}};
  compare::ComparisonRow row = compare::compare_value(quantity, unit, found, factor * analytic, rule, trials);
  if (count < 2)
    row.note = "no trial has a solution";
  else if (!(mean_square > 0))
    row.note = "every trial gave the truth";
  else if (!std::isfinite(analytic))
    row.note = "no finite prediction";
  return row;
}

/// RMS about zero of component i, from central moments.
compare::ComparisonRow compare_rms(const char* quantity, const char* unit, double factor, const stats::Moments& m,
                                   Eigen::Index i, double analytic, const compare::VerdictRule& rule,
                                   std::uint64_t trials) {
  if (m.count < 2) return compare_rms(quantity, unit, factor, 0, 0, m.count, analytic, rule, trials);
  const double n = static_cast<double>(m.count), mean = m.mean[i], second = m.squares(i, i) / n;
  const double square = second + mean * mean;
  const double fourth = m.fourths[i] / n + 4 * mean * m.cubes[i] / n + 6 * mean * mean * second + std::pow(mean, 4);
  return compare_rms(quantity, unit, factor, square, std::max(0.0, fourth - square * square), m.count, analytic, rule,
                     trials);
}

/// P(|x| > limit), x normal.
double outside(double limit, double mean, double sd) {
  return stats::normal_upper_tail((limit - mean) / sd) + stats::normal_upper_tail((limit + mean) / sd);
}

single_station::StationSigmas drawn_sigmas(const Scenario& s) {
  single_station::StationSigmas actual = s.sigmas;
  if (!s.axial_is_drawn) actual.axial = 0;
  return actual;
}
ConstantErrors constant_errors(const Scenario& s) { return s.axial_is_drawn ? ConstantErrors{} : s.errors; }

}  // namespace

std::vector<store::Axis> map_axes_of(const Scenario& s) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < s.methods.size(); ++m) names.push_back(s.name_of(m));
  return {{"method", "", "single-station solution", names},
          {"inclination", "deg", "inclination", s.inclination_deg},
          {"magnetic_azimuth", "deg", "magnetic azimuth", s.azimuth_deg}};
}

void add_maps(const Scenario& s, std::vector<store::Map>& maps, std::vector<store::Table>& tables) {
  const std::vector<store::Axis> axes = map_axes_of(s);
  store::Map error{
      "azimuth_error_deg", "deg", "error of the azimuth by the constant errors; inf: no solution", axes, {}};
  store::Map axial{"axial_magnetisation_error_nT", "nT", "estimated less true Mz; inf: no solution", axes, {}};
  store::Map sd{"azimuth_sd_deg",
                "deg",
                "sd of the azimuth by the sigmas, first order; inf: undefined, or no solution",
                axes,
                {}};
  compare::TableRows t("failures", fmt::format("attitudes of the maps where the azimuth is off by more than {:g} deg",
                                               s.tolerance / kDegree));
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    std::vector<double> errors, sds;
    std::int64_t without = 0, over_error = 0, over_sd = 0;
    double error_largest = kNaN, sd_largest = kNaN, where_i = kNaN, where_a = kNaN;
    for (const double i : s.inclination_deg)
      for (const double a : s.azimuth_deg) {
        const survey::Attitude at{i * kDegree, a * kDegree, s.toolface};
        const Prediction wrong = predict_azimuth_errors(s, at, s.methods[m], s.errors, s.sigmas);
        const Prediction clean = predict_azimuth_errors(s, at, s.methods[m], {}, s.sigmas);
        const double e = std::abs(wrong.azimuth_error) / kDegree, x = clean.sd(StationQuantity::azimuth) / kDegree;
        error.values.push_back(wrong.azimuth_error / kDegree);
        axial.values.push_back(wrong.axial_error);
        sd.values.push_back(x);
        errors.push_back(e);
        sds.push_back(x);
        without += !wrong.solution.determined;
        over_error += !(e <= s.tolerance / kDegree);
        over_sd += !(x <= s.tolerance / kDegree);
        if (std::isfinite(e) && !(e <= error_largest)) error_largest = e;
        if (std::isfinite(x) && !(x <= sd_largest)) sd_largest = x, where_i = i, where_a = a;
      }
    const double n = static_cast<double>(errors.size());
    t.word("method", "single-station solution", s.name_of(m));
    t.count("attitudes", "of the map", errors.size());
    t.count("without_solution", "attitudes at which the method has none", without);
    t.number("tolerance_deg", "deg", "of the azimuth", s.tolerance / kDegree);
    t.number("share_error", "1", "attitudes with a larger error by the constant errors, or no solution",
             static_cast<double>(over_error) / n);
    t.number("share_sd", "1", "attitudes with a larger sd, or no solution", static_cast<double>(over_sd) / n);
    t.number("error_median_deg", "deg", "median |error|; inf if most have no solution", stats::median(errors));
    t.number("error_largest_deg", "deg", "largest finite |error|", error_largest);
    t.number("sd_median_deg", "deg", "median sd", stats::median(sds));
    t.number("sd_largest_deg", "deg", "largest finite sd", sd_largest);
    t.number("sd_largest_inclination_deg", "deg", "where", where_i);
    t.number("sd_largest_azimuth_deg", "deg", "where", where_a);
  }
  maps = {std::move(error), std::move(sd), std::move(axial)};
  tables.push_back(t.take());
}

store::Table verification_table(const Scenario& s, const stats::Tally& tally) {
  const Groups groups(s.methods.size(), s.stations.size());
  const Counts counts(s.methods.size(), s.stations.size());
  std::vector<compare::ComparisonRow> rows;
  std::vector<double> inclination, azimuth;
  for (std::size_t k = 0; k < s.stations.size(); ++k)
    for (std::size_t m = 0; m < s.methods.size(); ++m) {
      const survey::Attitude& at = s.stations[k];
      const Prediction p = predict_azimuth_errors(s, at, s.methods[m], constant_errors(s), drawn_sigmas(s));
      const stats::Moments& found = tally.groups[groups.station(m, k)];
      const std::uint64_t none = tally.counts[counts.failed(m, k)], solved = tally.trials - none;
      const double sd = p.sd(StationQuantity::azimuth);
      const auto add = [&](compare::ComparisonRow row) {
        row.formulation = s.name_of(m);
        row.expected = expected_verdict(s, m, k, row.quantity);
        row.failed = none;
        rows.push_back(std::move(row));
        inclination.push_back(s.station_inclination_deg[k]);
        azimuth.push_back(s.station_azimuth_deg[k]);
      };
      add(compare_rms("azimuth", "deg", 1 / kDegree, found, 0, std::hypot(p.azimuth_error, sd), s.verdict,
                      tally.trials));
      if (s.methods[m] != StationMethod::basic && s.methods[m] != StationMethod::optimising)
        add(compare_rms("axial_magnetisation", "nT", 1, found, 1,
                        std::hypot(p.axial_error, p.sd(StationQuantity::axial)), s.verdict, tally.trials));
      add(compare::compare_rate("over_tolerance", tally.counts[counts.over_tolerance(m, k)], solved,
                                std::isfinite(sd) ? outside(s.tolerance, p.azimuth_error, sd) : kNaN, s.verdict,
                                tally.trials));
    }
  store::Table t = compare::comparison_table(
      "verification",
      "RMS errors of every attitude against first-order theory, and the share of trials beyond "
      "the tolerance against a normal distribution" +
          compare::at_confidence(s.verdict.confidence),
      rows, tally.trials, 0, true);
  t.columns.back().long_name = "trials without a solution, not in the statistics";
  t.columns.insert(t.columns.begin(), {{"inclination_deg", "deg", "of the station", inclination},
                                       {"magnetic_azimuth_deg", "deg", "of the station", azimuth}});
  return t;
}

store::Table profile_table(const Scenario& s, const stats::Tally& tally) {
  constexpr std::array<StationQuantity, kProfileQuantities> kQuantity{
      StationQuantity::azimuth,    StationQuantity::inclination, StationQuantity::toolface, StationQuantity::gravity,
      StationQuantity::horizontal, StationQuantity::vertical,    StationQuantity::axial};
  const Groups groups(s.methods.size(), s.stations.size());
  const double bh = s.field.total * std::cos(s.field.dip), bd = s.field.total * std::sin(s.field.dip);
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    std::array<double, kProfileQuantities> mean_square{};
    for (const survey::Attitude& at : s.stations) {
      const Prediction p = predict_azimuth_errors(s, at, s.methods[m], constant_errors(s), drawn_sigmas(s));
      const single_station::StationSolution& x = p.solution;
      const std::array<double, kProfileQuantities> bias{
          p.azimuth_error, 0, 0, x.gravity - s.field.gravity, x.horizontal() - bh, x.vertical - bd, p.axial_error};
      for (std::size_t q = 0; q < kProfileQuantities; ++q) {
        const double sd = p.sd(kQuantity[q]);
        mean_square[q] += (bias[q] * bias[q] + sd * sd) / static_cast<double>(s.stations.size());
      }
    }
    const stats::Moments& found = tally.groups[groups.profile(m)];
    for (std::size_t q = 0; q < kProfileQuantities; ++q) {
      const ProfileQuantity& name = profile_quantities()[q];
      const auto i = static_cast<Eigen::Index>(q);
      compare::ComparisonRow row = compare_rms(name.name, name.unit, name.per_si, found.count > 1 ? found.mean[i] : 0,
                                               found.count > 1 ? found.variance(i) : 0, found.count,
                                               std::sqrt(mean_square[q]), s.verdict, tally.trials);
      row.formulation = s.name_of(m);
      row.failed = tally.trials - found.count;
      rows.push_back(std::move(row));
    }
  }
  s.annotations.apply("profile", rows);
  store::Table t = compare::comparison_table(
      "profile", "RMS errors over all stations of the Monte Carlo" + compare::at_confidence(s.verdict.confidence), rows,
      tally.trials, 0, true);
  t.columns.back().long_name = "trials in which a station has no solution, not in the statistics";
  return t;
}

}  // namespace surveymc::studies::axial_correction
