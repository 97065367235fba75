#include "cli/print_result.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/units.h"
#include "compare/answer.h"

namespace surveymc::cli {
namespace {

/// Feet of a metre, square feet of a square metre; 0 for any other unit.
double feet_per(const std::string& unit) { return unit == "m" ? 1 / kFoot : unit == "m2" ? 1 / (kFoot * kFoot) : 0.0; }

/// "sd_north_m" -> "sd_north_ft", "nn_m2_ci_low" -> "nn_ft2_ci_low"
std::string renamed(std::string name) {
  for (const auto& [metres, feet] : {std::pair{"_m", "_ft"}, {"_m2", "_ft2"}})
    for (const char* ending : {"", "_ci_low", "_ci_high"}) {
      const std::string tail = std::string(metres) + ending;
      if (name.ends_with(tail)) return name.substr(0, name.size() - tail.size()) + feet + ending;
    }
  return name;
}

void scale_column(store::Column& column) {
  auto* values = std::get_if<std::vector<double>>(&column.values);
  const double factor = feet_per(column.unit);
  if (!values || factor == 0) return;
  for (double& x : *values) x *= factor;
  column.unit = column.unit == "m" ? "ft" : "ft2";
  column.name = renamed(column.name);
}

/// Whether a column is in the unit that the row says, or a bound of one that is.
bool is_in_unit_of_row(const store::Table& table, const store::Column& column) {
  const auto says_so = [](const store::Column& c) {
    return c.long_name.find("the row's unit") != std::string::npos || c.name == "plain" || c.name == "controlled" ||
           c.name == "analytic";
  };
  return says_so(column) || std::any_of(table.columns.begin(), table.columns.end(), [&](const store::Column& c) {
           return says_so(c) && (column.name == c.name + "_ci_low" || column.name == c.name + "_ci_high");
         });
}

}  // namespace

store::Table in_feet(store::Table table) {
  for (store::Column& column : table.columns) scale_column(column);
  const auto unit = std::find_if(table.columns.begin(), table.columns.end(),
                                 [](const store::Column& c) { return c.name == "unit" && c.unit.empty(); });
  if (unit == table.columns.end()) return table;
  auto& units = std::get<std::vector<std::string>>(unit->values);
  bool any = false;
  for (store::Column& column : table.columns) {
    auto* values = std::get_if<std::vector<double>>(&column.values);
    if (!values || !is_in_unit_of_row(table, column)) continue;
    any = true;
    for (std::size_t row = 0; row < values->size(); ++row)
      if (const double factor = feet_per(units[row]); factor > 0) (*values)[row] *= factor;
  }
  for (std::string& u : units)
    if (any && feet_per(u) > 0) u = u == "m" ? "ft" : "ft2";
  return table;
}

std::string in_feet(std::string sentence, const std::string& sources, const std::vector<store::Table>& tables) {
  std::size_t at = 0;
  for (std::size_t begin = 0; begin < sources.size();) {
    const std::size_t end = std::min(sources.find("; ", begin), sources.size());
    const double value = compare::number_at(tables, sources.substr(begin, end - begin));
    begin = end + 2;
    const std::string metres = compare::three_digits(value) + " m";
    const std::size_t place = std::isfinite(value) ? sentence.find(metres, at) : std::string::npos;
    if (place == std::string::npos) continue;
    const std::size_t behind = place + metres.size();
    if (behind < sentence.size() && std::isalnum(static_cast<unsigned char>(sentence[behind]))) continue;
    const std::string feet = compare::three_digits(value / kFoot) + " ft";
    sentence.replace(place, metres.size(), feet);
    at = place + feet.size();
  }
  return sentence;
}

}  // namespace surveymc::cli
