#include "config/survey_csv.h"

#include <algorithm>
#include <array>

#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "config/config.h"
#include "config/suggest.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

/// A column the file may have: its stem, and the unit suffixes we know with their factor to SI.
struct Known {
  const char* stem;
  std::vector<std::pair<const char*, double>> units;
};
constexpr std::size_t kColumns = 6, kToolface = 3, kTvd = 4;
const std::array<Known, kColumns>& known_columns() {
  static const std::array<Known, kColumns> columns{{{"md", {{"m", 1.0}, {"ft", kFoot}}},
                                                    {"inclination", {{"deg", kDegree}}},
                                                    {"azimuth", {{"deg", kDegree}}},
                                                    {"toolface", {{"deg", kDegree}}},
                                                    {"tvd", {{"m", 1.0}, {"ft", kFoot}}},
                                                    {"time", {{"s", 1.0}}}}};
  return columns;
}

constexpr std::array<std::pair<const char*, NamedNorth>, 5> kAzimuths{
    {{"azimuth_deg", NamedNorth::none},
     {"azimuth_unreferenced_deg", NamedNorth::unreferenced},
     {"azimuth_true_deg", NamedNorth::true_north},
     {"azimuth_magnetic_deg", NamedNorth::magnetic},
     {"azimuth_grid_deg", NamedNorth::grid}}};

/// The name with which a column is looked up: every azimuth is `azimuth_deg`.
std::string plain_name(const std::string& name) {
  const bool is_azimuth =
      std::any_of(kAzimuths.begin(), kAzimuths.end(), [&](const auto& a) { return name == a.first; });
  return is_azimuth ? "azimuth_deg" : name;
}

std::string spellings(const Known& k) {
  std::vector<std::string> names;
  for (const auto& u : k.units) names.push_back(fmt::format("{}_{}", k.stem, u.first));
  return fmt::format("{}", fmt::join(names, " or "));
}

[[noreturn]] void unknown_column(const InputTable& table, const std::string& name) {
  const std::string stem = name.substr(0, name.find('_'));
  for (const Known& k : known_columns())
    if (stem == k.stem)
      throw InputError(fmt::format("{}:{}: column {}: {}: write {}", table.path, table.names_line, shortened(name),
                                   name == stem ? "the unit is missing" : "unknown unit", spellings(k)));
  std::vector<std::string> names;
  for (const Known& k : known_columns())
    for (const auto& u : k.units) names.push_back(fmt::format("{}_{}", k.stem, u.first));
  throw InputError(fmt::format(
      "{}:{}: column {}: unknown column: take it out, or write remarks in lines that begin with #; a survey "
      "has md_m or md_ft, inclination_deg, azimuth_deg and optionally toolface_deg, tvd_m or tvd_ft, time_s{}",
      table.path, table.names_line, shortened(name), suggestion(name, names)));
}

}  // namespace

int azimuth_column(const InputTable& table) {
  for (std::size_t c = 0; c < table.names.size(); ++c)
    if (plain_name(table.names[c]) == "azimuth_deg") return static_cast<int>(c);
  return -1;
}

NamedNorth named_north(const InputTable& table) {
  const int c = azimuth_column(table);
  for (const auto& [name, north] : kAzimuths)
    if (c >= 0 && table.names[static_cast<std::size_t>(c)] == name) return north;
  return NamedNorth::none;
}

void require_survey_names(const InputTable& table) {
  for (const std::string& name : table.names) {
    bool found = false;
    for (const Known& k : known_columns())
      for (const auto& u : k.units) found = found || plain_name(name) == fmt::format("{}_{}", k.stem, u.first);
    if (!found) unknown_column(table, name);
  }
}

survey::Survey survey_from_table(const InputTable& table, const SurveyConventions& conventions, bool needs_toolface) {
  // Column of the file and factor to SI for each known quantity.
  std::array<int, kColumns> column{-1, -1, -1, -1, -1, -1};
  std::array<double, kColumns> factor{};
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    bool found = false;
    for (std::size_t q = 0; q < kColumns; ++q)
      for (const auto& [unit, to_si] : known_columns()[q].units)
        if (plain_name(table.names[c]) == fmt::format("{}_{}", known_columns()[q].stem, unit)) {
          require(column[q] < 0, "{}:{}: column {}: the file has {} twice", table.path, table.names_line,
                  table.names[c], known_columns()[q].stem);
          column[q] = static_cast<int>(c);
          factor[q] = to_si;
          found = true;
        }
    if (!found) unknown_column(table, table.names[c]);
  }
  for (std::size_t q = 0; q < kTvd; ++q)
    require(column[q] >= 0 || (q == kToolface && !needs_toolface), "{}:{}: column {}: missing{}", table.path,
            table.names_line, spellings(known_columns()[q]),
            q == kToolface ? " (this experiment needs the toolface of every station; or say how the tool was "
                             "turned: [drilling] mode = \"rotating\", \"sliding\" or \"random\")"
                           : "");

  const double to_true = conventions.azimuth_reference == AzimuthReference::magnetic ? conventions.declination
                         : conventions.azimuth_reference == AzimuthReference::grid   ? conventions.convergence
                                                                                     : 0.0;
  const double to_y = conventions.toolface_zero == ToolfaceZero::x ? kPi / 2 : 0.0;
  const auto cell = [&](std::size_t q, std::size_t row) {
    return column[q] < 0 ? 0.0 : table.columns[static_cast<std::size_t>(column[q])][row];
  };
  survey::Survey survey;
  survey.stations.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row)
    survey.stations.push_back({cell(0, row) * factor[0], cell(1, row) * factor[1], cell(2, row) * factor[2] + to_true,
                               cell(3, row) * kDegree + to_y});

  const survey::SurveyDefect defect = survey::find_defect(survey);
  if (defect.rule.empty()) return survey;
  require(defect.station >= 0, "{}: {} station{}: {}", table.path, table.rows(), table.rows() == 1 ? "" : "s",
          defect.rule);
  const auto row = static_cast<std::size_t>(defect.station);
  const std::size_t q = defect.quantity == "md" ? 0 : 1;
  std::string before = q == 0 ? fmt::format(" ({})", format_number(cell(q, row - 1))) : "";
  if (q == 0 && row > 1 && cell(q, row) > cell(q, row - 2) &&
      cell(q, row - 1) - cell(q, row - 2) > 5 * (cell(q, row) - cell(q, row - 2)))
    before += fmt::format("; or is that one, in line {}, the typing error?", table.lines[row - 1]);
  throw InputError(fmt::format("{}:{}: {} = {}: {}{}", table.path, table.lines[row],
                               table.names[static_cast<std::size_t>(column[q])], format_number(cell(q, row)),
                               defect.rule, before));
}

std::vector<double> tvd_from_table(const InputTable& table) {
  for (const auto& [unit, to_si] : known_columns()[kTvd].units) {
    const int c = table.find(fmt::format("tvd_{}", unit));
    if (c < 0) continue;
    std::vector<double> tvd = table.columns[static_cast<std::size_t>(c)];
    for (double& x : tvd) x *= to_si;
    return tvd;
  }
  return {};
}

std::vector<double> times_from_table(const InputTable& table) {
  const int c = table.find("time_s");
  if (c < 0) return {};
  const std::vector<double>& times = table.columns[static_cast<std::size_t>(c)];
  for (std::size_t row = 1; row < times.size(); ++row)
    require(times[row] >= times[row - 1], "{}:{}: time_s = {}: must not be earlier than at the station before ({})",
            table.path, table.lines[row], format_number(times[row]), format_number(times[row - 1]));
  return times;
}

}  // namespace surveymc::config
