#pragma once
/// Numbers of trials as people write them.
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

namespace surveymc {

/// The count that `text` writes: 20000, 2e4, 20k, 2.5M; k is a thousand, M a million. Nothing if it is no whole number
/// below 2^53, or has other letters.
inline std::optional<std::uint64_t> count_of(std::string_view text) {
  double factor = 1;
  if (text.ends_with('k') || text.ends_with('K')) factor = 1e3;
  if (text.ends_with('M')) factor = 1e6;
  if (factor > 1) text.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  // The product may miss a whole number by its rounding alone: 2.3 * 1000.
  const double count = std::round(value * factor);
  if (!(count >= 0 && count < 0x1p53) || std::abs(value * factor - count) > 1e-15 * count) return std::nullopt;
  return static_cast<std::uint64_t>(count);
}

}  // namespace surveymc
