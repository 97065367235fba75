#pragma once
/// Time series of a well's sensors as they come from a historian: with gaps, zeros, words and clocks that go back.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace surveymc {

/// What can be wrong with a row, in the order of checking: a row counts once, for the first that is.
enum class RowDefect {
  cells,          ///< another number of cells than the header
  bad_time,       ///< the time is empty or no time
  repeated_time,  ///< the time of the row before
  unsorted_time,  ///< a time before that of an earlier row
  empty,          ///< a sensor's cell is empty or NaN
  text,           ///< a sensor's cell is no number
  zero,           ///< a sensor reads exactly 0, if zeros are defects
};
inline constexpr int kRowDefects = 7;
const char* name(RowDefect defect);

struct SensorCsvOptions {
  std::string time;  ///< column: ISO 8601 (`2018-04-16 08:01:50.0`), or a number if the name ends in _s, _min, _h or _d
  std::vector<std::string> sensors;  ///< columns to read; others are not looked at
  bool zero_is_defect = true;        ///< a dead channel of a historian reads 0
  double gap_factor = 1.5;           ///< a step of more than so many median steps is a gap
};

/// How often something was found, and in which lines (1-based; the first kListed of them).
struct Finding {
  static constexpr std::size_t kListed = 10;
  std::uint64_t rows = 0;
  std::vector<std::int64_t> lines;
  void add(std::int64_t line);
};

struct SensorCsv {
  std::vector<double> time_h;  ///< since the first good row
  std::vector<double> values;  ///< rows x sensors, row by row: good rows only
  std::vector<std::int64_t> lines;
  std::uint64_t rows_read = 0;
  Finding defects[kRowDefects];
  Finding gaps;  ///< the good row after each; nothing is left out for it
  double median_step_h = 0;
};

/// Reads all rows; what is wrong with any of them is in the findings, never silent. Throws InputError
/// "path:line: ..." if a column is missing or named twice, or if there are not two good rows.
SensorCsv read_sensor_csv(std::string_view text, const std::string& path, const SensorCsvOptions& options);

/// Throws InputError "path: 3 rows with an empty cell (lines 5, 7, 9), ...: ..." if anything was found.
void reject_findings(const SensorCsv& csv, const std::string& path);

/// Unit that a column's name ends in ("pt_f_kPa" -> "kPa"), "" if it ends in none that sensors have.
std::string sensor_unit_of_name(const std::string& name);

}  // namespace surveymc
