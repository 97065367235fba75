#include "render/table_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <unordered_map>

#include <fmt/format.h>

#include "render/text.h"

namespace surveymc::render {

using store::Column;
using store::Table;

namespace {

constexpr std::size_t kSentence = 20;  // a wider text is a note, not a word
constexpr const char* kGap = "  ";
constexpr const char* kUnexpectedMark = " (!)";

bool is_text(const Column& column) { return std::holds_alternative<std::vector<std::string>>(column.values); }

std::string padded(const std::string& text, std::size_t to, bool right_aligned) {
  const std::string fill(to - std::min(to, width(text)), ' ');
  return right_aligned ? fill + text : text + fill;
}

std::string format_double(double x, int digits) {
  if (std::isnan(x)) return "-";
  if (x == 0) return "0";  // also -0
  return fmt::format("{:.{}g}", x, digits);
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

std::string unit_text(const Column& column) {
  return column.unit.empty() || column.unit == "1" ? "" : "[" + printable(column.unit) + "]";
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

bool is_same_in_all_rows(const Column& column) {
  return std::visit(
      [](const auto& values) {
        return std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
      },
      column.values);
}

/// Columns that say in numbers what `verdict` and `note` say: for files, not for eyes.
bool is_for_files(const Column& column) {
  return column.name == "p_differs" || column.name == "p_agrees" || column.name == "trials_to_decide";
}

/// The rows of a table that are printed: all but gap_begin .. gap_end - 1.
struct Shown {
  std::size_t rows, gap_begin, gap_end;  ///< rows: of the table

  std::size_t count() const { return rows - (gap_end - gap_begin); }
  std::size_t row(std::size_t i) const { return i < gap_begin ? i : i + (gap_end - gap_begin); }  ///< of cell i
};

Shown shown_rows(std::size_t rows, const TableFormat& format) {
  const std::size_t shown = std::min(rows, format.most_rows), begin = (shown + 1) / 2;
  return {rows, begin, begin + (rows - shown)};
}

/// One printed column: one or two lines of name, unit, cells of the rows that are shown.
class Block {
 public:
  Block(std::string name_, std::string unit_, bool is_right_aligned)
      : name(std::move(name_)), unit(std::move(unit_)), right_aligned(is_right_aligned), cell_width_(width(unit)) {}

  std::string name, unit;
  bool right_aligned;
  std::array<std::string, 2> name_lines = {"", name};
  std::string same_count = {};  ///< "trials 20000" if that is what all rows count
  bool is_key = false;          ///< of the sweep

  const std::vector<std::string>& cells() const { return cells_; }
  void add_cell(std::string text) {
    cell_width_ = std::max(cell_width_, width(text));
    cells_.push_back(std::move(text));
  }
  void replace_cells(std::vector<std::string> cells) {
    cells_.clear();
    cell_width_ = width(unit);
    for (std::string& c : cells) add_cell(std::move(c));
  }

  /// Widths are asked for in every line: they are kept, not counted again.
  std::size_t cell_width() const { return cell_width_; }
  std::size_t full_width() const { return std::max({cell_width_, width(name_lines[0]), width(name_lines[1])}); }

 private:
  std::vector<std::string> cells_;
  std::size_t cell_width_;
};

/// A name in two lines, broken after an underscore or blank near its middle, if that makes the column narrower.
void break_name(Block& block) {
  if (width(block.name) <= block.cell_width()) return;
  for (std::size_t at = 0; at + 1 < block.name.size(); ++at) {
    constexpr std::size_t kShortest = 3;  // "_m" does not stand alone
    if ((block.name[at] != '_' && block.name[at] != ' ') || block.name.size() - at - 1 < kShortest) continue;
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
std::vector<Block> printed_blocks(const Table& table, const Shown& shown) {
  const auto find = [&](const std::string& name) -> const Column* {
    const Column* c = table.find_column(name);
    return c && !is_text(*c) ? c : nullptr;
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
    if (!is_text(column) && (is_end(column.name) || is_for_files(column))) continue;
    const Ends ends = is_text(column) ? Ends{} : ends_of(column.name);
    const bool interval = ends.low && (rows == 0 || !is_blank(*ends.low) || !is_blank(*ends.high));
    if (rows > 0 && is_blank(column) && !interval) continue;

    Block block(printable(column.name), unit_text(column), !is_text(column));
    for (std::size_t i = 0; i < shown.count(); ++i) block.add_cell(cell(column, shown.row(i)));
    const bool counts = std::holds_alternative<std::vector<std::int64_t>>(column.values) || block.name == "margin";
    if (counts && rows > 1 && is_same_in_all_rows(column))
      block.same_count = fmt::format("{} {}", block.name, cell(column, 0));
    block.is_key = column.long_name == store::kSweepKey;
    blocks.push_back(std::move(block));
    if (!interval) continue;
    Block joined("interval", unit_text(column), true);
    for (std::size_t i = 0; i < shown.count(); ++i) {
      const std::size_t row = shown.row(i);
      joined.add_cell(interval_cell(table.number(ends.low->name, row), table.number(ends.high->name, row)));
    }
    blocks.push_back(std::move(joined));
  }
  return blocks;
}

/// Sentences below the table, each once.
class Footnotes {
 public:
  /// Replaces the texts of a column by the numbers of its notes.
  void take(Block& block) {
    std::vector<std::string> numbers;
    for (const std::string& c : block.cells()) numbers.push_back(c.empty() ? c : fmt::format("({})", number_of(c)));
    block.replace_cells(std::move(numbers));
  }
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::size_t number_of(const std::string& text) {
    const auto [at, is_new] = numbers_.try_emplace(text, texts_.size() + 1);
    if (is_new) texts_.push_back(text);
    return at->second;
  }

  std::vector<std::string> texts_;
  std::unordered_map<std::string, std::size_t> numbers_;
};

/// "none (!)" for a verdict that is not the expected one; else "".
std::string unexpected_mark(const Table& table, std::size_t row) {
  const std::string verdict = table.word("verdict", row), expected = table.word("expected", row);
  if (expected.empty() || expected == verdict || expected == store::kEither) return "";
  if (verdict == "differs" && table.word("family", row) == "may be chance") return "";  // as unexpected_verdicts()
  return (verdict.empty() ? "none" : printable(verdict)) + kUnexpectedMark;
}

/// Marks the verdicts that are not the expected ones; how many there are, in rows that are not shown, too.
std::size_t mark_unexpected(const Table& table, const Shown& shown, std::vector<Block>& blocks) {
  const auto block = std::find_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.name == "verdict"; });
  if (!table.find_column("verdict") || !table.find_column("expected") || block == blocks.end()) return 0;
  std::vector<std::string> cells = block->cells();
  std::size_t marked = 0;
  for (std::size_t row = 0; row < shown.rows; ++row) marked += !unexpected_mark(table, row).empty();
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (std::string mark = unexpected_mark(table, shown.row(i)); !mark.empty()) cells[i] = std::move(mark);
  block->replace_cells(std::move(cells));
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

/// How many leading columns name a row: those up to `quantity`; or the sweep's keys, the text behind them, further
/// texts that are no sentences, leg and station; or the first.
std::size_t naming_columns(const std::vector<Block>& blocks) {
  const auto quantity = std::find_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.name == "quantity"; });
  if (quantity != blocks.end()) return static_cast<std::size_t>(quantity - blocks.begin()) + 1;
  std::size_t count = 0;
  const auto skip = [&](const auto& names) {
    while (count < blocks.size() && names(blocks[count])) ++count;
  };
  const auto is_said_of_row = [](const Block& b) {
    return b.name == "verdict" || b.name == "expected" || b.name == "unit";
  };
  skip([](const Block& b) { return b.is_key; });
  const std::size_t first_text = count;
  skip([&](const Block& b) {
    const bool is_sentence = b.cell_width() > kSentence && &b != &blocks[first_text];
    return !b.right_aligned && !is_said_of_row(b) && !is_sentence;
  });
  skip([](const Block& b) { return b.name == "leg" || b.name == "station" || b.name == "md_m" || b.name == "md_ft"; });
  return std::max<std::size_t>(1, count);
}

/// Puts `verdict` and `expected` behind the first `names` columns.
void move_verdict(std::vector<Block>& blocks, std::size_t names) {
  for (const char* word : {"verdict", "expected"}) {
    const auto at = std::find_if(blocks.begin(), blocks.end(), [&](const Block& b) { return b.name == word; });
    const auto to = blocks.begin() + static_cast<std::ptrdiff_t>(std::min(names, blocks.size()));
    if (at == blocks.end() || at < to) continue;
    std::rotate(to, at, at + 1);
    ++names;
  }
}

/// Columns in parts of at most a screen's width. `above`: names of a row that are too wide for it; they stand in a line
/// of their own above the rows that have them.
struct Layout {
  Blocks above;
  std::vector<Blocks> parts;
};

/// The columns in parts of at most `widest` letters, if possible; every part begins with the first `names` columns.
Layout layout_of(const std::vector<Block>& blocks, std::size_t names_count, std::size_t widest) {
  Layout layout;
  Blocks names;
  for (std::size_t i = 0; i < std::min(names_count, blocks.size()); ++i) names.push_back(&blocks[i]);
  while (!names.empty() && blocks.size() > names_count && lines_width(names) > widest / 2) {
    layout.above.push_back(names.front());
    names.erase(names.begin());
  }
  std::vector<Blocks>& parts = layout.parts;
  parts = {names};
  for (std::size_t i = names_count; i < blocks.size(); ++i) {
    Blocks longer = parts.back();
    longer.push_back(&blocks[i]);
    if (lines_width(longer) > widest && parts.back().size() > names.size()) {
      parts.push_back(names);
      parts.back().push_back(&blocks[i]);
    } else {
      parts.back() = std::move(longer);
    }
  }
  return layout;
}

/// "case: test 4; leg: 1"
std::string group_line(const Blocks& above, std::size_t i, const TableFormat& format) {
  std::string out;
  for (const Block* b : above) out += fmt::format("{}{}: {}", out.empty() ? "" : "; ", b->name, b->cells()[i]);
  return (format.fold ? folded(out, format.width, 2) : out) + '\n';
}

/// Heading and rows of some columns.
std::string lines_of(const Blocks& blocks, const Blocks& above, const Shown& shown, const TableFormat& format) {
  std::string out, group;
  const auto any = [&](const auto& has) { return std::any_of(blocks.begin(), blocks.end(), has); };
  if (any([](const Block* b) { return !b->name_lines[0].empty(); })) {
    out += line(blocks, [](const Block& b) { return b.name_lines[0]; });
  }
  out += line(blocks, [](const Block& b) { return b.name_lines[1]; });
  if (any([](const Block* b) { return !b->unit.empty(); })) {
    out += line(blocks, [](const Block& b) { return b.unit; });
  }
  out += std::string(lines_width(blocks), '-') + '\n';
  const auto add_rows = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!above.empty()) {
        const std::string own = group_line(above, i, format);
        if (own != group) out += own;
        group = own;
      }
      out += line(blocks, [i](const Block& b) { return b.cells()[i]; });
    }
  };
  add_rows(0, shown.gap_begin);
  if (const std::size_t left_out = shown.rows - shown.count() + format.left_out; left_out > 0)
    out += fmt::format("... {} of {} rows left out ...\n", left_out, shown.rows + format.left_out);
  add_rows(shown.gap_begin, shown.count());
  if (shown.rows == 0) out += "(no rows)\n";
  return out;
}

}  // namespace

store::Table first_and_last(const Table& table, std::size_t count) {
  const std::size_t rows = table.rows(), last = std::min(count, rows) / 2, first = std::min(count, rows) - last;
  Table shown = rows_of(table, 0, first);
  append_rows(shown, rows_of(table, rows - last, last));
  return shown;
}

std::string format_table(const Table& table, const TableFormat& format) {
  const auto in_lines = [&](const std::string& text, std::size_t indent) {
    return (format.fold ? folded(text, format.width, indent) : text) + '\n';
  };
  const Shown shown = shown_rows(table.rows(), format);
  std::string out = printable(table.name);
  if (!table.long_name.empty()) out += ": " + printable(table.long_name);
  out = in_lines(out, 2);

  std::vector<Block> blocks = printed_blocks(table, shown);
  if (blocks.empty())
    return out + (shown.rows > 0 ? fmt::format("({} rows without values)\n", shown.rows) : "(no rows)\n");
  const std::size_t unexpected = mark_unexpected(table, shown, blocks);
  const auto too_wide = [&] { return table_width(blocks) > format.width; };
  if (too_wide()) {  // what is the same in all rows needs no column
    std::string counts;
    std::erase_if(blocks, [&](const Block& b) {
      if (b.same_count.empty()) return false;
      counts += (counts.empty() ? "(" : ", ") + b.same_count;
      return true;
    });
    if (!counts.empty()) out += in_lines(counts + ")", 1);
  }
  const std::size_t names = naming_columns(blocks);
  move_verdict(blocks, names);
  if (too_wide()) std::for_each(blocks.begin(), blocks.end(), break_name);
  Footnotes notes;
  for (std::size_t i = blocks.size(); i-- > names && too_wide();)
    if (Block& b = blocks[i]; !b.right_aligned && b.cell_width() > kSentence) notes.take(b);

  const Layout layout = layout_of(blocks, names, format.split ? format.width : std::string::npos);
  for (const Blocks& part : layout.parts)
    out += (&part == &layout.parts.front() ? "" : "\n") + lines_of(part, layout.above, shown, format);
  if (unexpected > 0) out += fmt::format("(!) {} not as expected\n", unexpected);
  for (std::size_t i = 0; i < notes.texts().size(); ++i)
    out += in_lines(fmt::format("({}) {}", i + 1, notes.texts()[i]), 4);
  return out;
}

}  // namespace surveymc::render
