#pragma once
/// Building tables: empty columns of a kind, and rows written into them.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "store/table.h"

namespace surveymc {

/// Grows a table row by row: numbers and words in the order of its columns.
class TableWriter {
 public:
  explicit TableWriter(Table table) : table_(std::move(table)) {}
  TableWriter& operator<<(double x) { return put(x); }
  TableWriter& operator<<(std::int64_t x) { return put(x); }
  TableWriter& operator<<(const std::string& x) { return put(x); }
  Table take() { return std::move(table_); }

 private:
  template <class T>
  TableWriter& put(const T& x) {
    std::get<std::vector<T>>(table_.columns[next_].values).push_back(x);
    next_ = (next_ + 1) % table_.columns.size();
    return *this;
  }
  Table table_;
  std::size_t next_ = 0;
};

inline Column number_column(const std::string& name, const std::string& unit, const std::string& meaning,
                            const std::string& ancillary = "") {
  return {name, unit, meaning, std::vector<double>{}, ancillary};
}
inline Column word_column(const std::string& name, const std::string& meaning) {
  return {name, "", meaning, std::vector<std::string>{}};
}
inline Column count_column(const std::string& name, const std::string& meaning) {
  return {name, "1", meaning, std::vector<std::int64_t>{}};
}
/// A Monte-Carlo column and its two companions.
inline void add_with_interval(Table& t, const std::string& name, const std::string& unit, const std::string& meaning) {
  t.columns.push_back(number_column(name, unit, meaning, name + "_ci_low " + name + "_ci_high"));
  t.columns.push_back(number_column(name + "_ci_low", unit, "lower bound of the confidence interval"));
  t.columns.push_back(number_column(name + "_ci_high", unit, "upper bound of the confidence interval"));
}

}  // namespace surveymc
