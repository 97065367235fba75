#pragma once
/// Dimensions of formulas: exponents of metre, second and nanotesla. Angles are pure numbers.
#include <optional>
#include <string>

namespace surveymc::error_model {

/// A rational exponent in lowest terms; `under` is positive.
struct Exponent {
  int over = 0, under = 1;

  friend bool operator==(const Exponent&, const Exponent&) = default;
  friend Exponent operator+(const Exponent& a, const Exponent& b);
  friend Exponent operator*(const Exponent& a, const Exponent& b);
};
/// `x` as a fraction with a denominator of at most 12, to 1e-12; nothing if there is none or it is beyond 99.
std::optional<Exponent> exponent_of(double x);

struct Dimension {
  Exponent metre, second, nanotesla;

  bool is_pure() const { return *this == Dimension{}; }
  friend bool operator==(const Dimension&, const Dimension&) = default;
  friend Dimension operator*(const Dimension& a, const Dimension& b);
  friend Dimension operator/(const Dimension& a, const Dimension& b);
  Dimension to_power(const Exponent& e) const;
};

inline constexpr Dimension kPure{};
inline constexpr Dimension kMetre{{1, 1}, {}, {}};
inline constexpr Dimension kSecond{{}, {1, 1}, {}};
inline constexpr Dimension kNanotesla{{}, {}, {1, 1}};
inline constexpr Dimension kPerMetre{{-1, 1}, {}, {}}, kPerSecond{{}, {-1, 1}, {}};
inline constexpr Dimension kSpeed{{1, 1}, {-1, 1}, {}}, kAcceleration{{1, 1}, {-2, 1}, {}};

/// For messages: "m/s2", "1/m", "m.nT", "s^(1/2)", "pure number".
std::string dimension_text(const Dimension& d);

}  // namespace surveymc::error_model
