#pragma once
/// The points of a sweep as rows of a CSV file: design = { kind = "table", file = "points.csv" }. The file is scanned
/// once; a row is read when it is asked for. Internal to the module.
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/input_file.h"
#include "config/toml_tree.h"

namespace surveymc::config {

class SweepTable {
 public:
  /// Reads the header and finds the rows. Throws InputError "file:line: rule", IoError if the file cannot be read.
  explicit SweepTable(InputFile file);

  const std::string& path() const { return file_.path; }
  /// Names of the columns as written.
  const std::vector<std::string>& names() const { return names_; }
  std::uint64_t rows() const { return rows_; }
  /// A cell is an integer, a number, true or false, else text. Every value has the place of its row. Throws InputError
  /// for a row with missing or additional cells.
  std::vector<TomlNode> row(std::uint64_t i) const;
  /// Reads every row as row() does; calls `between` now and then.
  void check(const std::function<void()>& between) const;

 private:
  static constexpr std::uint64_t kChunk = 1024;  // rows of which the place in the file is kept
  struct Line {
    std::string_view text;
    std::int64_t number = 0;
  };
  struct Chunk {
    std::uint64_t offset = 0;
    std::int64_t line = 0;  ///< number of the chunk's first line
    std::string hash;       ///< of its bytes, if they are on the disk
  };
  void scan();
  const std::string& chunk_text(std::uint64_t chunk) const;
  std::vector<TomlNode> cells_of(const Line& line) const;
  std::string place(std::int64_t line) const;

  InputFile file_;
  std::vector<std::string> names_;
  std::uint64_t rows_ = 0;
  std::vector<Chunk> chunks_;  // and one behind the last
  // The chunk that was read last: rows are mostly asked for in order. Several threads ask.
  mutable std::mutex reading_;
  mutable std::uint64_t held_ = ~std::uint64_t{0};
  mutable std::string held_text_;
  mutable std::vector<Line> held_rows_;
};

}  // namespace surveymc::config
