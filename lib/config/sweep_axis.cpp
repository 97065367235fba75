#include "config/sweep_axis.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "config/suggest.h"

namespace surveymc::config {
namespace {

std::vector<TomlNode> checked_items(const TomlNode& list, const std::string& shown, bool may_repeat) {
  if (!list.is_array()) refuse_kind(list, shown, "must be a list or { from, to, step }");
  if (list.items.empty()) refuse(list, shown, "must not be empty");
  std::set<std::string> seen;
  for (const TomlNode& n : list.items) {
    if (n.is_table() || n.kind == TomlNode::Kind::date) {
      refuse(n, shown, "every value must be a number, a string or a list: use [[sweep.case]] for tables");
    }
    const TomlNode& first = list.items.front();
    if (n.kind != first.kind && !(n.is_number() && first.is_number())) {
      refuse(n, shown, "the values of a list must be of one kind");
    }
    const bool is_zero = n.is_number() && n.as_double() == 0;  // -0.0 prints otherwise but is the same number
    if (!seen.insert(is_zero ? "0" : plain_text(n)).second && !may_repeat) refuse(n, shown, "is in the list twice");
  }
  return list.items;
}

/// The nearest decimal of 14 digits: 0.3, not 0.30000000000000004, and the same on machines whose pow() differs in its
/// last bit.
double decimal(double x) {
  const std::string text = fmt::format("{:.13e}", x);
  double out = x;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

}  // namespace

SweepAxis::SweepAxis(const TomlNode& list, const std::string& shown, bool may_repeat)
    : place_(list.place), line_(list.line) {
  if (is_steps(list))
    read_range(list, shown);
  else
    items_ = checked_items(list, shown, may_repeat);
}

void SweepAxis::read_range(const TomlNode& range, const std::string& shown) {
  const TomlNode *count = range.entry("count"), *scale = range.entry("scale");
  const auto is_integer = [&](const char* key) {
    const TomlNode* n = range.entry(key);
    return n && n->kind == TomlNode::Kind::integer;
  };
  if (!count && !scale && range.entry("step")) {
    form_ = Form::steps;
    steps_ = ConfigValue{&range, shown}.steps(Range{}, kMostPoints);
    are_integers_ = is_integer("from") && is_integer("step");
    return;
  }
  form_ = count ? Form::count : Form::interval;
  const auto key = [&](const char* name) { return join_key(shown, name); };
  for (const auto& [k, v] : range.entries) {
    if (k == "from" || k == "to" || k == "count" || k == "scale") continue;
    if (k == "step") refuse(v, key("step"), "count and scale go without it");
    refuse(v.place, join_key(shown, key_text(k)),
           unknown_key_rule(shown, k, {key("from"), key("to"), key("step"), key("count"), key("scale")}));
  }
  const ConfigValue whole{&range, shown}, from = whole.entry("from"), to = whole.entry("to");
  if (scale) {
    if (!scale->is_text()) refuse_kind(*scale, key("scale"), "must be a string");
    if (scale->text != "linear" && scale->text != "log") refuse(*scale, key("scale"), "must be linear or log");
    is_log_ = scale->text == "log";
  }
  steps_.from = from.number(Range{});
  steps_.to = to.number(Range{});
  if (steps_.from > steps_.to) from.fail(fmt::format("must not be above to = {}", format_number(steps_.to)));
  if (is_log_ && steps_.from <= 0) from.fail("must be > 0 on a logarithmic axis");
  if (!count) {
    if (steps_.from == steps_.to) to.fail("must be above from");
    return;
  }
  if (count->kind != TomlNode::Kind::integer) refuse_kind(*count, key("count"), "must be an integer");
  if (count->integer < 1 || static_cast<double>(count->integer) > kMostPoints)
    refuse(*count, key("count"), "must be in [1, 1099511627776]");
  steps_.count = static_cast<std::uint64_t>(count->integer);
  if ((steps_.count == 1) != (steps_.from == steps_.to))
    refuse(*count, key("count"),
           steps_.count == 1 ? "must be above 1, as from and to differ" : "must be 1, as from and to are the same");
  for (const std::uint64_t i : {std::uint64_t{1}, steps_.count - 1})
    if (i > 0 && i < steps_.count &&
        fraction(static_cast<double>(i) / static_cast<double>(steps_.count - 1)) ==
            fraction(static_cast<double>(i - 1) / static_cast<double>(steps_.count - 1)))
      refuse(*count, key("count"), "is too large: neighbouring values are the same number");
  const double spacing = steps_.count > 1 ? (steps_.to - steps_.from) / static_cast<double>(steps_.count - 1) : 1;
  are_integers_ = !is_log_ && is_integer("from") && is_integer("to") && spacing == std::floor(spacing);
}

double SweepAxis::fraction(double share) const {
  if (share <= 0) return steps_.from;
  if (share >= 1) return steps_.to;
  return decimal(is_log_ ? steps_.from * std::pow(steps_.to / steps_.from, share)
                         : steps_.from + (steps_.to - steps_.from) * share);
}

std::uint64_t SweepAxis::size() const {
  switch (form_) {
    case Form::list:
      return items_.size();
    case Form::interval:
      return 2;
    default:
      return steps_.count;
  }
}

TomlNode SweepAxis::node(double x) const {
  // Beyond 2^53 a double may stand for another integer than the one that was meant.
  TomlNode n = are_integers_ && std::abs(x) < 0x1p53 ? node_of(static_cast<std::int64_t>(x)) : node_of(x);
  n.place = place_;
  n.line = line_;
  return n;
}

TomlNode SweepAxis::value(std::uint64_t i) const {
  switch (form_) {
    case Form::list:
      return items_.at(i);
    case Form::steps:
      return node(steps_.value(i));
    case Form::count:
      return node(steps_.count > 1 ? fraction(static_cast<double>(i) / static_cast<double>(steps_.count - 1))
                                   : steps_.from);
    case Form::interval:
      return node(i == 0 ? steps_.from : steps_.to);
  }
  return {};
}

TomlNode SweepAxis::at(double u) const {
  if (form_ == Form::interval) return node(fraction(u));
  const std::uint64_t n = size();
  return value(std::min(static_cast<std::uint64_t>(u * static_cast<double>(n)), n - 1));
}

}  // namespace surveymc::config
