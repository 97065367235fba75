#include "config/sensor_csv.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include <fmt/ranges.h>

#include "base/error.h"
#include "config/csv_cells.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

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

/// What a time says: seconds since 1970 of a clock, in UTC where it gives its offset.
struct Clock {
  double seconds;
  bool has_offset;
};

/// Takes Z, +01:00, -0330 or +01 off the end of a clock; seconds to be taken from it. Nothing where there is none.
std::optional<double> take_offset(std::string_view& s) {
  if (!s.empty() && s.back() == 'Z') {
    s.remove_suffix(1);
    return 0;
  }
  constexpr std::size_t kDate = 10;
  const std::size_t sign = s.find_last_of("+-");
  if (sign == std::string_view::npos || sign <= kDate) return std::nullopt;
  const std::string_view offset = s.substr(sign + 1);
  const bool has_colon = offset.size() == 5 && offset[2] == ':';
  if (offset.size() != 2 && offset.size() != 4 && !has_colon) return std::nullopt;
  const auto digits = [&](std::size_t at) -> int {
    const auto digit = [&](std::size_t i) { return offset[i] >= '0' && offset[i] <= '9' ? offset[i] - '0' : 1000; };
    return 10 * digit(at) + digit(at + 1);
  };
  const int hours = digits(0), minutes = offset.size() == 2 ? 0 : digits(offset.size() - 2);
  if (hours > 14 || minutes > 59) return std::nullopt;
  const double seconds = hours * 3600 + minutes * 60;
  const bool is_east = s[sign] == '+';
  s = trimmed(s.substr(0, sign));
  return is_east ? seconds : -seconds;
}

/// "2018-04-16 08:01:50.25", with T or a blank in the middle and perhaps an offset from UTC at the end.
std::optional<Clock> iso_clock(std::string_view s) {
  const std::optional<double> offset = take_offset(s);
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
  const double days = static_cast<double>(sys_days(day).time_since_epoch().count());
  return Clock{days * 86400 + hour * 3600 + minute * 60 + second - offset.value_or(0), offset.has_value()};
}

/// Seconds in the unit that the column's name ends in; 0: it is a clock.
double time_unit(const std::string& name) {
  const std::string unit = name.substr(std::min(name.rfind('_'), name.size()));
  return unit == "_s" ? 1 : unit == "_min" ? 60 : unit == "_h" ? 3600 : unit == "_d" ? 86400 : 0;
}

std::size_t column_of(const std::vector<std::string_view>& header, const std::string& name, const std::string& place) {
  const auto it = std::find(header.begin(), header.end(), name);
  const std::string known = fmt::format("{}", fmt::join(header, ", "));
  const bool is_one = header.size() == 1 && known.find(name) != std::string::npos && known != name;
  require(it != header.end(), "{}: no column \"{}\"; there are {}{}", place, shortened(name), shortened(known),
          is_one ? ": cells must be separated by commas, with decimal points" : "");
  require(std::find(it + 1, header.end(), name) == header.end(), "{}: {}: two columns have this name", place, name);
  return static_cast<std::size_t>(it - header.begin());
}

std::string in_words(const Finding& f, const std::string& what) {
  return fmt::format("{}: {} (line{} {}{})", what, f.rows, f.rows == 1 ? "" : "s", fmt::join(f.lines, ", "),
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

SensorCsvReader::SensorCsvReader(const InputFile& file, const SensorCsvOptions& options)
    : lines_(file), options_(options), path_(file.path) {
  read_header();
}

void SensorCsvReader::read_header() {
  std::string_view line;
  while (lines_.next(line)) {
    const std::string_view content = trimmed(line);
    if (is_no_row(content)) continue;
    split(line, cells_);
    const std::string place = fmt::format("{}:{}", path_, lines_.number());
    layout_ = Layout{cells_.size(), column_of(cells_, options_.time, place), {}, time_unit(options_.time)};
    for (const std::string& s : options_.sensors) layout_.sensors.push_back(column_of(cells_, s, place));
    return;
  }
  require(false, "{}: is empty: must have a line of column names, then rows", path_);
}

/// Judges the row in `cells_`; appends its values, good or not, to `values`.
SensorCsvReader::Row SensorCsvReader::judge(std::vector<double>& values) {
  if (cells_.size() != layout_.width) return {RowDefect::cells};
  const std::string_view time = cells_[layout_.time];
  double seconds = 0;
  if (layout_.time_unit > 0) {
    const auto number = number_of(time);
    if (!number || !std::isfinite(*number)) return {RowDefect::bad_time};
    seconds = *number * layout_.time_unit;
  } else {
    const auto clock = iso_clock(time);
    if (!clock) return {RowDefect::bad_time};
    if (clock->has_offset != has_offsets_.value_or(clock->has_offset)) {
      found_.mixed_offsets = true;  // local times and times in UTC have no common order
      return {RowDefect::bad_time};
    }
    has_offsets_ = clock->has_offset;
    seconds = clock->seconds;
  }
  if (latest_ && seconds == *latest_) return {RowDefect::repeated_time, seconds};
  if (latest_ && seconds < *latest_) return {RowDefect::unsorted_time, seconds};
  Row row{std::nullopt, seconds};
  for (const std::size_t c : layout_.sensors) {
    const auto x = number_of(cells_[c]);
    if (cells_[c].empty() || (x && std::isnan(*x)))
      row.defect = std::min(row.defect.value_or(RowDefect::empty), RowDefect::empty);
    else if (!x || !std::isfinite(*x))
      row.defect = std::min(row.defect.value_or(RowDefect::text), RowDefect::text);
    else if (*x == 0 && options_.zero_is_defect && !row.defect)
      row.defect = RowDefect::zero;
    values.push_back(x.value_or(0));
  }
  return row;
}

/// The median of the steps so far, and the gaps among them.
void SensorCsvReader::settle_steps() {
  settled_ = true;
  if (steps_.empty()) return;
  std::vector<double> sorted;
  for (const auto& [step, line] : steps_) sorted.push_back(step);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  found_.median_step_h = *middle;
  for (const auto& [step, line] : steps_)
    if (step > options_.gap_factor * found_.median_step_h) found_.gaps.add(line);
  steps_ = {};
}

void SensorCsvReader::watch_step(double step_h, std::int64_t line) {
  if (settled_) {
    if (step_h > options_.gap_factor * found_.median_step_h) found_.gaps.add(line);
    return;
  }
  steps_.emplace_back(step_h, line);
  if (steps_.size() == kTypicalSteps) settle_steps();
}

bool SensorCsvReader::next(SensorBlock& block, std::size_t most) {
  block.time_h.clear();
  block.values.clear();
  std::string_view line;
  while (block.time_h.size() < most && lines_.next(line)) {
    const std::string_view content = trimmed(line);
    if (is_no_row(content)) continue;
    split(line, cells_);
    ++found_.rows_read;
    const std::size_t before = block.values.size();
    const Row row = judge(block.values);
    if (row.defect) {
      block.values.resize(before);
      found_.defects[static_cast<int>(*row.defect)].add(lines_.number());
      // The clock of a row with a dead sensor still counts; that of a wrong clock does not.
      if (*row.defect >= RowDefect::empty) latest_ = row.seconds;
      continue;
    }
    latest_ = row.seconds;
    if (!first_) first_ = row.seconds;
    const double time_h = (row.seconds - *first_) / 3600;
    if (latest_good_h_) watch_step(time_h - *latest_good_h_, lines_.number());
    latest_good_h_ = time_h;
    block.time_h.push_back(time_h);
    ++found_.good_rows;
  }
  if (block.time_h.size() < most && !settled_) settle_steps();
  return !block.time_h.empty();
}

void reject_findings(const SensorQuality& quality, const std::string& path) {
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
  for (int d = 0; d < kRowDefects; ++d) add(quality.defects[d], kWords[d]);
  add(quality.gaps, "gaps in time");
  if (quality.mixed_offsets) found += "; some times have an offset from UTC and some have none";
  const bool unsorted = quality.defects[static_cast<int>(RowDefect::unsorted_time)].rows > 0;
  require(found.empty(), "{}: {}: set source.bad_rows = \"skip\" to ignore them{}", path, found,
          unsorted ? ", or sort the file by time first: it is read as a stream, in its own order" : "");
}

std::string sensor_unit_of_name(const std::string& name) {
  const auto underscore = name.rfind('_');
  if (underscore == std::string::npos || underscore == 0) return "";
  const std::string unit = name.substr(underscore + 1);
  for (const char* known : {"Pa", "kPa", "MPa", "bar", "psi", "degC", "degF", "K", "m3ps", "m3ph", "kgps"})
    if (unit == known) return unit;
  return "";
}

}  // namespace surveymc::config
