#include "render/csv.h"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace surveymc::render {
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

std::string csv_cell(const store::Column& column, std::size_t row) {
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

std::string to_csv(const store::Table& table) {
  if (table.columns.empty()) return "";
  std::string out;
  const auto add_line = [&](const store::Table& t, const auto& text_of) {
    std::string line;
    for (const store::Column& c : t.columns) {
      if (&c != &t.columns.front()) line += ',';
      line += text_of(c);
    }
    if (line.empty()) line = "\"\"";  // one column, no value: readers skip an empty line
    out += line + '\n';
  };
  add_line(table, [](const store::Column& c) { return csv_text(c.name); });
  store::for_each_piece(table, [&](const store::Table& piece, std::size_t) {
    for (std::size_t i = 0; i < piece.rows(); ++i)
      add_line(piece, [i](const store::Column& c) { return csv_cell(c, i); });
  });
  return out;
}

}  // namespace surveymc::render
