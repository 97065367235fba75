#include "config/observatory.h"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/units.h"
#include "config/sensor_csv.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

/// Codes of IAGA-2002: 99999 no value was measured, 88888 the element is not recorded.
constexpr double kMissing = 88000;

struct Minutes {
  double step = 0;                            ///< s
  std::array<std::vector<double>, 3> values;  ///< as reported
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t from = line.find_first_not_of(' ', i);
    if (from == std::string_view::npos) break;
    const std::size_t to = std::min(line.find(' ', from), line.size());
    words.push_back(line.substr(from, to - from));
    i = to;
  }
  return words;
}

std::optional<double> number_of(std::string_view text) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(x)) return std::nullopt;
  return x;
}

/// Seconds since 1970 of "2016-01-31" and "23:59:00.000".
std::optional<double> seconds_of(std::string_view date, std::string_view time) {
  if (date.size() != 10 || date[4] != '-' || date[7] != '-' || time.size() < 8 || time[2] != ':' || time[5] != ':')
    return std::nullopt;
  const auto year = number_of(date.substr(0, 4)), month = number_of(date.substr(5, 2)), day = number_of(date.substr(8)),
             hour = number_of(time.substr(0, 2)), minute = number_of(time.substr(3, 2)),
             second = number_of(time.substr(6));
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  using namespace std::chrono;
  const year_month_day ymd{std::chrono::year(static_cast<int>(*year)),
                           std::chrono::month(static_cast<unsigned>(*month)),
                           std::chrono::day(static_cast<unsigned>(*day))};
  if (!ymd.ok()) return std::nullopt;
  return static_cast<double>(sys_days(ymd).time_since_epoch().count()) * 86400 + *hour * 3600 + *minute * 60 + *second;
}

/// Rows one after the other; refuses gaps.
class Steps {
 public:
  explicit Steps(const std::string& path) : path_(path) {}
  void next(double seconds, std::int64_t line, std::string_view time) {
    if (count_ == 1) step_ = seconds - last_;
    require(count_ == 0 || seconds > last_, "{}:{}: {}: not later than the row before", path_, line, time);
    require(count_ < 2 || std::abs(seconds - last_ - step_) < 0.01 * step_,
            "{}:{}: {}: a gap: {:g} s after the row before, where rows are {:g} s apart; a series must have none: cut "
            "the file to a part without gaps",
            path_, line, time, seconds - last_, step_);
    last_ = seconds;
    ++count_;
  }
  double step() const { return step_; }

 private:
  const std::string& path_;
  double last_ = 0, step_ = 0;
  std::size_t count_ = 0;
};

disturbance::Series series_of(const Minutes& m, const std::string& path, bool is_turned) {
  disturbance::Series s;
  s.step = m.step;
  const auto n = static_cast<Eigen::Index>(m.values[0].size());
  require(n >= 3, "{}: has {} rows: a series needs at least 3", path, n);
  s.field.resize(3, n);
  for (int i = 0; i < 3; ++i)
    s.field.row(i) = Eigen::Map<const Eigen::RowVectorXd>(m.values[static_cast<std::size_t>(i)].data(), n);
  if (!is_turned) return s;
  const double north = s.field.row(0).mean(), east = s.field.row(1).mean(), h = std::hypot(north, east);
  const Eigen::RowVectorXd along = (north * s.field.row(0) + east * s.field.row(1)) / h;
  s.field.row(1) = (north * s.field.row(1) - east * s.field.row(0)) / h;
  s.field.row(0) = along;
  return s;
}

disturbance::Series iaga_series(const InputFile& file) {
  LineReader lines(file);
  std::string_view line;
  std::string reported;
  std::vector<std::string> names;
  Minutes m;
  Steps steps(file.path);
  while (lines.next(line)) {
    const std::string_view content = trimmed(line);
    if (content.empty()) continue;
    std::vector<std::string_view> words = words_of(content);
    if (names.empty()) {
      if (words[0] == "Reported" && words.size() > 1) reported = std::string(words[1]);
      if (words[0] == "DATE") names.assign(words.begin(), words.end());
      if (words[0] == "DATE")
        require(reported.starts_with("XYZ") || reported.starts_with("HEZ") || reported.starts_with("HDZ"),
                "{}: Reported {}: must be of XYZ, HEZ, HDZ", file.path, reported.empty() ? "(missing)" : reported);
      continue;
    }
    require(words.size() >= 6 && names.size() >= 6, "{}:{}: must have date, time, day of the year and three elements",
            file.path, lines.number());
    const std::string time = std::string(words[0]) + " " + std::string(words[1]);
    const auto seconds = seconds_of(words[0], words[1]);
    require(seconds.has_value(), "{}:{}: {}: not a date and time", file.path, lines.number(), time);
    steps.next(*seconds, lines.number(), time);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto x = number_of(words[3 + i]);
      require(x.has_value(), "{}:{}: {}: {} = {}: not a number", file.path, lines.number(), time, names[3 + i],
              words[3 + i]);
      require(*x < kMissing,
              "{}:{}: {}: {} is missing ({}): a series must have no gap: cut the file to a part without "
              "gaps",
              file.path, lines.number(), time, names[3 + i], words[3 + i]);
      m.values[i].push_back(*x);
    }
  }
  require(!names.empty(), "{}: has no line of names that begins with DATE", file.path);
  m.step = steps.step();
  if (reported[1] == 'D') {
    double mean = 0;
    for (const double d : m.values[1]) mean += d / static_cast<double>(m.values[1].size());
    for (std::size_t k = 0; k < m.values[0].size(); ++k) {
      const double h = m.values[0][k], turn = (m.values[1][k] - mean) / 60 * kDegree;
      m.values[0][k] = h * std::cos(turn);
      m.values[1][k] = h * std::sin(turn);
    }
  }
  return series_of(m, file.path, reported[0] == 'X');
}

disturbance::Series csv_series(const InputFile& file) {
  SensorCsvOptions options;
  options.time = "time";
  options.sensors = {"x_nT", "y_nT", "z_nT"};
  options.zero_is_defect = false;
  options.gap_factor = 1.01;
  SensorCsvReader reader(file, options);
  SensorBlock block;
  Minutes m;
  double last_h = 0;
  while (reader.next(block, 4096))
    for (std::size_t k = 0; k < block.time_h.size(); ++k) {
      last_h = block.time_h[k];
      for (std::size_t i = 0; i < 3; ++i) {
        const double x = block.values[3 * k + i];
        require(
            x < kMissing,
            "{}: {} = {:g} at {:.6g} h after the first row: 99999 and 88888 stand for missing values; a series must "
            "have no gap: cut the file to a part without gaps",
            file.path, options.sensors[i], x, last_h);
        m.values[i].push_back(x);
      }
    }
  const SensorQuality& found = reader.found();
  const auto refuse = [&](const Finding& f, const char* what) {
    require(f.rows == 0, "{}:{}: {}: a series must have no gap: cut the file to a part without gaps", file.path,
            f.lines.empty() ? 0 : f.lines.front(), what);
  };
  for (int d = 0; d < kRowDefects; ++d) refuse(found.defects[d], name(static_cast<RowDefect>(d)));
  refuse(found.gaps, "a gap before this row");
  const auto steps = static_cast<double>(found.good_rows) - 1;
  require(std::abs(last_h - steps * found.median_step_h) < 0.01 * found.median_step_h, "{}: rows are not equally apart",
          file.path);
  m.step = std::round(found.median_step_h * 3.6e6) / 1000;
  return series_of(m, file.path, true);
}

}  // namespace

disturbance::Series observatory_series(const InputFile& file) {
  std::string_view first;
  bool is_iaga = false;
  {
    LineReader lines(file);
    if (lines.next(first)) is_iaga = first.find("IAGA-2002") != std::string_view::npos;
    lines.skip_to_end();
  }
  return is_iaga ? iaga_series(file) : csv_series(file);
}

}  // namespace surveymc::config
