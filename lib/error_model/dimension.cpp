#include "error_model/dimension.h"

#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace surveymc::error_model {
namespace {

Exponent reduced(int over, int under) {
  const int common = std::gcd(over, under);
  return {over / common, under / common};
}

std::string power_text(const char* unit, int over, int under) {
  if (under != 1) return fmt::format("{}^({}/{})", unit, over, under);
  return over == 1 ? unit : fmt::format("{}{}", unit, over);
}

}  // namespace

Exponent operator+(const Exponent& a, const Exponent& b) {
  return reduced(a.over * b.under + b.over * a.under, a.under * b.under);
}

Exponent operator*(const Exponent& a, const Exponent& b) { return reduced(a.over * b.over, a.under * b.under); }

std::optional<Exponent> exponent_of(double x) {
  if (!(std::abs(x) <= 99)) return {};
  for (int under = 1; under <= 12; ++under) {
    const double over = std::round(x * under);
    if (std::abs(over / under - x) <= 1e-12) return reduced(static_cast<int>(over), under);
  }
  return {};
}

Dimension operator*(const Dimension& a, const Dimension& b) {
  return {a.metre + b.metre, a.second + b.second, a.nanotesla + b.nanotesla};
}

Dimension operator/(const Dimension& a, const Dimension& b) { return a * b.to_power({-1, 1}); }

Dimension Dimension::to_power(const Exponent& e) const { return {metre * e, second * e, nanotesla * e}; }

std::string dimension_text(const Dimension& d) {
  if (d.is_pure()) return "pure number";
  const std::array<std::pair<const char*, Exponent>, 3> parts{{{"m", d.metre}, {"s", d.second}, {"nT", d.nanotesla}}};
  std::string above, below;
  for (const auto& [unit, e] : parts) {
    if (e.over > 0) above += fmt::format("{}{}", above.empty() ? "" : ".", power_text(unit, e.over, e.under));
    if (e.over < 0) below += fmt::format("/{}", power_text(unit, -e.over, e.under));
  }
  return fmt::format("{}{}", above.empty() ? "1" : above, below);
}

}  // namespace surveymc::error_model
