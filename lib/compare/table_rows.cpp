#include "compare/table_rows.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "base/units.h"
#include "store/result_file.h"
#include "store/row_spool.h"

namespace surveymc::compare {
namespace {

template <class T>
void add_to(store::Column& column, T value) {
  std::get<std::vector<T>>(column.values).push_back(std::move(value));
}

}  // namespace

TableRows::TableRows(std::string name, std::string long_name, std::size_t rows)
    : table_{std::move(name), std::move(long_name)}, expected_rows_(std::min(rows, store::kMostHeldRows)) {}

template <class T>
void TableRows::put(std::string_view name, std::string_view unit, std::string_view meaning, T value,
                    std::string_view ancillary) {
  std::vector<store::Column>& columns = table_.columns;
  if (next_ == columns.size()) {
    if (first_row_ && (columns.empty() || columns.front().name != name)) {
      columns.push_back(
          {std::string(name), std::string(unit), std::string(meaning), std::vector<T>{}, std::string(ancillary)});
      std::get<std::vector<T>>(columns.back().values).reserve(expected_rows_);
    } else {
      first_row_ = false;
      next_ = 0;
      constexpr std::size_t kLook = 4096;
      if (columns.front().size() % kLook == 0) store::hold_less(table_);
    }
  }
  store::Column& column = columns[next_++];
  assert(column.name == name);
  add_to(column, std::move(value));
}

void TableRows::word(std::string_view name, std::string_view meaning, std::string value) {
  put(name, "", meaning, std::move(value), {});
}
void TableRows::count(std::string_view name, std::string_view meaning, std::int64_t value) {
  put(name, "1", meaning, value, {});
}
void TableRows::count(std::string_view name, std::string_view meaning, std::uint64_t value) {
  count(name, meaning, static_cast<std::int64_t>(value));
}
void TableRows::count(std::string_view name, std::string_view meaning, int value) {
  count(name, meaning, std::int64_t{value});
}
void TableRows::number(std::string_view name, std::string_view unit, std::string_view meaning, double value,
                       std::string_view ancillary) {
  if (first_row_ || next_ == table_.columns.size()) return put(name, unit, meaning, value, ancillary);
  assert(table_.columns[next_].name == name);
  add_to(table_.columns[next_++], value);  // handing the texts on would take longer: there are many rows
}

void TableRows::estimate(std::string_view name, std::string_view unit, std::string_view meaning, double value,
                         const stats::Interval& interval) {
  const std::string low = std::string(name) + "_ci_low", high = std::string(name) + "_ci_high";
  number(name, unit, meaning, value, low + " " + high);
  number(low, unit, "lower bound of the confidence interval", interval.lo);
  number(high, unit, "upper bound of the confidence interval", interval.hi);
}

void TableRows::share(std::string_view name, std::string_view meaning, std::uint64_t events, std::uint64_t trials,
                      double confidence) {
  if (trials == 0)
    estimate(name, "1", meaning, kNaN, {kNaN, kNaN});
  else
    estimate(name, "1", meaning, static_cast<double>(events) / static_cast<double>(trials),
             stats::binomial_interval(events, trials, confidence));
}

void TableRows::test(double statistic, double critical_low, double critical_high, double p_value) {
  number("statistic", "1", "what is tested", statistic);
  number("critical_low", "1", "rejected below", critical_low);
  number("critical_high", "1", "rejected above", critical_high);
  number("p_value", "1", "probability of a statistic as extreme, by noise alone", p_value);
}

void TableRows::covariance(std::string_view axes, std::string_view meaning, const Eigen::Matrix3d& c) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kElements{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  for (const auto& [i, j] : kElements) {
    const double value = c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    if (!first_row_ && next_ < table_.columns.size()) {
      add_to(table_.columns[next_++], value);
      continue;
    }
    const std::array<char, 5> name{axes[i], axes[j], '_', 'm', '2'};
    number({name.data(), name.size()}, "m2", meaning, value);
  }
}

void TableRows::drop_rows() {
  for (store::Column& c : table_.columns) std::visit([](auto& values) { values.clear(); }, c.values);
}

store::Table TableRows::take() {
  assert(next_ == table_.columns.size());
  return std::move(table_);
}

double turn_in_degrees(double angle) {
  const double turn = std::fmod(angle / kDegree, 360.0);
  return turn < 0 ? turn + 360 : turn;
}

store::Column number_column(const std::string& name, const std::string& unit, const std::string& meaning) {
  return {name, unit, meaning, std::vector<double>{}};
}

store::Table table_of_numbers(store::Table t, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    std::get<std::vector<double>>(t.columns[i % t.columns.size()].values).push_back(values[i]);
  return t;
}

store::Table failed_trials_table(const std::string& what, const std::vector<std::uint64_t>& trials) {
  TableRows t("failed_trials", what + "; replay one with `surveymc run CONFIG --trial K`");
  write_rows(t, trials, [&](std::uint64_t trial) { t.count("trial", "number of the trial, from 0", trial); });
  return t.take();
}

}  // namespace surveymc::compare
