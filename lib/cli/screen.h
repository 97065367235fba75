#pragma once
/// The terminal that the program talks to, if there is one.
#include <cstddef>
#include <string>

#include "render/table_text.h"
#include "store/table.h"

namespace surveymc::cli {

inline constexpr std::size_t kNarrowestScreen = 40;

/// Columns of the terminal behind a file descriptor, at least kNarrowestScreen; 0 where there is none.
std::size_t screen_width(int descriptor);

/// Tables as wide as the terminal on stdout; elsewhere up to 160 letters.
render::TableFormat screen_format();

/// `text` folded at the width of the terminal behind `descriptor`, with `indent` blanks before further lines; as it is
/// where there is none.
std::string on_screen(const std::string& text, int descriptor, std::size_t indent = 2);

/// "1 row", "2 rows".
std::string counted(std::size_t n, const char* word);

/// render::printable() of every line: messages.
std::string printable_lines(const std::string& text);

/// TOML with escapes for characters that would act on the terminal: it reads back to the same values.
std::string printable_toml(const std::string& text);

/// Prints text for people: printable_lines().
void print_lines(const std::string& text);

/// Prints a table as CSV. A text that a spreadsheet would take for a formula (= + - @ in front, and no number) gets an
/// apostrophe in front, which a spreadsheet does not show. `with_header`: its line of names, too.
void print_csv(const store::Table& table, bool with_header = true);

}  // namespace surveymc::cli
