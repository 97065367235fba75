#pragma once
/// Words of commands that a message gives to be pasted into a shell.
#include <algorithm>
#include <string>
#include <string_view>

namespace surveymc {

/// The word as it is, or in single quotes where a shell would split or expand it.
inline std::string shell_quoted(const std::string& word) {
  const bool is_plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c >= 0x80 ||
           std::string_view("_./:=+,@%-").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (is_plain) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + '\'';
}

/// The same of a file's name, which is no option even if it begins with "-".
inline std::string shell_word(const std::string& name) {
  return shell_quoted((name.starts_with('-') ? "./" : "") + name);
}

}  // namespace surveymc
