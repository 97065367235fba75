#pragma once
/// Tables from rows: one line a column says its name, unit, meaning and value.
///
///   TableRows t("alarms", "alarms of every sensor");
///   for (const Sensor& s : sensors) {
///     t.word("sensor", "whose alarms", s.name);
///     t.number("first_alarm_h", "h", "hours into the test", s.first_alarm);
///     t.share("p_alarm", "share of realisations with any alarm", s.alarms, trials, confidence);
///   }
///   return t.take();
///
/// The first row makes the columns. Every further row has the same ones in the same order (asserted). Of a long table
/// the first rows go to the disk (store/row_spool.h).
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "stats/intervals.h"
#include "store/table.h"

namespace surveymc::compare {

class TableRows {
 public:
  /// `rows`: about as many will come, if that is known.
  TableRows(std::string name, std::string long_name, std::size_t rows = 0);

  void word(std::string_view name, std::string_view meaning, std::string value);
  void count(std::string_view name, std::string_view meaning, std::int64_t value);
  void count(std::string_view name, std::string_view meaning, std::uint64_t value);
  void count(std::string_view name, std::string_view meaning, int value);
  /// `ancillary`: names of the columns that hold the value's interval, separated by a space.
  void number(std::string_view name, std::string_view unit, std::string_view meaning, double value,
              std::string_view ancillary = {});

  /// A value and its bounds: columns `name`, `name`_ci_low, `name`_ci_high.
  void estimate(std::string_view name, std::string_view unit, std::string_view meaning, double value,
                const stats::Interval& interval);
  /// The same of a probability: `events` of `trials` with the exact interval; NaN without trials.
  void share(std::string_view name, std::string_view meaning, std::uint64_t events, std::uint64_t trials,
             double confidence);
  /// A test at a level: columns statistic, critical_low, critical_high (rejected below and above) and p_value.
  void test(double statistic, double critical_low, double critical_high, double p_value);
  /// Elements of a symmetric 3 x 3 matrix in m2: nn_m2, ee_m2, vv_m2, ne_m2, nv_m2, ev_m2 for the axes "nev".
  void covariance(std::string_view axes, std::string_view meaning, const Eigen::Matrix3d& c);

  /// Removes all rows and keeps the columns. A table without rows has columns, too: write any row, then drop it.
  void drop_rows();
  store::Table take();
  /// The same. Where there is no row, write() writes one, which is dropped again.
  template <class Write>
  store::Table take(Write write) {
    if (table_.columns.empty()) {
      write();
      drop_rows();
    }
    return take();
  }

 private:
  template <class T>
  void put(std::string_view name, std::string_view unit, std::string_view meaning, T value, std::string_view ancillary);

  store::Table table_;
  std::size_t expected_rows_;
  std::size_t next_ = 0;
  bool first_row_ = true;
};

/// Calls write(row) for every row. Without rows, writes an empty row and drops it, so that the table has its columns.
template <class Row, class Write>
void write_rows(TableRows& t, const std::vector<Row>& rows, Write write) {
  for (const Row& row : rows) write(row);
  if (!rows.empty()) return;
  write(Row{});
  t.drop_rows();
}

/// An angle (rad) in degrees, [0, 360).
double turn_in_degrees(double angle);

/// A table of numbers from values that stand row by row; `columns` have no values yet.
store::Table table_of_numbers(store::Table columns, const std::vector<double>& values);
/// An empty column for table_of_numbers().
store::Column number_column(const std::string& name, const std::string& unit, const std::string& meaning);

/// Table `failed_trials`: the numbers of the listed trials. `what` failed: "trials without a converged estimate".
store::Table failed_trials_table(const std::string& what, const std::vector<std::uint64_t>& trials);

}  // namespace surveymc::compare
