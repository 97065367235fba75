#include "config/sensor_csv.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "config/text.h"

namespace surveymc {
namespace {

/// Next line without its end; false at the end of the text.
bool next_line(std::string_view& rest, std::string_view& line) {
  if (rest.empty()) return false;
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

/// Cells between commas; a cell in quotes may hold commas. Views into the line: reading is the whole run's cost.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t i = 0;;) {
    std::size_t end = i;
    for (bool quoted = false; end < line.size() && (quoted || line[end] != ','); ++end)
      if (line[end] == '"') quoted = !quoted;
    std::string_view cell = trimmed(line.substr(i, end - i));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (end >= line.size()) return;
    i = end + 1;
  }
}

std::optional<double> number_of(std::string_view cell) {
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-' && cell[1] != '+') cell.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return x;
}

/// "2018-04-16 08:01:50.25", with T or a blank in the middle and perhaps Z at the end, as seconds since 1970.
std::optional<double> iso_seconds(std::string_view s) {
  if (!s.empty() && s.back() == 'Z') s.remove_suffix(1);
  if (s.size() < 16 || s[4] != '-' || s[7] != '-' || (s[10] != ' ' && s[10] != 'T') || s[13] != ':')
    return std::nullopt;
  const auto whole = [&](std::size_t at, std::size_t count) -> int {
    int x = 0;
    const auto [end, error] = std::from_chars(s.data() + at, s.data() + at + count, x);
    return error == std::errc() && end == s.data() + at + count ? x : -1;
  };
  const int hour = whole(11, 2), minute = whole(14, 2);
  double second = 0;
  if (s.size() > 16) {
    const auto x = s[16] == ':' ? number_of(s.substr(17)) : std::nullopt;
    if (!x) return std::nullopt;
    second = *x;
  }
  using namespace std::chrono;
  const year_month_day day{year(whole(0, 4)), month(static_cast<unsigned>(whole(5, 2))),
                           std::chrono::day(static_cast<unsigned>(whole(8, 2)))};
  if (!day.ok() || hour < 0 || hour > 23 || minute < 0 || minute > 59 || !(second >= 0 && second < 61))
    return std::nullopt;
  return static_cast<double>(sys_days(day).time_since_epoch().count()) * 86400 + hour * 3600 + minute * 60 + second;
}

/// Seconds in the unit that the column's name ends in; 0: it is a clock.
double time_unit(const std::string& name) {
  const std::string unit = name.substr(std::min(name.rfind('_'), name.size()));
  return unit == "_s" ? 1 : unit == "_min" ? 60 : unit == "_h" ? 3600 : unit == "_d" ? 86400 : 0;
}

std::size_t column_of(const std::vector<std::string_view>& header, const std::string& name, const std::string& place) {
  const auto it = std::find(header.begin(), header.end(), name);
  std::string known;
  for (const auto& h : header) known += (known.empty() ? "" : ", ") + std::string(h);
  require(it != header.end(), "{}: no column \"{}\"; there are {}", place, shortened(name), shortened(known));
  require(std::find(it + 1, header.end(), name) == header.end(), "{}: {}: two columns have this name", place, name);
  return static_cast<std::size_t>(it - header.begin());
}

/// Where the columns stand, and how to read a time.
struct Layout {
  std::size_t width, time;
  std::vector<std::size_t> sensors;
  double time_unit;
};

struct Row {
  std::optional<RowDefect> defect;
  double seconds = 0;
};

/// Judges a row; appends its values, good or not, to `values`.
Row judge_row(const std::vector<std::string_view>& cells, const Layout& at, bool zero_is_defect,
              std::optional<double> latest, std::vector<double>& values) {
  if (cells.size() != at.width) return {RowDefect::cells};
  const std::string_view time = cells[at.time];
  const auto clock = at.time_unit > 0 ? number_of(time) : iso_seconds(time);
  if (!clock || !std::isfinite(*clock)) return {RowDefect::bad_time};
  const double seconds = at.time_unit > 0 ? *clock * at.time_unit : *clock;
  if (latest && seconds == *latest) return {RowDefect::repeated_time, seconds};
  if (latest && seconds < *latest) return {RowDefect::unsorted_time, seconds};
  Row row{std::nullopt, seconds};
  for (const std::size_t c : at.sensors) {
    const auto x = number_of(cells[c]);
    if (cells[c].empty() || (x && std::isnan(*x)))
      row.defect = std::min(row.defect.value_or(RowDefect::empty), RowDefect::empty);
    else if (!x || !std::isfinite(*x))
      row.defect = std::min(row.defect.value_or(RowDefect::text), RowDefect::text);
    else if (*x == 0 && zero_is_defect && !row.defect)
      row.defect = RowDefect::zero;
    values.push_back(x.value_or(0));
  }
  return row;
}

void find_gaps(SensorCsv& csv, double factor) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < csv.time_h.size(); ++i) steps.push_back(csv.time_h[i] - csv.time_h[i - 1]);
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  csv.median_step_h = *middle;
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (steps[i] > factor * csv.median_step_h) csv.gaps.add(csv.lines[i + 1]);
}

std::string in_words(const Finding& f, const std::string& what) {
  std::string lines;
  for (const auto l : f.lines) lines += (lines.empty() ? "" : ", ") + std::to_string(l);
  return fmt::format("{}: {} (line{} {}{})", what, f.rows, f.rows == 1 ? "" : "s", lines,
                     f.rows > f.lines.size() ? ", ..." : "");
}

}  // namespace

void Finding::add(std::int64_t line) {
  if (++rows <= kListed) lines.push_back(line);
}

const char* name(RowDefect d) {
  constexpr const char* kNames[kRowDefects] = {"cells", "bad_time", "repeated_time", "unsorted_time",
                                               "empty", "text",     "zero"};
  return kNames[static_cast<int>(d)];
}

SensorCsv read_sensor_csv(std::string_view text, const std::string& path, const SensorCsvOptions& options) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  SensorCsv csv;
  std::optional<Layout> layout;
  std::vector<std::string_view> cells;
  std::optional<double> first, latest;
  std::string_view line;
  for (std::int64_t number = 1; next_line(text, line); ++number) {
    const std::string_view content = trimmed(line);
    if (content.empty() || content.front() == '#') continue;
    split(line, cells);
    if (!layout) {
      const std::string place = fmt::format("{}:{}", path, number);
      layout = Layout{cells.size(), column_of(cells, options.time, place), {}, time_unit(options.time)};
      for (const std::string& s : options.sensors) layout->sensors.push_back(column_of(cells, s, place));
      continue;
    }
    ++csv.rows_read;
    const std::size_t before = csv.values.size();
    const Row row = judge_row(cells, *layout, options.zero_is_defect, latest, csv.values);
    if (row.defect) {
      csv.values.resize(before);
      csv.defects[static_cast<int>(*row.defect)].add(number);
      // The clock of a row with a dead sensor still counts; that of a wrong clock does not.
      if (*row.defect >= RowDefect::empty) latest = row.seconds;
      continue;
    }
    latest = row.seconds;
    if (!first) first = row.seconds;
    csv.time_h.push_back((row.seconds - *first) / 3600);
    csv.lines.push_back(number);
  }
  require(layout.has_value(), "{}: is empty: must have a line of column names, then rows", path);
  require(csv.lines.size() >= 2, "{}: {} good row{} of {}: must be at least two", path, csv.lines.size(),
          csv.lines.size() == 1 ? "" : "s", csv.rows_read);
  find_gaps(csv, options.gap_factor);
  return csv;
}

void reject_findings(const SensorCsv& csv, const std::string& path) {
  constexpr const char* kWords[kRowDefects] = {"rows with another number of cells than the header",
                                               "rows without a valid time",
                                               "repeated times",
                                               "times before that of an earlier row",
                                               "rows with an empty sensor cell",
                                               "rows with text for a sensor",
                                               "rows in which a sensor reads zero"};
  std::string found;
  const auto add = [&](const Finding& f, const char* what) {
    if (f.rows > 0) found += (found.empty() ? "" : "; ") + in_words(f, what);
  };
  for (int d = 0; d < kRowDefects; ++d) add(csv.defects[d], kWords[d]);
  add(csv.gaps, "gaps in time");
  require(found.empty(), "{}: {}: say source.bad_rows = \"skip\" to go on without these rows and over these gaps", path,
          found);
}

std::string sensor_unit_of_name(const std::string& name) {
  const auto underscore = name.rfind('_');
  if (underscore == std::string::npos || underscore == 0) return "";
  const std::string unit = name.substr(underscore + 1);
  for (const char* known : {"Pa", "kPa", "MPa", "bar", "psi", "degC", "degF", "K", "m3ps", "m3ph", "kgps"})
    if (unit == known) return unit;
  return "";
}

}  // namespace surveymc
