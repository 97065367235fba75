#pragma once
/// Columns whose values a rule gives: nothing but the rule is held.
#include <cstddef>
#include <cstdint>
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
