#include "config/survey_checks.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "base/units.h"
#include "config/config.h"
#include "config/survey_csv.h"
#include "survey/minimum_curvature.h"
#include "survey/survey_summary.h"

namespace surveymc::config {
namespace {

constexpr double kDeepest = 16000;                // m; the deepest wells measure 15 km
constexpr double kDrillable = 30 * kDegree / 30;  // rad/m
constexpr double kLeastDogleg = 3 * kDegree, kTurnedBack = 179 * kDegree;
constexpr double kTvdShare = 0.02, kTvdRounding = 1;  // of the interval; m: depths may be listed whole
constexpr double kStepRatio = 30, kLongStep = 1500;   // m
constexpr const char* kTypingError = "a typing error?";

/// The columns of a survey file as they are written.
struct Columns {
  const InputTable& table;
  int md, inclination, azimuth;

  explicit Columns(const InputTable& t)
      : table(t),
        md(std::max(t.find("md_m"), t.find("md_ft"))),
        inclination(t.find("inclination_deg")),
        azimuth(azimuth_column(t)) {}
  const std::vector<double>& values(int column) const { return table.columns[static_cast<std::size_t>(column)]; }
  std::string cell(int column, std::size_t row) const {
    return fmt::format("{} = {}", table.names[static_cast<std::size_t>(column)], format_number(values(column)[row]));
  }
  bool in_metres(int column) const { return table.names[static_cast<std::size_t>(column)].ends_with("_m"); }
  /// A length, m, in the unit of that column.
  std::string length(int column, double metres, int digits = 6) const {
    return in_metres(column) ? fmt::format("{:.{}g} m", metres, digits)
                             : fmt::format("{:.{}g} ft", metres / kFoot, digits);
  }
  /// A curvature, rad/m, as drillers of that unit say it.
  std::string curvature(double value, int digits) const {
    return in_metres(md) ? fmt::format("{:.{}g} deg/30 m", value * 30 / kDegree, digits)
                         : fmt::format("{:.{}g} deg/100 ft", value * 100 * kFoot / kDegree, digits);
  }
  std::string place(std::size_t row) const { return fmt::format("{}:{}", table.path, table.lines[row]); }
};

/// Azimuths up to 2 pi, of which several differ.
bool may_azimuths_be_radians(const Columns& c) {
  const auto& azimuth = c.values(c.azimuth);
  const auto [least, most] = std::minmax_element(azimuth.begin(), azimuth.end());
  return *least >= 0 && *most <= 2 * kPi && std::set<double>(azimuth.begin(), azimuth.end()).size() >= 3;
}

/// And inclinations up to pi: hardly degrees, unless the hole is vertical.
bool looks_like_radians(const Columns& c, double steepest) {
  return steepest > 0.2 && steepest <= kPi && may_azimuths_be_radians(c);
}

void find_bad_depths(const Columns& c, const survey::Survey& survey, std::vector<SurveyFinding>& out) {
  for (const std::size_t row : {std::size_t{0}, c.table.rows() - 1}) {  // depths increase
    const double md = survey.stations[row].md;
    if (md < 0)
      out.push_back(
          {true, c.place(row), c.cell(c.md, row), "measured depth counts from the drill floor: must be 0 or more", ""});
    if (md > kDeepest)
      out.push_back({true, c.place(row), c.cell(c.md, row),
                     fmt::format("no well is deeper than {:g} km{}", kDeepest / 1000,
                                 c.in_metres(c.md) ? ", unless these are feet (md_ft)" : ""),
                     ""});
  }
  std::vector<double> steps;
  for (std::size_t k = 2; k < survey.stations.size(); ++k)  // the first station may be a tie-on far above the second
    steps.push_back(survey.stations[k].md - survey.stations[k - 1].md);
  if (steps.size() < 3) return;
  std::vector<double> sorted = steps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t k = 0; k < steps.size(); ++k)
    if (steps[k] > kLongStep && steps[k] > kStepRatio * usual)
      out.push_back({false, c.place(k + 2), c.cell(c.md, k + 2),
                     fmt::format("{} beyond the station before, where {} are usual", c.length(c.md, steps[k]),
                                 c.length(c.md, usual, 4)),
                     kTypingError});
}

void find_bad_angles(const Columns& c, const survey::Survey& survey, std::vector<SurveyFinding>& out) {
  const auto &inclination = c.values(c.inclination), &azimuth = c.values(c.azimuth);
  const double steepest = *std::max_element(inclination.begin(), inclination.end());
  const double most = *std::max_element(azimuth.begin(), azimuth.end());
  if (looks_like_radians(c, steepest))
    out.push_back({true, c.table.path + ": columns inclination_deg, azimuth_deg", "",
                   fmt::format("no inclination is larger than {:.4g}, and no azimuth than {:.4g}: these look like "
                               "radians; they must be degrees",
                               steepest, most),
                   ""});
  else if (steepest > kPi && may_azimuths_be_radians(c))  // one well in sixty goes there
    out.push_back({false, c.table.path + ": column azimuth_deg", "",
                   fmt::format("no azimuth is larger than {:.4g}", most),
                   "does the well go due north, or are these radians, which must be degrees?"});
  for (std::size_t row = 0; row < c.table.rows(); ++row) {
    const double a = azimuth[row];
    if (a >= 0 && a <= 360) continue;
    out.push_back({true, c.place(row), c.cell(c.azimuth, row),
                   fmt::format("must be in [0, 360]: {:.10g} if no digit is wrong", a - 360 * std::floor(a / 360)),
                   ""});
  }
  const std::vector<double> doglegs = survey::doglegs(survey);
  for (std::size_t k = 1; k < survey.stations.size(); ++k) {
    const double angle = doglegs[k], length = survey.stations[k].md - survey.stations[k - 1].md;
    const bool turns_back = angle > kTurnedBack;
    if (!turns_back && !(angle > kLeastDogleg && angle > kDrillable * length)) continue;
    const std::string cells = fmt::format("{}, {}", c.cell(c.inclination, k), c.cell(c.azimuth, k)),
                      turn = fmt::format("the hole turns by {:.4g} degrees in {}", angle / kDegree,
                                         c.length(c.md, length, 4));
    if (turns_back)
      out.push_back({true, c.place(k), cells, turn + ": it would turn back on itself", ""});
    else
      out.push_back({false, c.place(k), cells,
                     fmt::format("{} ({}): no tool drills more than {}", turn, c.curvature(angle / length, 4),
                                 c.curvature(kDrillable, 3)),
                     kTypingError});
  }
}

/// Listed vertical depths must go with the stations: whatever the method, a leg's mean direction lies between those of
/// its ends. Where the vertical datum is does not matter. Feet that are called metres are found here.
void find_bad_tvd(const Columns& c, const survey::Survey& survey, std::vector<SurveyFinding>& out) {
  const std::vector<double> listed = tvd_from_table(c.table);
  if (listed.empty()) return;
  const std::vector<double> computed = survey::true_vertical_depths(survey);
  SurveyFinding first{true, "", "", "", "are the units of depth right, and is it a depth, positive down?"};
  std::size_t others = 0;
  for (std::size_t k = 1; k < listed.size(); ++k) {
    const survey::Station &before = survey.stations[k - 1], &at = survey.stations[k];
    const double length = at.md - before.md, gained = listed[k] - listed[k - 1],
                 expected = computed[k] - computed[k - 1];
    if (std::abs(gained - expected) <= length * (kTvdShare + survey::dogleg(before, at) / 2) + kTvdRounding) continue;
    if (!first.place.empty()) {
      ++others;
      continue;
    }
    const int column = std::max(c.table.find("tvd_m"), c.table.find("tvd_ft"));
    first.place = c.place(k);
    first.value = c.cell(column, k);
    first.text = fmt::format("{} below the station before, where the inclinations give {} over {} of hole",
                             c.length(column, gained), c.length(column, expected), c.length(c.md, length));
  }
  if (first.place.empty()) return;
  if (others > 0) first.text += fmt::format(" (and {} station{} more)", others, others == 1 ? "" : "s");
  out.push_back(first);
}

}  // namespace

std::string SurveyFinding::in_words() const {
  std::string out = place;
  for (const std::string* more : {&value, &text, &way_out})
    if (!more->empty()) out += ": " + *more;
  return out;
}

std::vector<SurveyFinding> unusual_in_survey(const InputTable& table, const survey::Survey& survey) {
  const Columns columns(table);
  std::vector<SurveyFinding> out;
  find_bad_angles(columns, survey, out);
  find_bad_depths(columns, survey, out);
  find_bad_tvd(columns, survey, out);
  return out;
}

}  // namespace surveymc::config
