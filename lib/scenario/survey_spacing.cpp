#include "scenario/survey_spacing.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "config/survey_csv.h"
#include "survey/interpolated_survey.h"
#include "survey/minimum_curvature.h"

namespace surveymc::scenario {
namespace {

constexpr double kSparse = 100, kUsual = 30;  // m
constexpr double kLargestFactor = 1.2;        // of standard deviations
constexpr double kMostStations = 20'000;      // of a well with stations every 30 m: 600 km

/// Variance of the last position, m2.
double variance(const propagate::ToolCovariances& c) { return c.total.back().trace(); }

/// The source whose variance the spacing makes larger by most.
std::string most_grown(const propagate::ToolCovariances& sparse, const propagate::ToolCovariances& dense) {
  std::size_t most = 0;
  const auto growth = [&](std::size_t i) { return sparse.by_source[i].trace() - dense.by_source[i].trace(); };
  for (std::size_t i = 1; i < sparse.sources.size(); ++i)
    if (growth(i) > growth(most)) most = i;
  return sparse.sources[most];
}

}  // namespace

void add_spacing_warning(std::vector<compare::Warning>& warnings, const survey::Survey& survey,
                         const std::vector<double>& tvd, const ToolRuns& tools, const survey::ReferenceField& field,
                         double latitude, const std::string& well, const std::string& key) {
  const double longest = survey::longest_interval(survey);
  if (!(longest > kSparse) || survey::interpolated_stations(survey, kUsual) > kMostStations) return;
  const survey::InterpolatedSurvey dense = survey::interpolated(survey, kUsual);
  std::vector<propagate::ToolRun> runs = tools.runs;
  for (std::size_t r = 1; r < runs.size(); ++r) {
    const auto from = std::find_if(dense.survey.stations.begin(), dense.survey.stations.end(),
                                   [&](const survey::Station& s) { return survey::is_deeper(s.md, tools.from_md[r]); });
    runs[r].first = static_cast<int>(from - dense.survey.stations.begin());
  }
  const auto covariances = [&](const survey::Survey& s, const std::vector<double>& depths,
                               const std::vector<propagate::ToolRun>& of) {
    return propagate::tool_covariances(s, depths, of, field, latitude, propagate::SourceDetail::last);
  };
  const propagate::ToolCovariances as_given = covariances(survey, tvd, tools.runs),
                                   usual = covariances(dense.survey,
                                                       survey::interpolated_values(
                                                           dense, tvd, survey::true_vertical_depths(dense.survey)),
                                                       runs);
  const double given_sd = std::sqrt(variance(as_given)), usual_sd = std::sqrt(variance(usual));
  if (!(given_sd > kLargestFactor * usual_sd)) return;  // NaN: another warning says why
  const double share = 100 * (1 - variance(usual) / variance(as_given));
  warnings.push_back(
      {"warning", well.empty() ? "survey" : well, "",
       fmt::format(
           "stations are up to {:.4g} m apart: at the last one the position has a standard deviation of "
           "{:.3g} m (root of the trace), and of {:.3g} m with stations every {:g} m on the same path: {:.3g} % "
           "of its variance is made by the spacing, most of it by {}",
           longest, given_sd, usual_sd, kUsual, share, most_grown(as_given, usual)),
       fmt::format("if these are key points of a well that is surveyed more often, set {} = {:g} (of a planned well "
                   "survey.plan.spacing_m)",
                   key, kUsual)});
}

survey::Survey read_interpolation(config::ConfigReader& c, const std::string& key, const survey::Survey& survey,
                                  bool needs_toolface) {
  // By has(), so that no default of it is written into every config.
  if (!c.has(key)) return survey;
  const double spacing = c.number(key, config::Range::closed(1, 1000),
                                  "stations are put between those of the file, at most so far apart, on the path of "
                                  "minimum curvature: for a well that is given by key points");
  c.require(!needs_toolface, key, "there are no toolfaces between stations, and this study needs them: leave it out");
  c.require(survey::interpolated_stations(survey, spacing) < 100'000.5, key, "gives more than 100000 stations");
  survey::Survey dense = survey::interpolated(survey, spacing).survey;
  c.note(fmt::format("{} = {:g}: {} stations become {}", key, spacing, survey.size(), dense.size()));
  return dense;
}

std::vector<double> true_vertical_depths_of(const config::InputTable& table, const survey::Survey& survey) {
  const std::vector<double> listed = config::tvd_from_table(table);
  std::vector<double> computed = survey::true_vertical_depths(survey);
  if (listed.empty()) return computed;
  if (listed.size() == computed.size()) return listed;
  survey::InterpolatedSurvey dense{survey, {}};
  for (const double md : config::survey_from_table(table, {}, false).md())
    dense.given.push_back(survey::station_at(survey, md).value());
  return survey::interpolated_values(dense, listed, computed);
}

}  // namespace surveymc::scenario
