#pragma once
/// A user's CSV file as numbers with names, before anything is made of it.
#include <functional>
#include <string>
#include <vector>

namespace surveymc::config {

/// Columns of one file. `lines` keeps the line number of every row, so that a check made later can name the place.
struct InputTable {
  std::string path;                ///< as the config names it, for messages and provenance
  std::vector<std::string> names;  ///< header cells, as written: name and unit (`md_ft`)
  std::vector<std::vector<double>> columns;
  std::vector<int> lines;                ///< 1-based line of every row
  int names_line = 1;                    ///< of the header
  std::vector<std::string> doubts = {};  ///< what its reader warned of, if the file is of another form

  std::size_t rows() const { return lines.size(); }
  /// Index of a column, or -1.
  int find(const std::string& name) const;
};

/// Behind the name of a file: the text that keeps its doubts, a line each, beside the file in a result.
inline const std::string kDoubtsSuffix = ": what is doubtful";

/// A user's file that is no table: its text.
struct InputText {
  std::string path;  ///< as the config names it
  std::string text;
};

/// Parses CSV text (RFC 4180: commas, optional quotes; lines end with LF, CRLF or CR; UTF-8 byte order mark ignored).
/// Blank lines, lines of empty cells and `#` comment lines are skipped, empty cells behind the last column ignored.
/// Every other cell must be a finite decimal number, every row as long as the header. `check_names` sees the table
/// when it has no rows yet, and throws for names that the caller does not know.
/// Throws InputError "path:line: column = cell: rule".
InputTable parse_csv(const std::string& text, const std::string& path,
                     const std::function<void(const InputTable&)>& check_names = nullptr);

}  // namespace surveymc::config
