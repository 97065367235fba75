#include "position_covariance/uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "propagate/ellipse.h"
#include "stats/intervals.h"
#include "survey/survey.h"

namespace surveymc::studies::position_covariance {
namespace {

using Eigen::Matrix3d;

/// A column of the table: so many standard deviations of a direction, and of the ellipse's axes.
struct Level {
  std::string name, meaning;
  double line, ellipse;
};

std::string percent_text(double share) { return fmt::format("{:.4g} %", 100 * share); }

std::vector<Level> levels_of(const UncertaintyReport& report) {
  std::vector<Level> out{{"sd", "one standard deviation", 1, 1}};
  for (const double k : report.sigmas) {
    const double line = 1 - stats::chi_squared_upper_tail(1, k * k);
    out.push_back({fmt::format("sigma{:g}", k),
                   fmt::format("{:g} standard deviations, which hold {} of one direction and {} of the ellipse", k,
                               percent_text(line), percent_text(propagate::ellipse_coverage(k))),
                   k, k});
  }
  for (const double percent : report.percent) {
    const double share = percent / 100, line = std::sqrt(stats::chi_squared_quantile(1, share)),
                 ellipse = std::sqrt(stats::chi_squared_quantile(2, share));
    out.push_back({fmt::format("p{:g}", percent),
                   fmt::format("holds {:g} %: {:.4g} standard deviations of a direction, {:.4g} of the ellipse's axes",
                               percent, line, ellipse),
                   line, ellipse});
  }
  return out;
}

}  // namespace

UncertaintyReport read_uncertainty_report(config::ConfigReader& c, const survey::Survey& survey) {
  UncertaintyReport report;
  const auto list = [&](const char* key, const config::Range& range, std::string_view meaning,
                        const std::vector<double>& fallback) {
    std::vector<double> values = c.has(key) ? c.number_or_list(key, range, meaning) : fallback;
    std::sort(values.begin(), values.end());
    c.require(std::adjacent_find(values.begin(), values.end()) == values.end(), key, "has a value twice");
    return values;
  };
  report.sigmas = list("report.sigmas", {0, 100, true, false},
                       "multiples of the sd that are columns of the table `uncertainty`; without it 2", {2});
  std::erase(report.sigmas, 1);  // always there
  report.percent = list("report.percent", config::Range::open(0, 100),
                        "per cent of all errors that columns of the table `uncertainty` hold: 95 is 1.96 sd of a "
                        "direction, and 2.448 sd of the ellipse's axes",
                        {});
  report.md = list("report_md_m", config::Range::non_negative(),
                   "depths within the survey, at stations or between them, for which the table `uncertainty` has rows; "
                   "the last station is always among them",
                   {});
  const double first = survey.stations.front().md, last = survey.stations.back().md;
  for (double& md : report.md) {
    const std::optional<double> on = survey::depth_on(survey, md);
    c.require(on.has_value(), "report_md_m",
              fmt::format("{:.10g} is outside the survey, which is from {:.10g} to {:.10g} m", md, first, last));
    md = *on;
  }
  c.require(std::adjacent_find(report.md.begin(), report.md.end(), survey::is_same_depth) == report.md.end(),
            "report_md_m", "has a depth twice");
  if (report.md.empty() || report.md.back() < last) report.md.push_back(last);
  return report;
}

PlaceInHole place_at(const survey::Survey& survey, const std::vector<Matrix3d>& covariances, double md) {
  const auto& stations = survey.stations;
  const auto at = std::lower_bound(stations.begin(), stations.end(), md,
                                   [](const survey::Station& s, double depth) { return s.md < depth; });
  const auto k = static_cast<std::size_t>(at - stations.begin());
  if (stations[k].md == md) return {covariances[k], {stations[k].inclination, stations[k].azimuth}};
  const double f = (md - stations[k - 1].md) / (stations[k].md - stations[k - 1].md);
  return {(1 - f) * covariances[k - 1] + f * covariances[k],
          propagate::hole_direction(stations[k - 1], stations[k], f)};
}

store::Table uncertainty_table(const survey::Survey& survey, const propagate::ToolCovariances& result,
                               const UncertaintyReport& report) {
  const std::vector<Level> levels = levels_of(report);
  std::string meanings;
  for (const Level& level : levels)
    if (&level != &levels.front()) meanings += fmt::format("; {}: {}", level.name, level.meaning);
  compare::TableRows t("uncertainty",
                       fmt::format("position uncertainty at {}{}",
                                   report.md.size() == 1 ? "the last station" : "the reported depths", meanings));
  for (const double md : report.md) {
    const PlaceInHole place = place_at(survey, result.total, md);
    const Matrix3d& c = place.covariance;
    const Matrix3d to_hla = survey::rotation_hla_from_nev(place.direction.inclination, place.direction.azimuth);
    const Matrix3d hla = to_hla * c * to_hla.transpose();
    const propagate::Ellipse e = propagate::ellipse(c.topLeftCorner<2, 2>());
    const auto row = [&](const char* quantity, double sd, bool is_axis, double azimuth) {
      t.number("md_m", "m", "measured depth", md);
      t.word("quantity", "direction; semi_major, semi_minor: axes of the horizontal ellipse", quantity);
      for (const Level& level : levels)
        t.number(level.name + "_m", "m", level.meaning, sd * (is_axis ? level.ellipse : level.line));
      t.number("azimuth_deg", "deg", "of an axis of the ellipse, true north, 0 to 180", azimuth / kDegree);
    };
    constexpr std::array<const char*, 6> kDirections{"north", "east", "vertical", "high_side", "lateral", "along_hole"};
    for (int i = 0; i < 6; ++i)
      row(kDirections[static_cast<std::size_t>(i)], standard_deviation(i < 3 ? c(i, i) : hla(i - 3, i - 3)), false,
          kNaN);
    row("semi_major", e.semi_major, true, e.azimuth);
    row("semi_minor", e.semi_minor, true, std::fmod(e.azimuth + kPi / 2, kPi));
  }
  return t.take();
}

}  // namespace surveymc::studies::position_covariance
