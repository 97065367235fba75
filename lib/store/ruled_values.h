#pragma once
/// Columns whose values are not there yet, or never: a rule gives them, and nothing but the rule is held.
#include <cstddef>
#include <cstdint>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "store/table.h"

namespace surveymc::store {

/// 0, 1, 2, ...
class RowNumbers final : public DiskValues {
 public:
  explicit RowNumbers(std::size_t rows) : rows_(rows) {}
  std::size_t size() const override { return rows_; }
  Values read(std::size_t first, std::size_t count) const override;

 private:
  std::size_t rows_;
};

/// Every number so many times, one after the other.
class RepeatedNumbers final : public DiskValues {
 public:
  RepeatedNumbers(std::vector<double> numbers, std::size_t times) : numbers_(std::move(numbers)), times_(times) {}
  std::size_t size() const override { return numbers_.size() * times_; }
  Values read(std::size_t first, std::size_t count) const override;

 private:
  std::vector<double> numbers_;
  std::size_t times_;
};

/// A column of a table that another thread still makes: who reads it waits. What that thread throws passes through.
class LaterValues final : public DiskValues {
 public:
  /// `rows` that the table will have.
  LaterValues(std::size_t rows, std::shared_future<Table> table, std::size_t column)
      : rows_(rows), table_(std::move(table)), column_(column) {}
  std::size_t size() const override { return rows_; }
  Values read(std::size_t first, std::size_t count) const override { return values_of(made(), first, count); }
  const Values* held() const override { return made().on_disk ? nullptr : &made().values; }

 private:
  const Column& made() const { return table_.get().columns[column_]; }

  std::size_t rows_;
  std::shared_future<Table> table_;
  std::size_t column_;
};

/// The same words, so many times over.
class CycledWords final : public DiskValues {
 public:
  CycledWords(std::vector<std::string> words, std::size_t times) : words_(std::move(words)), times_(times) {}
  const std::vector<std::string>& words() const { return words_; }
  std::size_t times() const { return times_; }
  std::size_t size() const override { return words_.size() * times_; }
  Values read(std::size_t first, std::size_t count) const override;

 private:
  std::vector<std::string> words_;
  std::size_t times_;
};

}  // namespace surveymc::store
