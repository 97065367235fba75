#include "config/readings_csv.h"

#include <array>
#include <string>
#include <utility>

#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "config/config.h"
#include "config/suggest.h"
#include "config/text.h"
#include "survey/survey.h"

namespace surveymc::config {
namespace {

constexpr std::size_t kReadingColumns = 7;

/// Columns of one kind share their unit: depth, accelerometers, magnetometers.
struct ReadingKind {
  std::vector<const char*> stems;
  std::vector<std::pair<const char*, double>> units;  // suffix and factor to SI
};
const std::array<ReadingKind, 3>& reading_kinds() {
  static const std::array<ReadingKind, 3> all{{{{"md"}, {{"m", 1.0}, {"ft", kFoot}}},
                                               {{"gx", "gy", "gz"}, {{"mps2", 1.0}, {"mg", kMilliG}}},
                                               {{"bx", "by", "bz"}, {{"nT", 1.0}, {"uT", 1000.0}}}}};
  return all;
}

std::string spellings(const ReadingKind& kind, const char* stem) {
  std::vector<std::string> names;
  for (const auto& u : kind.units) names.push_back(fmt::format("{}_{}", stem, u.first));
  return fmt::format("{}", fmt::join(names, " or "));
}

[[noreturn]] void unknown_reading_column(const InputTable& table, const std::string& name) {
  const std::string stem = name.substr(0, name.find_first_of("_ "));
  for (const ReadingKind& kind : reading_kinds())
    for (const char* known : kind.stems)
      if (stem == known)
        throw InputError(fmt::format("{}:{}: column {}: {}: write {}", table.path, table.names_line, shortened(name),
                                     name == stem ? "the unit is missing" : "unknown unit", spellings(kind, known)));
  std::vector<std::string> names;
  for (const ReadingKind& kind : reading_kinds())
    for (const char* stem_of : kind.stems)
      for (const auto& u : kind.units) names.push_back(fmt::format("{}_{}", stem_of, u.first));
  throw InputError(
      fmt::format("{}:{}: column {}: unknown column: take it out, or write remarks in lines that begin with #; a file "
                  "of readings has md_m or md_ft, gx, gy, gz in _mps2 or _mg, and bx, by, bz in _nT or _uT{}",
                  table.path, table.names_line, shortened(name), suggestion(name, names)));
}

/// The seven columns in the order of reading_kinds(), in SI.
std::array<std::vector<double>, kReadingColumns> columns_in_si(const InputTable& table,
                                                               std::array<std::string, kReadingColumns>& names) {
  std::array<std::vector<double>, kReadingColumns> values;
  std::vector<bool> used(table.names.size(), false);
  std::size_t slot = 0;
  for (const ReadingKind& kind : reading_kinds()) {
    const char* unit_of_kind = nullptr;
    for (const char* stem : kind.stems) {
      for (const auto& [unit, to_si] : kind.units) {
        const std::string name = fmt::format("{}_{}", stem, unit);
        const int c = table.find(name);
        if (c < 0) continue;
        const auto column = static_cast<std::size_t>(c);
        used[column] = true;
        require(names[slot].empty(), "{}:{}: column {}: the file has {} twice", table.path, table.names_line, name,
                stem);
        require(!unit_of_kind || unit_of_kind == unit, "{}:{}: column {}: {} is in {}: the three axes share one unit",
                table.path, table.names_line, name, kind.stems.front(), unit_of_kind ? unit_of_kind : "");
        unit_of_kind = unit;
        names[slot] = name;
        for (const double x : table.columns[column]) values[slot].push_back(x * to_si);
      }
      ++slot;
    }
  }
  for (std::size_t c = 0; c < used.size(); ++c)
    if (!used[c]) unknown_reading_column(table, table.names[c]);
  slot = 0;
  for (const ReadingKind& kind : reading_kinds())
    for (const char* stem : kind.stems)
      require(!names[slot++].empty(), "{}:{}: column {}: missing", table.path, table.names_line, spellings(kind, stem));
  return values;
}

}  // namespace

void require_readings_names(const InputTable& table) {
  for (const std::string& name : table.names) {
    bool found = false;
    for (const ReadingKind& kind : reading_kinds())
      for (const char* stem : kind.stems)
        for (const auto& u : kind.units) found = found || name == fmt::format("{}_{}", stem, u.first);
    if (!found) unknown_reading_column(table, name);
  }
}

survey::SixAxisReadings readings_from_table(const InputTable& table, const ReadingsConventions& conventions) {
  std::array<std::string, kReadingColumns> names;
  const auto si = columns_in_si(table, names);
  const double down = conventions.accelerometers == AccelerometerSign::gravity ? 1 : -1;
  survey::SixAxisReadings r;
  r.accelerometer_sign = down;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const int line = table.lines[row];
    if (row > 0 && !(si[0][row] > si[0][row - 1])) {
      const auto& md = table.columns[static_cast<std::size_t>(table.find(names[0]))];
      throw InputError(fmt::format("{}:{}: {} = {}: must be greater than the one before ({})", table.path, line,
                                   names[0], format_number(md[row]), format_number(md[row - 1])));
    }
    require(row == 0 || survey::is_deeper(si[0][row], si[0][row - 1]),
            "{}:{}: {}: is within 1 mm of the one before: must be another depth", table.path, line, names[0]);
    const survey::Vec3<double> g{down * si[1][row], down * si[2][row], down * si[3][row]};
    const survey::Vec3<double> b{si[4][row], si[5][row], si[6][row]};
    const double gravity = norm(g) / conventions.gravity, field = norm(b) / conventions.total_field;
    require(gravity > 0.5 && gravity < 2,
            "{}:{}: {}, {}, {}: their vector is {:.4g} m/s2 long, the reference is {:.4g}: is the unit right, are the "
            "columns in place?",
            table.path, line, names[1], names[2], names[3], norm(g), conventions.gravity);
    const double widest = conventions.is_uncalibrated ? 10 : 3;
    require(field * widest > 1 && field < widest,
            "{}:{}: {}, {}, {}: their vector is {:.6g} nT long, the reference is {:.6g}: is the unit right, are the "
            "columns in place?",
            table.path, line, names[4], names[5], names[6], norm(b), conventions.total_field);
    r.md.push_back(si[0][row]);
    r.gravity_T.push_back(g);
    r.magnetic_T.push_back(b);
  }
  require(table.rows() >= conventions.fewest_stations,
          "{}: {} station{}: three gains and three biases need at least {} stations (two residuals each), and more to "
          "check them",
          table.path, table.rows(), table.rows() == 1 ? "" : "s", conventions.fewest_stations);
  return r;
}

}  // namespace surveymc::config
