#include "config/sweep_table.h"

#include <charconv>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "base/error.h"
#include "config/csv_cells.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

/// The text in front of the next line feed, without CR; `at` goes behind it.
std::string_view next_line(std::string_view text, std::size_t& at) {
  const std::size_t end = std::min(text.find('\n', at), text.size());
  std::string_view line = text.substr(at, end - at);
  at = end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

/// Nothing but commas and blanks: no point, as spreadsheets write below others.
bool holds_nothing(std::string_view line) {
  return is_no_row(line) || line.find_first_not_of(", \t") == std::string_view::npos;
}

TomlNode value_of(const std::string& cell) {
  if (cell == "true" || cell == "false") return node_of(cell == "true");
  const char *begin = cell.data(), *end = begin + cell.size();
  if (begin != end && *begin == '+') ++begin;
  std::int64_t whole = 0;
  if (const auto [at, error] = std::from_chars(begin, end, whole); error == std::errc() && at == end)
    return node_of(whole);
  double real = 0;
  if (const auto [at, error] = std::from_chars(begin, end, real); error == std::errc() && at == end)
    return node_of(real);
  return node_of(cell);
}

}  // namespace

SweepTable::SweepTable(InputFile file) : file_(std::move(file)) { scan(); }

std::string SweepTable::place(std::int64_t line) const { return fmt::format("{}:{}", file_.path, line); }

void SweepTable::scan() {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  std::ifstream disk;
  std::string piece;
  std::uint64_t begin = 0;  // of `piece` in the file
  if (!file_.text) {
    disk.open(file_.place, std::ios::binary);
    if (!disk) throw IoError(fmt::format("{}: cannot be read", file_.path));
  }
  std::string_view text = file_.text ? std::string_view(*file_.text) : std::string_view();
  std::int64_t number = 0;
  BytesHash whole, chunk;  // of a file on the disk, which may change before its chunks are read again
  const auto end_chunk = [&] {
    if (!chunks_.empty()) chunks_.back().hash = chunk.hex();
    chunk = {};
  };
  const auto take = [&](std::string_view line, std::uint64_t offset) {
    ++number;
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    if (names_.empty() && line.find('\r') != std::string_view::npos)
      throw InputError(fmt::format("{}: lines end with CR alone: save the file with LF or CR LF", place(number)));
    if (holds_nothing(line)) return;
    if (names_.empty()) {
      names_ = split_cells(line, place(number));
      remove_empty_end(names_, 0);
      std::set<std::string> seen;
      for (const std::string& name : names_) {
        require(!name.empty(), "{}: a column has no name", place(number));
        require(!has_other_separator(name), "{}: \"{}\": {}", place(number), name, kDecimalHint);
        require(seen.insert(name).second, "{}: {}: two columns have this name", place(number), name);
      }
      return;
    }
    if (rows_ % kChunk == 0) {
      end_chunk();
      chunks_.push_back({offset, number, ""});
    }
    ++rows_;
  };
  if (file_.text) {
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t offset = at;
      take(next_line(text, at), offset);
    }
  } else {
    for (bool more = true; more;) {
      std::string fresh(kPiece, '\0');
      disk.read(fresh.data(), static_cast<std::streamsize>(fresh.size()));
      fresh.resize(static_cast<std::size_t>(disk.gcount()));
      more = !fresh.empty();
      piece += fresh;
      std::size_t at = 0;
      while (at < piece.size() && (!more || piece.find('\n', at) != std::string::npos)) {
        const std::size_t offset = at;
        const std::string_view line = next_line(piece, at);
        take(line, begin + offset);
        const std::string_view bytes = std::string_view(piece).substr(offset, at - offset);
        whole.add(bytes);
        chunk.add(bytes);
      }
      const std::size_t used = std::min(at, piece.size());
      piece.erase(0, used);
      begin += used;
      if (disk.bad())  // a read that fails would else be the end of the table
        throw IoError(fmt::format("{}: cannot be read to its end", file_.path));
      if (piece.size() > 16 * kPiece) throw InputError(fmt::format("{}: the line is too long", place(number + 1)));
    }
  }
  if (!file_.text && whole.hex() != file_.hash) refuse_changed_file(file_);
  end_chunk();
  if (names_.empty()) throw InputError(fmt::format("{}: must have a line of column names: the keys", file_.path));
  if (rows_ == 0) throw InputError(fmt::format("{}: has no rows: each is a point", file_.path));
  chunks_.push_back({file_.text ? text.size() : begin, number + 1, ""});
}

const std::string& SweepTable::chunk_text(std::uint64_t chunk) const {
  if (held_ == chunk) return held_text_;
  const std::uint64_t from = chunks_[chunk].offset, size = chunks_[chunk + 1].offset - from;
  held_ = ~std::uint64_t{0};
  if (file_.text) {
    held_text_ = file_.text->substr(from, size);
  } else {
    held_text_.assign(size, '\0');
    std::ifstream disk(file_.place, std::ios::binary);
    disk.seekg(static_cast<std::streamoff>(from));
    disk.read(held_text_.data(), static_cast<std::streamsize>(size));
    if (!disk) throw IoError(fmt::format("{}: cannot be read any more, or has become shorter", file_.path));
    BytesHash hash;
    hash.add(held_text_);
    if (hash.hex() != chunks_[chunk].hash) refuse_changed_file(file_);
  }
  held_rows_.clear();
  std::int64_t number = chunks_[chunk].line;
  for (std::size_t at = 0; at < held_text_.size(); ++number) {
    const std::string_view line = next_line(held_text_, at);
    if (!holds_nothing(line)) held_rows_.push_back({line, number});
  }
  held_ = chunk;
  return held_text_;
}

std::vector<TomlNode> SweepTable::cells_of(const Line& line) const {
  const std::string at = place(line.number);
  std::vector<std::string> cells = split_cells(line.text, at);
  remove_empty_end(cells, names_.size());
  for (std::size_t c = 0; c < names_.size(); ++c)
    require(c < cells.size() && !cells[c].empty(), "{}: {}: the cell is missing", at, names_[c]);
  require(cells.size() <= names_.size(), "{}: has {} cells, but there are {} columns", at, cells.size(), names_.size());
  std::vector<TomlNode> out;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    out.push_back(value_of(cells[c]));
    out.back().place = at;
    require(out.back().kind != TomlNode::Kind::real || std::isfinite(out.back().real),
            "{}: {} = {}: must be a finite number", at, names_[c], cells[c]);
  }
  return out;
}

std::vector<TomlNode> SweepTable::row(std::uint64_t i) const {
  const std::scoped_lock lock(reading_);
  chunk_text(i / kChunk);
  return cells_of(held_rows_.at(i % kChunk));
}

void SweepTable::check(const std::function<void()>& between) const {
  for (std::uint64_t i = 0; i < rows_; ++i) {
    if (i % kChunk == 0) between();
    row(i);
  }
}

}  // namespace surveymc::config
