#include "store/table.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "base/units.h"
#include "store/row_spool.h"
#include "store/stored_form.h"

namespace surveymc::store {
namespace {

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_cell(const Column& column, std::size_t row) {
  if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values)) return csv_text((*texts)[row]);
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    return fmt::format("{}", (*integers)[row]);
  }
  const double x = std::get<std::vector<double>>(column.values)[row];
  if (std::isnan(x)) return "";
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x).ptr;
  return std::string(buffer.data(), end);
}

}  // namespace

/// Notes and names come from config files: a line break would break the row, an escape sequence the terminal, and a
/// mark that turns the direction of writing would show another text than the one that is there.
std::string printable(std::string text) {
  if (std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; })) return text;
  text = canonical_text(text);  // a byte that is no UTF-8 may be an escape sequence, too
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = control_length(text, at);
    if (length == 0)
      out += text[at];
    else
      out += ' ';
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

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

Table first_and_last(const Table& table, std::size_t count) {
  const std::size_t rows = table.rows(), last = std::min(count, rows) / 2, first = std::min(count, rows) - last;
  Table shown = rows_of(table, 0, first);
  append_rows(shown, rows_of(table, rows - last, last));
  return shown;
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

void to_csv(const Table& table, const std::function<void(const std::string& lines)>& write) {
  if (table.columns.empty()) return;
  const auto add_line = [](const Table& t, std::string& out, const auto& text_of) {
    std::string csv_line;
    for (const Column& c : t.columns) {
      if (&c != &t.columns.front()) csv_line += ',';
      csv_line += text_of(c);
    }
    if (csv_line.empty()) csv_line = "\"\"";  // one column, no value: readers skip an empty line
    out += csv_line + '\n';
  };
  std::string out;
  add_line(table, out, [](const Column& c) { return csv_text(c.name); });
  for_each_piece(table, [&](const Table& piece, std::size_t) {
    for (std::size_t i = 0; i < piece.rows(); ++i) {
      add_line(piece, out, [i](const Column& c) { return csv_cell(c, i); });
      constexpr std::size_t kLongText = std::size_t{1} << 20;
      if (out.size() > kLongText) write(std::exchange(out, {}));
    }
  });
  write(out);
}

std::string to_csv(const Table& table) {
  std::string all;
  to_csv(table, [&](const std::string& lines) { all += lines; });
  return all;
}

}  // namespace surveymc::store
