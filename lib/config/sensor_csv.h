#pragma once
/// Time series of a well's sensors as they come from a historian: with gaps, zeros, words and clocks that go back.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/input_file.h"

namespace surveymc::config {

/// Defects of a row, in the order of checking: a row counts once, for its first defect.
enum class RowDefect {
  cells,          ///< another number of cells than the header
  bad_time,       ///< the time is empty, no time, or has an offset from UTC where earlier ones have none (or has none)
  repeated_time,  ///< the time of the row before
  unsorted_time,  ///< a time before that of an earlier row
  empty,          ///< a sensor's cell is empty or NaN
  text,           ///< a sensor's cell is no number
  zero,           ///< a sensor reads exactly 0, if zeros are defects
};
inline constexpr int kRowDefects = 7;
const char* name(RowDefect defect);

struct SensorCsvOptions {
  /// Column: ISO 8601 (`2018-04-16 08:01:50.0`, with Z or +01:00 in all rows or in none), or a number if the name ends
  /// in _s, _min, _h or _d.
  std::string time;
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

/// What was found while the rows passed by.
struct SensorQuality {
  std::uint64_t rows_read = 0, good_rows = 0;
  Finding defects[kRowDefects];
  Finding gaps;  ///< the good row after each; nothing is left out for it
  bool mixed_offsets =
      false;                 ///< bad times are among them that have an offset from UTC, or have none, unlike the first
  double median_step_h = 0;  ///< of the first kTypicalSteps steps from good row to good row
};
/// A gap is measured by the median of so many steps (all of them in a shorter file).
inline constexpr std::size_t kTypicalSteps = std::size_t{1} << 16;

/// Some good rows that follow each other.
struct SensorBlock {
  std::vector<double> time_h;  ///< since the first good row of the file
  std::vector<double> values;  ///< rows x sensors, row by row
};

/// Reads a file from its first row to its last, block by block, in memory that does not depend on its length. What is
/// wrong with any row is in the findings, never silent. Rows come in the order of the file: a stream cannot be sorted,
/// so that a row before an earlier one is a defect.
class SensorCsvReader {
 public:
  /// Throws InputError "path:line: ..." if a column is missing or named twice, or there is no header.
  SensorCsvReader(const InputFile& file, const SensorCsvOptions& options);

  /// Up to `most` good rows; false if there are none left. The findings are whole then.
  bool next(SensorBlock& block, std::size_t most);
  const SensorQuality& found() const { return found_; }
  /// Reads the rest only to prove that the file is still the one that the result names.
  void skip_to_end() { lines_.skip_to_end(); }

 private:
  /// Where the columns stand, and how to read a time.
  struct Layout {
    std::size_t width = 0, time = 0;
    std::vector<std::size_t> sensors;
    double time_unit = 0;
  };
  struct Row {
    std::optional<RowDefect> defect;
    double seconds = 0;
  };
  Row judge(std::vector<double>& values);
  void read_header();
  void watch_step(double step_h, std::int64_t line);
  void settle_steps();

  LineReader lines_;
  SensorCsvOptions options_;
  std::string path_;
  Layout layout_;
  std::vector<std::string_view> cells_;
  std::optional<double> first_, latest_;  // seconds of the first good row, and of the last whose clock counts
  std::optional<double> latest_good_h_;
  std::optional<bool> has_offsets_;  // whether clocks say how far they are from UTC, by the first of them
  std::vector<std::pair<double, std::int64_t>> steps_;  // until there are kTypicalSteps
  bool settled_ = false;
  SensorQuality found_;
};

/// Throws InputError "path: 3 rows with an empty cell (lines 5, 7, 9), ...: ..." if anything was found.
void reject_findings(const SensorQuality& found, const std::string& path);

/// Unit that a column's name ends in ("pt_f_kPa" -> "kPa"), "" if it ends in none that sensors have.
std::string sensor_unit_of_name(const std::string& name);

}  // namespace surveymc::config
