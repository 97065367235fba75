#pragma once
/// What a study has found, in two or three sentences. Every number of a sentence is in a table of the same result. The
/// table `answer` says in which cell, so that a reader and a test can look it up.
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "store/table.h"

namespace surveymc::compare {

inline constexpr const char* kAnswerTable = "answer";

/// A number of a table, for a sentence. `source` is one of
///   TABLE.COLUMN[ROW]                              a cell; rows count from 0
///   count TABLE                                    the number of its rows
///   count TABLE where COLUMN = WORD and ...        the number of these rows; also COLUMN != WORD, COLUMN finite,
///                                                  COLUMN in LOW..HIGH
/// with " * NUMBER" behind it.
struct Figure {
  double value = kNaN;
  std::string unit = {};  ///< what stands behind the number; "" for a pure number
  std::string source = {};
  int decimals = -1;  ///< -1: three digits

  Figure times(double factor) const;
  Figure percent() const;  ///< of a share or a ratio
  Figure with_unit(const std::string& of_number) const;
  Figure with_decimals(int count) const;  ///< in place of three digits: of an angle, which is a place on a circle
};

/// Words of a sentence, and the sources of the numbers in them, in their order.
struct Phrase {
  std::string text;
  std::vector<std::string> sources;

  Phrase(std::string words) : text(std::move(words)) {}
  Phrase(const char* words) : text(words) {}
  Phrase(const Figure& figure);
  /// `pattern` with the parts in place of its "{}", of which there are as many. Throws
  /// std::logic_error.
  Phrase(std::string_view pattern, std::initializer_list<Phrase> parts);
};

/// Three significant digits, and all digits before the decimal point: "0.0912", "1.94", "2514", "3.1e-12".
std::string three_digits(double value);

/// A table that is too long to be held in memory: no sentence is made of its cells.
struct LongTable {
  Figure rows;
  std::string name;
};

/// Some rows of one table, in its order.
class Rows {
 public:
  /// All rows of the table of this name; none if there is no such table. Throws LongTable.
  Rows(const std::vector<store::Table>& tables, std::string_view name);

  /// Those with this word in a column, and the others. Without such a column: none, and all.
  Rows where(std::string_view column, std::string_view word) const;
  Rows without(std::string_view column, std::string_view word) const;
  /// Those whose number in a column is finite, or lies between two others, which belong to it.
  Rows with(std::string_view column) const;
  Rows between(std::string_view column, double low, double high) const;
  /// The row with the largest (least) number in a column, or with the largest size(number); the first of equal ones.
  /// None if no row has a finite number.
  Rows at_largest(std::string_view column, const std::function<double(double)>& size = {}) const;
  Rows at_least(std::string_view column) const;
  Rows first() const;
  Rows last() const;

  /// The different words of a column, in their order.
  std::vector<std::string> words(std::string_view column) const;

  bool empty() const { return rows_.empty(); }
  std::size_t size() const { return rows_.size(); }
  bool has(std::string_view column) const;

  /// How many rows these are.
  Figure count() const;
  /// Of the first of these rows; NaN or "" if there is none, or no such column.
  double number(std::string_view column) const;
  std::string word(std::string_view column) const;
  /// The number with its unit: that of the column, or of the row where the column has the one of its row.
  Figure figure(std::string_view column) const;
  /// " (noise.scale = 0.5)": the point of a sweep that the first of these rows is of; "" without a sweep.
  Phrase point() const;
  /// Those of the point of a sweep that the first of `other`, rows of the same table, is of.
  Rows at_point_of(const Rows& other) const;

 private:
  const store::Column* column(std::string_view name) const;
  /// The keys of the sweep, which stand in front.
  std::vector<const store::Column*> sweep_columns() const;
  /// Those of which keep(row) is true: all rows that meet `condition`, too.
  template <class Keep>
  Rows kept(const std::string& condition, Keep keep) const;
  /// The one at this place among these.
  Rows one(std::size_t place) const;

  const store::Table* table_ = nullptr;
  std::vector<std::size_t> rows_;
  std::string conditions_ = {};  ///< "verdict = agrees and unit = m": these are the rows of which that is true
};

/// The number that a source of an answer names, of a cell times a factor; NaN of a source of another form.
double number_at(const std::vector<store::Table>& tables, const std::string& source);

/// The sentences of an answer.
class Answer {
 public:
  /// Adds the sentence Phrase(pattern, parts).
  void say(std::string_view pattern, std::initializer_list<Phrase> parts = {});

  /// Says whether `subject` holds, by the verdicts of these rows: "The prediction holds: 5 of 5 standard deviations
  /// agree within 2 %." `what`: the plural of what is compared. Rows that are expected to differ are a finding of their
  /// own. Says nothing without verdicts.
  void say_verdicts(const Rows& rows, const std::string& what, const std::string& subject = "The prediction");

  /// Says how many trials failed, where some table has a row without them.
  void say_failures(const std::vector<store::Table>& tables);

  /// Says in one sentence how many of these rows agree with each formulation. Says nothing without verdicts.
  void say_formulations(const Rows& rows, const std::string& what);

  bool empty() const { return sentences_.empty(); }
  /// Columns sentence, sources.
  store::Table table() const;

 private:
  std::vector<Phrase> sentences_;
};

}  // namespace surveymc::compare
