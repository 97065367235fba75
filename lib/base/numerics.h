#pragma once
#include <string>
#include <string_view>

namespace surveymc {

/// Raised by one with every change after which the same config and seed may give another bit of any number. Tallies of
/// two builds are merged only if their versions are equal. tests/formats holds the numbers of the smoke configs against
/// this version.
inline constexpr int kNumericsVersion = 14;

/// Begins the part of a program's name that decides the bits of its numbers.
inline constexpr std::string_view kNumericsMark = "; numerics ";

/// The part of a program's name that decides the bits of its numbers; the whole name if it does not say.
inline std::string_view numerics_of(std::string_view program) {
  const std::size_t at = program.find(kNumericsMark);
  return at == std::string_view::npos ? program : program.substr(at);
}

}  // namespace surveymc
