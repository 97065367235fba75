#include "config/checked_numbers.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "config/suggest.h"

namespace surveymc::config {
namespace {

constexpr double kMostValues = 1e7;  // more is a typing error in `step`, and would fill the memory
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

double checked_number(const TomlNode& n, const std::string& key, const Range& range) {
  if (!n.is_number()) refuse_kind(n, key, "must be a number");
  const double x = n.as_double();
  if (!is_in(range, x)) refuse(n, key, rule_of(range));
  // Fourth powers and their products have to be numbers, and divisors not 0.
  if (std::abs(x) > kLargest) refuse(n, key, "must be at most 1e30 in size");
  const bool is_divisor = range.lo == 0 && range.lo_open;
  if (is_divisor && x < 1 / kLargest) refuse(n, key, "must be at least 1e-30");
  return x;
}

std::vector<double> checked_numbers(const TomlNode& n, const std::string& key, const Range& range) {
  std::vector<double> x;
  for (std::size_t i = 0; i < n.items.size(); ++i) {
    x.push_back(checked_number(n.items[i], fmt::format("{}[{}]", key, i), range));
  }
  return x;
}

bool is_steps(const TomlNode& n) { return n.is_table() && (n.entry("from") || n.entry("to") || n.entry("step")); }

double Steps::value(std::uint64_t i) const {
  if (ends_at_to && i + 1 == count) return to;
  const auto k = static_cast<double>(i);
  return decimals > 0 ? (std::round(from * decimals) + k * std::round(step * decimals)) / decimals : from + k * step;
}

Steps steps_of(const TomlNode& n, const std::string& key, const Range& range, double most) {
  const std::string from_key = join_key(key, "from"), to_key = join_key(key, "to"), step_key = join_key(key, "step");
  for (const auto& [k, v] : n.entries) {
    if (k == "from" || k == "to" || k == "step") continue;
    refuse(v.place, join_key(key, key_text(k)), unknown_key_rule(key, k, {from_key, to_key, step_key}));
  }
  for (const char* k : {"from", "to", "step"}) {
    if (!n.entry(k)) refuse(n.place, join_key(key, k), "missing");
  }
  const TomlNode& step_node = *n.entry("step");
  Steps x;
  x.from = checked_number(*n.entry("from"), from_key, range);
  x.to = checked_number(*n.entry("to"), to_key, range);
  x.step = checked_number(step_node, step_key, Range{});
  if (x.step == 0) refuse(step_node, step_key, "must not be 0");
  const double steps = (x.to - x.from) / x.step;
  if (!(steps >= 0)) {
    refuse(step_node, step_key, fmt::format("must lead from {} to {}", format_number(x.from), format_number(x.to)));
  }
  if (!(steps < most))
    refuse(step_node, step_key, fmt::format("gives more than {} values", most > kMostValues ? "2^40" : "1e7"));

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
    refuse(step_node, step_key, fmt::format("is too small to change {}", format_number(x.value(i))));
  }
  return x;
}

std::vector<double> expand_steps(const TomlNode& n, const std::string& key, const Range& range) {
  const Steps steps = steps_of(n, key, range, kMostValues);
  std::vector<double> x;
  for (std::uint64_t i = 0; i < steps.count; ++i) x.push_back(steps.value(i));
  return x;
}

}  // namespace surveymc::config
