#pragma once
#include <string>

namespace surveymc {

/// The text with the small letters of the alphabet for its capitals; other bytes stay, whatever the locale.
inline std::string small_letters(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

}  // namespace surveymc
