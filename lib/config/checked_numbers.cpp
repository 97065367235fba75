#include "config/checked_numbers.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "config/suggest.h"

namespace surveymc::config {
namespace {

constexpr double kMostValues = 1e7;     // more is a typing error in `step`, and would fill the memory
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

std::vector<double> expand_steps(const TomlNode& n, const std::string& key, const Range& range) {
  const std::string from_key = join_key(key, "from"), to_key = join_key(key, "to"), step_key = join_key(key, "step");
  for (const auto& [k, v] : n.entries) {
    if (k == "from" || k == "to" || k == "step") continue;
    refuse(v.place, join_key(key, key_text(k)), unknown_key_rule(key, k, {from_key, to_key, step_key}));
  }
  for (const char* k : {"from", "to", "step"}) {
    if (!n.entry(k)) refuse(n.place, join_key(key, k), "missing");
  }
  const TomlNode& step_node = *n.entry("step");
  const double from = checked_number(*n.entry("from"), from_key, range);
  const double to = checked_number(*n.entry("to"), to_key, range);
  const double step = checked_number(step_node, step_key, Range{});
  if (step == 0) refuse(step_node, step_key, "must not be 0");
  const double steps = (to - from) / step;
  if (!(steps >= 0)) {
    refuse(step_node, step_key, fmt::format("must lead from {} to {}", format_number(from), format_number(to)));
  }
  if (!(steps < kMostValues)) refuse(step_node, step_key, "gives more than 1e7 values");

  double decimals = 0;  // a power of ten that makes integers of from and step; 0 if there is none
  for (double p = 1; p <= 1e12 && decimals == 0; p *= 10) {
    const double a = std::round(from * p), b = std::round(step * p);
    // Below 2^53 every integer is a double, so only the division rounds.
    if (a / p == from && b / p == step && std::abs(a) + (steps + 1) * std::abs(b) < 0x1p53) decimals = p;
  }
  std::vector<double> x;
  const auto last = static_cast<std::size_t>(steps + kStepRounding);
  for (std::size_t i = 0; i <= last; ++i) {
    const auto k = static_cast<double>(i);
    x.push_back(decimals > 0 ? (std::round(from * decimals) + k * std::round(step * decimals)) / decimals
                             : from + k * step);
  }
  if (std::abs(steps - static_cast<double>(last)) <= kStepRounding) x.back() = to;
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (x[i] == x[i - 1]) refuse(step_node, step_key, fmt::format("is too small to change {}", format_number(x[i])));
  }
  return x;
}

}  // namespace surveymc::config
