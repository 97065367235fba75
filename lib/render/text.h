#pragma once
/// Text for terminals.
#include <cstddef>
#include <string>

namespace surveymc::render {

/// Text that is safe on a terminal and in a row: control characters become spaces.
std::string printable(std::string text);

/// UTF-8 text with backslash, u and four digits for each character that printable() replaces: the same text inside a
/// string of JSON or TOML.
std::string escaped_controls(const std::string& text);

/// Code points, which is what a terminal shows for the letters and symbols we use (Greek, degree, plus-minus).
std::size_t width(const std::string& text);

/// `text` in lines of at most `widest` letters, broken at blanks; lines after the first begin with `indent` blanks. A
/// word that is longer stays whole.
std::string folded(const std::string& text, std::size_t widest, std::size_t indent = 0);

/// Length of the longest line of a text, in bytes.
std::size_t longest_line(const std::string& text);

}  // namespace surveymc::render
