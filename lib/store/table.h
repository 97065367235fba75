#pragma once
/// The output of a study: tables of named columns and maps over named axes, as plain values.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace surveymc::store {

using Values = std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>>;

/// Values of a column that are not held: on the disk, or made when they are asked for.
class DiskValues {
 public:
  virtual ~DiskValues() = default;
  virtual std::size_t size() const = 0;
  /// Values first .. first + count - 1. Throws IoError.
  virtual Values read(std::size_t first, std::size_t count) const = 0;
};

/// So many values that a function gives.
class MadeValues final : public DiskValues {
 public:
  using Make = std::function<Values(std::size_t first, std::size_t count)>;
  MadeValues(std::size_t size, Make make) : size_(size), make_(std::move(make)) {}
  std::size_t size() const override { return size_; }
  Values read(std::size_t first, std::size_t count) const override { return make_(first, count); }

 private:
  std::size_t size_;
  Make make_;
};

/// One column of a table. All columns of a table have one length.
struct Column {
  std::string name;            ///< identifier; a quantity with a unit ends in it (`md_m`)
  std::string unit;            ///< "1" for a pure number, "" for text
  std::string long_name;       ///< one line for a reader
  Values values;               ///< all of them, unless the table is too long to be held: then the last ones
  std::string ancillary = {};  ///< names of the interval columns, separated by a space ("x_ci_low x_ci_high")
  std::shared_ptr<const DiskValues> on_disk = {};  ///< those in front of `values`, of the kind of `values`

  std::size_t size() const;
  /// Calls visit(values) for all values, in order: in pieces those on the disk, then those that are held.
  void for_each_piece(const std::function<void(const Values&)>& visit) const;
};

/// A table that is built row by row may get too long for the memory: move_to_disk() of store/row_spool.h. Whoever makes
/// a table reads its `values`; whoever is given one that may be long goes through it by for_each_piece() and rows_of().
struct Table {
  std::string name, long_name;
  std::vector<Column> columns = {};

  std::size_t rows() const;                                         ///< 0 without columns
  bool is_held() const;                                             ///< no value is on the disk
  const Column* find_column(const std::string& column_name) const;  ///< null without such a column
  /// Throws std::out_of_range when there is no such column.
  const Column& column(const std::string& column_name) const;
  /// The word of a row that is held; "" without such a column of words.
  std::string word(const std::string& column_name, std::size_t row) const;
  /// The number of a row that is held; NaN without such a column of numbers or counts.
  double number(const std::string& column_name, std::size_t row) const;
};

/// One coordinate of a map.
struct Axis {
  std::string name, unit, long_name;
  std::variant<std::vector<double>, std::vector<std::string>> values;
};

/// Values on the product of the axes, the last axis fastest. Infinity is IEEE inf.
struct Map {
  std::string name, unit, long_name;
  std::vector<Axis> axes;
  std::vector<double> values;
};

/// Maps that are too large for memory, all over the same axes. Their values are computed (or read) piece by piece when
/// the maps are written or hashed.
struct MapStream {
  std::vector<Map> maps;  ///< `values` are empty
  /// Values first .. first + count - 1 of every map, in the order of `maps`. Called for all of them in rising order,
  /// possibly several times over; the same bits each time.
  std::function<std::vector<std::vector<double>>(std::size_t first, std::size_t count)> values;
};

/// Product of the axes' lengths: how many values a map has.
std::size_t map_size(const Map& map);

/// Values first .. first + count - 1 of a column.
Values values_of(const Column& column, std::size_t first, std::size_t count);

/// Rows first .. first + count - 1 as a table that is held.
Table rows_of(const Table& table, std::size_t first, std::size_t count);

/// Calls visit(piece, first) for all rows, in order; every piece is held, and begins with row `first`. A table that is
/// held is one piece.
void for_each_piece(const Table& table, const std::function<void(const Table& piece, std::size_t first)>& visit);

/// Rows of `more` below those of `table`, which has the same columns (asserted), or none and no name: then it becomes
/// `more`. What gets too long goes to the disk.
void append_rows(Table& table, Table more);

/// In column `expected` of a row that may agree or differ: that of an approximation, or of what others say. Where it
/// differs, that is a finding.
inline constexpr const char* kEither = "either";

/// Long name of the first columns of a table, and axes of a map, that are the keys of a sweep.
inline constexpr const char* kSweepKey = "sweep key";

}  // namespace surveymc::store
