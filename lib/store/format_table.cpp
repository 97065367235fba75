#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "store/table.h"

namespace surveymc::store {
namespace {

constexpr std::size_t kSentence = 20;  // a wider text is a note, not a word
constexpr const char* kGap = "  ";
constexpr const char* kUnexpectedMark = " (!)";

bool is_text(const Column& column) { return std::holds_alternative<std::vector<std::string>>(column.values); }

/// Code points, which is what a terminal shows for the letters and symbols we use (Greek, degree, plus-minus).
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, bool right_aligned) {
  const std::string fill(to - std::min(to, width(text)), ' ');
  return right_aligned ? fill + text : text + fill;
}

std::string format_double(double x, int digits) {
  if (std::isnan(x)) return "-";
  if (x == 0) return "0";  // also -0
  return fmt::format("{:.{}g}", x, digits);
}

/// Number of a numeric column as double, for intervals.
double number_at(const Column& column, std::size_t row) {
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    return static_cast<double>((*integers)[row]);
  }
  return std::get<std::vector<double>>(column.values)[row];
}

std::string cell(const Column& column, std::size_t row) {
  if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values)) return printable((*texts)[row]);
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    return fmt::format("{}", (*integers)[row]);
  }
  return format_double(std::get<std::vector<double>>(column.values)[row], 6);
}

/// "low .. high" with as many digits as show the interval's width to three figures: a narrow interval around a large
/// value must not print as twice the same number, and a wide one needs no six digits.
std::string interval_cell(double low, double high) {
  if (std::isnan(low) && std::isnan(high)) return "-";
  int digits = 4;
  const double largest = std::max(std::abs(low), std::abs(high));
  if (std::isfinite(largest) && high > low) {
    digits = std::clamp(static_cast<int>(std::ceil(std::log10(largest / (high - low)))) + 2, 4, 12);
  }
  return format_double(low, digits) + " .. " + format_double(high, digits);
}

bool is_blank(const Column& column) {
  return std::visit(
      [](const auto& values) {
        return std::all_of(values.begin(), values.end(), [](const auto& v) {
          using T = std::decay_t<decltype(v)>;
          if constexpr (std::is_same_v<T, double>) return std::isnan(v);
          if constexpr (std::is_same_v<T, std::string>) return v.empty();
          return false;
        });
      },
      column.values);
}

/// One printed column: one or two lines of name, unit, cells.
struct Block {
  std::string name, unit;
  bool right_aligned = true;
  std::vector<std::string> cells;
  std::array<std::string, 2> name_lines = {"", name};
  std::string same_count = {};  ///< "trials 20000" if that is what all rows count

  std::size_t cell_width() const {
    std::size_t w = width(unit);
    for (const std::string& c : cells) w = std::max(w, width(c));
    return w;
  }
  std::size_t full_width() const { return std::max({cell_width(), width(name_lines[0]), width(name_lines[1])}); }
};

/// A name in two lines, broken after an underscore or blank near its middle, if that makes the column narrower.
void break_name(Block& block) {
  if (width(block.name) <= block.cell_width()) return;
  for (std::size_t at = 0; at + 1 < block.name.size(); ++at) {
    if (block.name[at] != '_' && block.name[at] != ' ') continue;
    const std::array<std::string, 2> broken = {block.name.substr(0, at + 1), block.name.substr(at + 1)};
    const auto widest = [](const std::array<std::string, 2>& l) { return std::max(width(l[0]), width(l[1])); };
    if (widest(broken) < widest(block.name_lines)) block.name_lines = broken;
  }
}

std::size_t table_width(const std::vector<Block>& blocks) {
  std::size_t total = 0;
  for (const Block& b : blocks) total += b.full_width() + (total > 0 ? width(kGap) : 0);
  return total;
}

/// The interval columns of a column, or two nulls.
struct Ends {
  const Column* low = nullptr;
  const Column* high = nullptr;
};

/// Columns as they are printed: blank ones left out, interval ends joined behind their value.
std::vector<Block> printed_blocks(const Table& table) {
  const auto find = [&](const std::string& name) -> const Column* {
    for (const Column& c : table.columns) {
      if (c.name == name && !is_text(c)) return &c;
    }
    return nullptr;
  };
  const auto ends_of = [&](const std::string& name) {
    const Ends ends{find(name + "_ci_low"), find(name + "_ci_high")};
    return find(name) && ends.low && ends.high ? ends : Ends{};
  };
  const auto is_end = [&](const std::string& name) {
    for (const std::string suffix : {"_ci_low", "_ci_high"}) {
      if (name.ends_with(suffix) && ends_of(name.substr(0, name.size() - suffix.size())).low) return true;
    }
    return false;
  };

  const std::size_t rows = table.rows();
  std::vector<Block> blocks;
  for (const Column& column : table.columns) {
    if (!is_text(column) && is_end(column.name)) continue;
    const Ends ends = is_text(column) ? Ends{} : ends_of(column.name);
    const bool interval = ends.low && (rows == 0 || !is_blank(*ends.low) || !is_blank(*ends.high));
    if (rows > 0 && is_blank(column) && !interval) continue;

    Block block{printable(column.name), "", !is_text(column), {}};
    if (!column.unit.empty() && column.unit != "1") block.unit = "[" + printable(column.unit) + "]";
    for (std::size_t i = 0; i < rows; ++i) block.cells.push_back(cell(column, i));
    if (const auto* counts = std::get_if<std::vector<std::int64_t>>(&column.values);
        counts && rows > 1 && std::count(counts->begin(), counts->end(), counts->front()) == std::ssize(*counts))
      block.same_count = fmt::format("{} {}", block.name, block.cells.front());
    blocks.push_back(block);
    if (!interval) continue;
    Block joined{"interval", block.unit, true, {}};
    for (std::size_t i = 0; i < rows; ++i) {
      joined.cells.push_back(interval_cell(number_at(*ends.low, i), number_at(*ends.high, i)));
    }
    blocks.push_back(joined);
  }
  return blocks;
}

/// Replaces the texts of a column by numbers, equal texts by one number, and returns the numbered texts.
std::vector<std::string> to_footnotes(Block& block) {
  std::vector<std::string> notes;
  for (std::string& c : block.cells) {
    if (c.empty()) continue;
    const auto known = std::find(notes.begin(), notes.end(), c);
    const auto number = known - notes.begin() + 1;
    if (known == notes.end()) notes.push_back(c);
    c = fmt::format("({})", number);
  }
  return notes;
}

/// Marks the verdicts that are not the expected ones; how many there are.
std::size_t mark_unexpected(const Table& table, std::vector<Block>& blocks) {
  const auto texts_of = [&](const char* name) -> const std::vector<std::string>* {
    for (const Column& c : table.columns) {
      if (c.name == name && is_text(c)) return &std::get<std::vector<std::string>>(c.values);
    }
    return nullptr;
  };
  const auto *verdict = texts_of("verdict"), *expected = texts_of("expected");
  const auto block = std::find_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.name == "verdict"; });
  if (!verdict || !expected || block == blocks.end()) return 0;
  std::size_t marked = 0;
  for (std::size_t i = 0; i < verdict->size(); ++i) {
    if ((*expected)[i].empty() || (*expected)[i] == (*verdict)[i]) continue;
    block->cells[i] = ((*verdict)[i].empty() ? "none" : printable((*verdict)[i])) + kUnexpectedMark;
    ++marked;
  }
  return marked;
}

using Blocks = std::vector<const Block*>;

std::string line(const Blocks& blocks, const auto& text_of) {
  std::string out;
  for (const Block* b : blocks) {
    if (b != blocks.front()) out += kGap;
    out += padded(text_of(*b), b->full_width(), b->right_aligned);
  }
  out.erase(out.find_last_not_of(' ') + 1);
  return out + '\n';
}

std::size_t lines_width(const Blocks& blocks) {
  std::size_t total = 0;
  for (const Block* b : blocks) total += b->full_width() + (total > 0 ? width(kGap) : 0);
  return total;
}

/// How many leading columns name a row: those up to `quantity`, or the texts in front and
/// the station, or the first.
std::size_t naming_columns(const std::vector<Block>& blocks) {
  const auto quantity = std::find_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.name == "quantity"; });
  if (quantity != blocks.end()) return static_cast<std::size_t>(quantity - blocks.begin()) + 1;
  const auto number = std::find_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.right_aligned; });
  std::size_t count = std::max<std::size_t>(1, static_cast<std::size_t>(number - blocks.begin()));
  while (count < blocks.size() && (blocks[count].name == "station" || blocks[count].name == "md_m")) ++count;
  return count;
}

/// The columns in parts of at most `widest` letters, if possible; every part begins with the columns that name a row.
std::vector<Blocks> parts_of(const std::vector<Block>& blocks, std::size_t widest) {
  Blocks names;
  for (std::size_t i = 0; i < std::min(naming_columns(blocks), blocks.size()); ++i) names.push_back(&blocks[i]);
  if (lines_width(names) > widest / 2) names.resize(1);
  std::vector<Blocks> parts{names};
  for (std::size_t i = names.size(); i < blocks.size(); ++i) {
    Blocks longer = parts.back();
    longer.push_back(&blocks[i]);
    if (lines_width(longer) > widest && parts.back().size() > names.size()) {
      parts.push_back(names);
      parts.back().push_back(&blocks[i]);
    } else {
      parts.back() = std::move(longer);
    }
  }
  return parts;
}

/// Heading and rows of some columns.
std::string lines_of(const Blocks& blocks, std::size_t rows, std::size_t most_rows) {
  std::string out;
  const auto any = [&](const auto& has) { return std::any_of(blocks.begin(), blocks.end(), has); };
  if (any([](const Block* b) { return !b->name_lines[0].empty(); })) {
    out += line(blocks, [](const Block& b) { return b.name_lines[0]; });
  }
  out += line(blocks, [](const Block& b) { return b.name_lines[1]; });
  if (any([](const Block* b) { return !b->unit.empty(); })) {
    out += line(blocks, [](const Block& b) { return b.unit; });
  }
  out += std::string(lines_width(blocks), '-') + '\n';
  const std::size_t left_out = rows > most_rows ? rows - most_rows : 0, first = (most_rows + 1) / 2;
  for (std::size_t i = 0; i < rows; ++i) {
    if (left_out > 0 && i == first) {
      out += fmt::format("... {} of {} rows left out ...\n", left_out, rows);
      i += left_out - 1;
      continue;
    }
    out += line(blocks, [i](const Block& b) { return b.cells[i]; });
  }
  if (rows == 0) out += "(no rows)\n";
  return out;
}

}  // namespace

std::string format_table(const Table& table, const TableFormat& format) {
  const std::size_t rows = table.rows();
  std::string out = printable(table.name);
  if (!table.long_name.empty()) out += ": " + printable(table.long_name);
  out += '\n';

  std::vector<Block> blocks = printed_blocks(table);
  if (blocks.empty()) return out + (rows > 0 ? fmt::format("({} rows without values)\n", rows) : "(no rows)\n");
  const std::size_t unexpected = mark_unexpected(table, blocks);
  std::vector<std::string> notes;
  const auto too_wide = [&] { return table_width(blocks) > format.width; };
  if (too_wide()) {  // counts that are the same in all rows need no column
    std::string counts;
    std::erase_if(blocks, [&](const Block& b) {
      if (b.same_count.empty()) return false;
      counts += (counts.empty() ? "(" : ", ") + b.same_count;
      return true;
    });
    if (!counts.empty()) out += counts + ")\n";
  }
  if (too_wide()) std::for_each(blocks.begin(), blocks.end(), break_name);
  const auto text = std::find_if(blocks.rbegin(), blocks.rend(),
                                 [](const Block& b) { return !b.right_aligned && b.cell_width() > kSentence; });
  if (too_wide() && text != blocks.rend()) notes = to_footnotes(*text);

  const std::vector<Blocks> parts = parts_of(blocks, format.split ? format.width : std::string::npos);
  for (std::size_t i = 0; i < parts.size(); ++i)
    out += (i > 0 ? "\n" : "") + lines_of(parts[i], rows, format.most_rows);
  if (unexpected > 0) out += fmt::format("(!) {} not the expected verdict\n", unexpected);
  for (std::size_t i = 0; i < notes.size(); ++i) out += fmt::format("({}) {}\n", i + 1, notes[i]);
  return out;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    longest = std::max(longest, end - begin);
    begin = end + 1;
  }
  return longest;
}

}  // namespace surveymc::store
