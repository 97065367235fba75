#include "store/table.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

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

/// Notes and names come from config files: a line break would break the row, an escape sequence the terminal.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return text;
}

std::size_t Column::size() const {
  return std::visit([](const auto& v) { return v.size(); }, values);
}

std::size_t Table::rows() const { return columns.empty() ? 0 : columns.front().size(); }

const Column& Table::column(const std::string& column_name) const {
  for (const Column& c : columns) {
    if (c.name == column_name) return c;
  }
  throw std::out_of_range("table " + name + " has no column " + column_name);
}

std::size_t map_size(const Map& map) {
  std::size_t n = 1;
  for (const Axis& a : map.axes) n *= std::visit([](const auto& v) { return v.size(); }, a.values);
  return n;
}

void append_rows(Table& table, const Table& more) {
  assert(table.columns.size() == more.columns.size());
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    assert(table.columns[i].name == more.columns[i].name);
    std::visit(
        [&](auto& values) {
          const auto added = std::get<std::decay_t<decltype(values)>>(more.columns[i].values);  // a copy: may be itself
          values.insert(values.end(), added.begin(), added.end());
        },
        table.columns[i].values);
  }
}

std::string to_csv(const Table& table) {
  if (table.columns.empty()) return "";
  const auto add_line = [&](std::string& out, const auto& text_of) {
    std::string csv_line;
    for (const Column& c : table.columns) {
      if (&c != &table.columns.front()) csv_line += ',';
      csv_line += text_of(c);
    }
    if (csv_line.empty()) csv_line = "\"\"";  // one column, no value: readers skip an empty line
    out += csv_line + '\n';
  };
  std::string out;
  add_line(out, [](const Column& c) { return csv_text(c.name); });
  for (std::size_t i = 0; i < table.rows(); ++i) {
    add_line(out, [i](const Column& c) { return csv_cell(c, i); });
  }
  return out;
}

}  // namespace surveymc::store
