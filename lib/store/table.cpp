#include "store/table.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "base/units.h"
#include "store/row_spool.h"

namespace surveymc::store {

std::size_t Column::size() const {
  return (on_disk ? on_disk->size() : 0) + std::visit([](const auto& v) { return v.size(); }, values);
}

void Column::for_each_piece(const std::function<void(const Values&)>& visit) const {
  const std::size_t before = on_disk ? on_disk->size() : 0;
  for (std::size_t at = 0; at < before; at += kPieceRows) visit(on_disk->read(at, std::min(kPieceRows, before - at)));
  visit(values);
}

std::size_t Table::rows() const { return columns.empty() ? 0 : columns.front().size(); }

bool Table::is_held() const {
  return std::none_of(columns.begin(), columns.end(), [](const Column& c) { return c.on_disk != nullptr; });
}

const Column* Table::find_column(const std::string& column_name) const {
  for (const Column& c : columns)
    if (c.name == column_name) return &c;
  return nullptr;
}

const Column& Table::column(const std::string& column_name) const {
  if (const Column* c = find_column(column_name)) return *c;
  throw std::out_of_range("table " + name + " has no column " + column_name);
}

std::string Table::word(const std::string& column_name, std::size_t row) const {
  const Column* c = find_column(column_name);
  const auto* words = c ? std::get_if<std::vector<std::string>>(&c->values) : nullptr;
  return words ? (*words)[row] : "";
}

double Table::number(const std::string& column_name, std::size_t row) const {
  const Column* c = find_column(column_name);
  if (!c) return kNaN;
  if (const auto* numbers = std::get_if<std::vector<double>>(&c->values)) return (*numbers)[row];
  if (const auto* counts = std::get_if<std::vector<std::int64_t>>(&c->values))
    return static_cast<double>((*counts)[row]);
  return kNaN;
}

std::size_t map_size(const Map& map) {
  std::size_t n = 1;
  for (const Axis& a : map.axes) n *= std::visit([](const auto& v) { return v.size(); }, a.values);
  return n;
}

Values values_of(const Column& c, std::size_t first, std::size_t count) {
  const std::size_t before = c.on_disk ? c.on_disk->size() : 0;
  const std::size_t from_disk = first < before ? std::min(count, before - first) : 0;
  Values own;
  if (from_disk > 0) own = c.on_disk->read(first, from_disk);
  std::visit(
      [&](const auto& held) {
        using List = std::decay_t<decltype(held)>;
        if (from_disk == 0) own = List{};
        const auto begin = held.begin() + static_cast<std::ptrdiff_t>(first + from_disk - before);
        auto& values = std::get<List>(own);
        if (from_disk < count)
          values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(count - from_disk));
      },
      c.values);
  return own;
}

Table rows_of(const Table& table, std::size_t first, std::size_t count) {
  Table part{table.name, table.long_name};
  for (const Column& c : table.columns)
    part.columns.push_back({c.name, c.unit, c.long_name, values_of(c, first, count), c.ancillary});
  return part;
}

void for_each_piece(const Table& table, const std::function<void(const Table& piece, std::size_t first)>& visit) {
  if (table.is_held()) return visit(table, 0);
  const std::size_t rows = table.rows();
  for (std::size_t at = 0; at < rows; at += kPieceRows) visit(rows_of(table, at, std::min(kPieceRows, rows - at)), at);
}

void append_rows(Table& table, Table more) {
  if (table.columns.empty()) {
    table = std::move(more);
    return;
  }
  const auto append = [&table](Table& held) {
    assert(table.columns.size() == held.columns.size());
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      assert(table.columns[i].name == held.columns[i].name);
      std::visit(
          [&](auto& values) {
            auto& added = std::get<std::decay_t<decltype(values)>>(held.columns[i].values);
            values.insert(values.end(), std::make_move_iterator(added.begin()), std::make_move_iterator(added.end()));
          },
          table.columns[i].values);
    }
    hold_less(table);
  };
  if (more.is_held()) return append(more);
  for_each_piece(more, [&](const Table& piece, std::size_t) {
    Table own = piece;
    append(own);
  });
}

}  // namespace surveymc::store
