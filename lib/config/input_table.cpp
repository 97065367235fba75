#include "config/input_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "config/csv_cells.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

/// "file:line" of messages: a text of every line would take longer than its numbers.
struct LinePlace {
  const std::string& path;
  int number;
};

}  // namespace
}  // namespace surveymc::config

template <>
struct fmt::formatter<surveymc::config::LinePlace> : fmt::formatter<std::string> {
  auto format(const surveymc::config::LinePlace& p, fmt::format_context& out) const {
    return fmt::format_to(out.out(), "{}:{}", p.path, p.number);
  }
};

namespace surveymc::config {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// First byte that cannot be in a line of text (a control character, or not UTF-8), or npos. Nothing of a comment is
/// kept: its letters may be of any encoding.
std::size_t first_bad_byte(std::string_view s) {
  const bool any_letters = is_no_row(s);
  for (std::size_t i = 0; i < s.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(i + k < s.size() ? s[i + k] : '\0'); };
    const unsigned char c = byte(0);
    if (c < 0x80) {
      if (c == 0x7F || (c < 0x20 && c != '\t')) return i;
      ++i;
      continue;
    }
    if (any_letters) {
      ++i;
      continue;
    }
    const std::size_t n = c >= 0xF0 ? 4 : c >= 0xE0 ? 3 : 2;
    std::uint32_t code = c & (0xFFU >> (n + 1));
    for (std::size_t k = 1; k < n; ++k) {
      if ((byte(k) & 0xC0) != 0x80) return i;
      code = (code << 6) | (byte(k) & 0x3FU);
    }
    constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
    if (c < 0xC0 || c > 0xF4 || code < kSmallest[n] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return i;
    i += n;
  }
  return std::string_view::npos;
}

enum class Reading { number, infinite, out_of_range, other };

/// Independent of the locale; a leading + is allowed, hexadecimal and trailing text are not.
Reading read_number(std::string_view cell, double& x) {
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-' && cell[1] != '+') cell.remove_prefix(1);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (error == std::errc::invalid_argument || end != cell.data() + cell.size()) return Reading::other;
  if (error == std::errc::result_out_of_range) return Reading::out_of_range;
  return std::isfinite(x) ? Reading::number : Reading::infinite;
}

bool has_decimal_comma(std::string_view cell) {
  const auto comma = cell.find(',');
  return comma != std::string_view::npos && comma > 0 && is_digit(cell[comma - 1]) && comma + 1 < cell.size() &&
         is_digit(cell[comma + 1]);
}

std::vector<std::string> checked_header(std::vector<std::string> names, const LinePlace& place) {
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto& name = names[j];
    require(!name.empty(), "{}: column {} has no name", place, j + 1);
    require(!has_other_separator(name), "{}: \"{}\": {}", place, shortened(name), kDecimalHint);
    double ignored = 0;
    require(read_number(name, ignored) == Reading::other,
            "{}: column {} = \"{}\": the first line must name the columns", place, j + 1, shortened(name));
    const auto end = names.begin() + static_cast<std::ptrdiff_t>(j);
    require(std::find(names.begin(), end, name) == end, "{}: {}: two columns have this name", place, shortened(name));
  }
  return names;
}

/// The next line, whose end may be LF, CRLF or CR.
std::string_view next_line(std::string_view& rest) {
  const auto ends_line = [](char c) { return c == '\n' || c == '\r'; };  // find_first_of() calls a function a byte
  const auto end = static_cast<std::size_t>(std::find_if(rest.begin(), rest.end(), ends_line) - rest.begin());
  const std::string_view line = rest.substr(0, end);
  const std::size_t mark = rest.substr(end, 2) == "\r\n" ? 2 : 1;
  rest.remove_prefix(std::min(end + mark, rest.size()));
  return line;
}

double checked_cell(std::string_view cell, const std::string& name, const LinePlace& place) {
  require(!cell.empty(), "{}: {}: is empty", place, name);
  double x = 0;
  std::string rule;
  switch (read_number(cell, x)) {
    case Reading::number:
      return x;
    case Reading::infinite:
      rule = "must be a finite number";
      break;
    case Reading::out_of_range:
      rule = "is out of the range of floating-point numbers";
      break;
    case Reading::other:
      rule = "must be a number";
      if (has_decimal_comma(cell) || has_other_separator(cell)) rule += fmt::format(": {}", kDecimalHint);
  }
  throw InputError(fmt::format("{}: {} = \"{}\": {}", place, name, shortened(cell), rule));
}

/// As split_cells(), of a line without quotes: the cells are parts of it.
void split_plain(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const std::size_t end = std::min(line.find(','), line.size());
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == line.size()) return;
    line.remove_prefix(end + 1);
  }
}

}  // namespace

// Boost's escaped_list_separator would read `1"2` and `"1""2"` as 12.
std::vector<std::string> split_cells(std::string_view line, const std::string& place) {
  std::vector<std::string> cells;
  std::size_t i = 0;
  for (;;) {
    while (i < line.size() && (line[i] == ' ' || line[i] == '\t')) ++i;
    if (i < line.size() && line[i] == '"') {
      std::string cell;
      bool closed = false;
      for (++i; i < line.size() && !closed; ++i) {
        if (line[i] != '"') {
          cell += line[i];
        } else if (i + 1 < line.size() && line[i + 1] == '"') {
          cell += line[i++];
        } else {
          closed = true;
        }
      }
      require(closed, "{}: a quote is not closed on its line", place);
      while (i < line.size() && (line[i] == ' ' || line[i] == '\t')) ++i;
      require(i == line.size() || line[i] == ',', "{}: text after a closing quote", place);
      cells.emplace_back(trimmed(cell));
    } else {
      const std::size_t end = std::min(line.find(',', i), line.size());
      const auto cell = trimmed(line.substr(i, end - i));
      require(cell.find('"') == std::string_view::npos, "{}: {}: a quote inside a cell", place, shortened(cell));
      cells.emplace_back(cell);
      i = end;
    }
    if (i == line.size()) return cells;
    ++i;  // the comma
  }
}

bool is_no_row(std::string_view line) {
  const std::string_view t = trimmed(line);
  if (t.empty() || t.front() != '#') return t.empty();
  std::string_view word = t.substr(1, t.find_first_of(",;\t") - 1);
  while (word.ends_with(' ')) word.remove_suffix(1);
  if (word == "N/A" || word == "NV") return false;
  const bool is_error = word.size() > 1 && (word.back() == '!' || word.back() == '?') &&
                        word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ/0") == word.size() - 1;
  return !is_error;
}

int InputTable::find(const std::string& name) const {
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

InputTable parse_csv(const std::string& text, const std::string& path,
                     const std::function<void(const InputTable&)>& check_names) {
  std::string_view rest = text;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  InputTable table;
  table.path = path;
  std::vector<std::string_view> cells;
  std::vector<std::string> unquoted;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = next_line(rest);
    const LinePlace place{path, number};
    if (const auto bad = first_bad_byte(line); bad != std::string_view::npos)
      throw InputError(fmt::format("{}: is not plain UTF-8 text (byte 0x{:02x}): save the file as CSV in UTF-8", place,
                                   static_cast<unsigned>(static_cast<unsigned char>(line[bad]))));
    if (is_no_row(line)) continue;

    if (line.find('"') == std::string_view::npos) {
      split_plain(line, cells);
    } else {
      unquoted = split_cells(line, fmt::format("{}", place));
      cells.assign(unquoted.begin(), unquoted.end());
    }
    if (is_empty_row(cells)) continue;
    if (table.names.empty()) {
      remove_empty_end(cells, 0);
      table.names = checked_header({cells.begin(), cells.end()}, place);
      table.columns.resize(table.names.size());
      table.names_line = number;
      if (check_names) check_names(table);
      continue;
    }
    const std::size_t width = table.names.size();
    remove_empty_end(cells, width);
    // A row with decimal commas, or with another separator, shows first as a wrong number of cells.
    const bool commas = cells.size() == 2 * width || (cells.size() != width && has_other_separator(line));
    require(cells.size() == width, "{}: {} cell{}: must have {} as the header{}", place, cells.size(),
            cells.size() == 1 ? "" : "s", width, commas ? fmt::format(" ({})", kDecimalHint) : "");
    for (std::size_t j = 0; j < width; ++j) table.columns[j].push_back(checked_cell(cells[j], table.names[j], place));
    table.lines.push_back(number);
  }
  require(!table.names.empty(), "{}: is empty: must have a line of column names, then rows", path);
  require(!table.lines.empty(), "{}: has no rows below the column names", path);
  return table;
}

}  // namespace surveymc::config
