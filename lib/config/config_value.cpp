#include "config/config_value.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "config/suggest.h"

namespace surveymc::config {
namespace {

constexpr double kLargest = 1e30;
constexpr double kStepRounding = 1e-9;  // of a step: so far `to` may be from a whole number of steps and still be one

}  // namespace

std::string rule_of(const Range& r) {
  const bool lo = r.lo > -kInfinity, hi = r.hi < kInfinity;
  if (lo && hi) {
    return fmt::format("must be in {}{}, {}{}", r.lo_open ? '(' : '[', format_number(r.lo), format_number(r.hi),
                       r.hi_open ? ')' : ']');
  }
  if (lo) return fmt::format("must be {} {}", r.lo_open ? ">" : ">=", format_number(r.lo));
  if (hi) return fmt::format("must be {} {}", r.hi_open ? "<" : "<=", format_number(r.hi));
  return "must be a finite number";
}

bool is_in(const Range& range, double x) {
  return std::isfinite(x) && (range.lo_open ? x > range.lo : x >= range.lo) &&
         (range.hi_open ? x < range.hi : x <= range.hi);
}

double ConfigValue::number(const Range& range) const {
  if (!node->is_number()) fail_type("must be a number");
  const double x = node->as_double();
  if (!is_in(range, x)) fail(rule_of(range));
  // Fourth powers and their products have to be numbers, and divisors not 0.
  if (std::abs(x) > kLargest) fail("must be at most 1e30 in size");
  const bool is_divisor = range.lo == 0 && range.lo_open;
  if (is_divisor && x < 1 / kLargest) fail("must be at least 1e-30");
  return x;
}

std::vector<double> ConfigValue::numbers(const Range& range) const {
  std::vector<double> x;
  for (std::size_t i = 0; i < node->items.size(); ++i) x.push_back(item(i).number(range));
  return x;
}

ConfigValue ConfigValue::item(std::size_t i) const { return {&node->items[i], fmt::format("{}[{}]", key, i)}; }

ConfigValue ConfigValue::entry(const std::string& name) const {
  const TomlNode* n = node->entry(name);
  if (!n) refuse(node->place, join_key(key, name), "missing");
  return {n, join_key(key, name)};
}

bool is_steps(const TomlNode& n) { return n.is_table() && (n.entry("from") || n.entry("to") || n.entry("step")); }

double Steps::value(std::uint64_t i) const {
  if (ends_at_to && i + 1 == count) return to;
  const auto k = static_cast<double>(i);
  return decimals > 0 ? (std::round(from * decimals) + k * std::round(step * decimals)) / decimals : from + k * step;
}

std::vector<double> Steps::values() const {
  std::vector<double> x;
  for (std::uint64_t i = 0; i < count; ++i) x.push_back(value(i));
  return x;
}

Steps ConfigValue::steps(const Range& range, double most) const {
  constexpr const char* kFrom = "from";
  constexpr const char* kTo = "to";
  constexpr const char* kStep = "step";
  for (const auto& [k, v] : node->entries) {
    if (k == kFrom || k == kTo || k == kStep) continue;
    refuse(v.place, join_key(key, key_text(k)),
           unknown_key_rule(key, k, {join_key(key, kFrom), join_key(key, kTo), join_key(key, kStep)}));
  }
  const ConfigValue first = entry(kFrom), last = entry(kTo), step = entry(kStep);
  Steps x;
  x.from = first.number(range);
  x.to = last.number(range);
  x.step = step.number(Range{});
  if (x.step == 0) step.fail("must not be 0");
  const double steps = (x.to - x.from) / x.step;
  if (!(steps >= 0)) {
    step.fail(fmt::format("must lead from {} to {}", format_number(x.from), format_number(x.to)));
  }
  if (!(steps < most)) step.fail(fmt::format("gives more than {} values", most > kMostListed ? "2^40" : "1e7"));

  for (double p = 1; p <= 1e12 && x.decimals == 0; p *= 10) {
    const double a = std::round(x.from * p), b = std::round(x.step * p);
    // Below 2^53 every integer is a double, so only the division rounds.
    if (a / p == x.from && b / p == x.step && std::abs(a) + (steps + 1) * std::abs(b) < 0x1p53) x.decimals = p;
  }
  x.count = static_cast<std::uint64_t>(steps + kStepRounding) + 1;
  x.ends_at_to = std::abs(steps - static_cast<double>(x.count - 1)) <= kStepRounding;
  // Rounding is coarsest where the numbers are largest: at one of the ends.
  for (const std::uint64_t i : {std::uint64_t{1}, x.count - 1}) {
    if (i == 0 || i >= x.count || x.value(i) != x.value(i - 1)) continue;
    step.fail(fmt::format("is too small to change {}", format_number(x.value(i))));
  }
  return x;
}

}  // namespace surveymc::config
