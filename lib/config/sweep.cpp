#include "config/sweep.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "config/checked_numbers.h"
#include "config/shipped_models.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

constexpr double kMostPoints = 1e7;  // more is a typing error, and would fill the memory

/// A key as written in a sweep -> "a.b.c". `shown`: the key in messages.
std::string checked_key(const std::string& key, const std::string& shown, const std::string& place) {
  const auto clean = clean_key(key);
  if (!clean) refuse(place, shown, fmt::format("{} is not a key", in_quotes(key)));
  if (is_config_key(*clean) || (*clean + ".").starts_with("sweep.")) refuse(place, shown, "cannot be swept");
  if (*clean == "trials") refuse(place, shown, "cannot be swept: a result has one number of trials");
  return *clean;
}

/// True if a sweep that gives `value` to `key` sets `other` too: a string is the name of a table, a table in braces
/// sets its own keys, and anything else replaces the whole table.
bool sets(const std::string& key, const TomlNode& value, const std::string& other) {
  if (key == other) return true;
  if (value.is_text()) return other == key + ".name";
  if (!value.is_table()) return other.starts_with(key + ".");
  return std::any_of(value.entries.begin(), value.entries.end(),
                     [&](const auto& e) { return sets(join_key(key, e.first), e.second, other); });
}

/// Values of { from, to, step }. Integers stay integers, so that they can be read as such.
std::vector<TomlNode> values_of_steps(const TomlNode& list, const std::string& shown) {
  const auto numbers = expand_steps(list, shown, Range{});
  const auto is_integer = [&](const char* key) { return list.entry(key)->kind == TomlNode::Kind::integer; };
  const bool are_integers = is_integer("from") && is_integer("step");
  std::vector<TomlNode> values;
  for (const double x : numbers) {
    // Beyond 2^53 a double may stand for another integer than the one that was meant.
    TomlNode n = are_integers && std::abs(x) < 0x1p53 ? node_of(static_cast<std::int64_t>(x)) : node_of(x);
    n.place = list.place;
    n.line = list.line;
    values.push_back(std::move(n));
  }
  return values;
}

/// { match = [...], without = [...] }: patterns of names.
bool is_match(const TomlNode& n) { return n.is_table() && n.entry("match") != nullptr; }

std::vector<std::string> patterns_of(const TomlNode& n, const std::string& shown) {
  std::vector<std::string> out;
  if (n.is_text()) return {n.text};
  if (!n.is_array()) refuse_kind(n, shown, "must be a pattern or a list of patterns such as \"MWD+*\"");
  for (const TomlNode& item : n.items) {
    if (!item.is_text()) refuse_kind(item, shown, "must be a string");
    out.push_back(item.text);
  }
  return out;
}

/// The list of shipped error models that the patterns choose, in the order of the catalogues.
TomlNode matching_names(const std::string& key, const TomlNode& list, const std::string& shown) {
  if (key != "error_model" && key != "error_model.name")
    refuse(list.place, shown, "only error_model.name can be swept by match");
  for (const auto& [k, v] : list.entries)
    if (k != "match" && k != "without") refuse(v.place, join_key(shown, k), "unknown key: match or without");
  const TomlNode* without = list.entry("without");
  const std::vector<std::string> names =
      matching_shipped_models(patterns_of(*list.entry("match"), shown + ".match"),
                              without ? patterns_of(*without, shown + ".without") : std::vector<std::string>());
  if (names.empty()) refuse(list.place, shown, "fits no shipped error model: surveymc models lists them");
  TomlNode out;
  out.kind = TomlNode::Kind::array;
  out.place = list.place;
  out.line = list.line;
  for (const std::string& name : names) {
    out.items.push_back(node_of(name));
    out.items.back().place = list.place;
    out.items.back().line = list.line;
  }
  return out;
}

std::vector<TomlNode> values_of_list(const TomlNode& list, const std::string& shown) {
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
    if (!seen.insert(is_zero ? "0" : plain_text(n)).second) refuse(n, shown, "is in the list twice");
  }
  return list.items;
}

}  // namespace

bool is_config_key(const std::string& key) { return key == "experiment" || key == "seed" || key == "title"; }

// ----------------------------------------------------------------------------------------------------------- reading

void Sweep::read(const TomlNode& table) {
  if (!table.is_table()) refuse(table, "sweep", "must be a table: write [sweep]");
  if (table.entries.empty()) refuse(table, "sweep", "is empty");
  if (const TomlNode* list = table.entry("case")) {
    if (!list->is_tables()) refuse(*list, "sweep.case", "must be an array of tables: write [[sweep.case]]");
    std::set<std::string> names;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
      const TomlNode& item = list->items[i];
      const std::string shown = fmt::format("sweep.case[{}]", i), shown_name = shown + ".name";
      const TomlNode* name = item.entry("name");
      if (!name) refuse(item.place, shown_name, "missing");
      if (!name->is_text()) refuse_kind(*name, shown_name, "must be a string");
      if (name->text.empty()) refuse(*name, shown_name, "must not be empty");
      if (!names.insert(name->text).second) refuse(*name, shown_name, "two cases have this name");
      Case& c = cases_.emplace_back(Case{name->text, {}});
      read_case(c, item, "", shown);
      refuse_twins(c, shown);
    }
  }
  read_lists(table, "");
}

void Sweep::read_case(Case& c, const TomlNode& table, const std::string& path, const std::string& shown) {
  for (const auto& [k, v] : table.entries) {
    if (path.empty() && k == "name") continue;
    const std::string written = join_key(path, k);
    const std::string key = checked_key(written, join_key(shown, key_text(written)), v.place);
    // A table written with dots or under a header is a way to write its keys; one in braces is a value.
    if (v.is_table() && !v.is_inline) {
      read_case(c, v, key, shown);
    } else if (!c.values.emplace(key, v).second) {
      refuse(v, join_key(shown, key), "is set twice");
    }
  }
}

void Sweep::read_lists(const TomlNode& table, const std::string& path) {
  for (const auto& [k, v] : table.entries) {
    if (path.empty() && k == "case") continue;
    const std::string key = join_key(path, k);
    if (v.is_table() && !is_steps(v) && !is_match(v)) {
      if (v.entries.empty()) refuse(v, "sweep." + key, "is empty");
      read_lists(v, key);
    } else {
      add_list(key, v);
    }
  }
}

void Sweep::add_list(const std::string& written, const TomlNode& list) {
  const std::string key = checked_key(written, "sweep." + key_text(written), list.place);
  const TomlNode values = is_match(list) ? matching_names(key, list, "sweep." + key) : list;
  if (!axes_.emplace(key, Axis{values, {}}).second) refuse(list, "sweep." + key, "is given twice");
}

void Sweep::set_list(const std::string& key, const TomlNode& list) {
  axes_.erase(key);
  add_list(key, list);
}

void Sweep::fix(const std::string& key, const TomlNode& value) {
  const auto is_overridden = [&](const std::string& swept) {
    return swept == key || (value.is_text() ? swept == key + ".name" : swept.starts_with(key + "."));
  };
  std::erase_if(axes_, [&](const auto& entry) {
    const auto& [swept, axis] = entry;
    const auto& items = axis.list.items;
    const bool is_above = key.starts_with(swept + ".");  // the sweep sets a table or a name above the key
    const bool are_names = is_above && axis.list.is_array() &&
                           std::all_of(items.begin(), items.end(), [](const TomlNode& n) { return n.is_text(); });
    if (is_above && !are_names) refuse(value, key, fmt::format("{} is swept as a whole", swept));
    return is_overridden(swept) || (are_names && key == swept + ".name");
  });
  for (auto& c : cases_) {
    for (auto it = c.values.begin(); it != c.values.end();) {
      auto& [swept, v] = *it;
      bool remove = is_overridden(swept);
      if (swept == key && v.is_table() && value.is_text()) {
        v.entries["name"] = value;
        remove = false;
      } else if (key.starts_with(swept + ".")) {
        if (v.is_table()) {
          assign(v, key.substr(swept.size() + 1), value);
        } else if (v.is_text()) {
          remove = key == swept + ".name";
        } else {
          refuse(value, key, fmt::format("sweep.case sets {} as a whole", swept));
        }
      }
      it = remove ? c.values.erase(it) : std::next(it);
    }
  }
}

void Sweep::expand() {
  double points = static_cast<double>(std::max<std::size_t>(1, cases_.size()));
  for (auto& [key, axis] : axes_) {
    const std::string shown = "sweep." + key;
    axis.values = is_steps(axis.list) ? values_of_steps(axis.list, shown) : values_of_list(axis.list, shown);
    refuse_twins(key, axis);
    points *= static_cast<double>(axis.values.size());
    if (points > kMostPoints) refuse(axis.list.place, "sweep", "has more than 1e7 points");
  }
}

/// One case that sets the same key in two ways.
void Sweep::refuse_twins(const Case& c, const std::string& shown) {
  for (const auto& [key, value] : c.values) {
    for (const auto& [other, other_value] : c.values) {
      if (other == key || !sets(key, value, other)) continue;
      refuse(other_value, join_key(shown, other), fmt::format("is set twice: {} sets it too", key));
    }
  }
}

/// Two dimensions that set the same key.
void Sweep::refuse_twins(const std::string& key, const Axis& axis) const {
  const auto twin = axes_.find(key + ".name");
  if (twin != axes_.end() && axis.values.front().is_text()) {
    refuse(twin->second.list, "sweep." + twin->first, fmt::format("is the same as sweep.{}", key));
  }
  for (const auto& c : cases_) {
    for (const auto& [other, value] : c.values) {
      if (!sets(other, value, key) && !sets(key, axis.values.front(), other)) continue;
      refuse(value, other,
             fmt::format("{}is also in [sweep]: a key can vary with the case or by itself",
                         other == key ? "" : key + " "));
    }
  }
}

// ------------------------------------------------------------------------------------------------------------ points

std::size_t Sweep::point_count() const {
  std::size_t n = std::max<std::size_t>(1, cases_.size());
  for (const auto& [key, axis] : axes_) n *= axis.values.size();
  return n;
}

std::vector<std::size_t> Sweep::indices(std::size_t point) const {
  std::vector<std::size_t> out(axes_.size() + 1);
  std::size_t j = axes_.size();
  for (auto it = axes_.rbegin(); it != axes_.rend(); ++it, --j) {
    out[j] = point % it->second.values.size();
    point /= it->second.values.size();
  }
  out[0] = point;
  return out;
}

std::vector<SweepValue> Sweep::values(std::size_t point) const {
  const auto at = indices(point);
  std::vector<SweepValue> out;
  if (has_cases()) out.push_back({"case", cases_[at[0]].name});
  std::size_t j = 1;
  for (const auto& [key, axis] : axes_) {
    const TomlNode& n = axis.values[at[j++]];
    if (n.is_number()) {
      out.push_back({key, n.as_double()});
    } else {
      out.push_back({key, n.is_text() ? n.text : plain_text(n)});
    }
  }
  return out;
}

std::string Sweep::case_name(std::size_t point) const { return has_cases() ? cases_[indices(point)[0]].name : ""; }

void Sweep::apply(TomlNode& root, std::size_t point) const {
  const auto at = indices(point);
  if (has_cases()) {
    for (const auto& [key, value] : cases_[at[0]].values) assign(root, key, value);
  }
  std::size_t j = 1;
  for (const auto& [key, axis] : axes_) assign(root, key, axis.values[at[j++]]);
}

bool Sweep::varies(const std::string& key) const {
  const auto touches = [&](const std::string& swept, const TomlNode& value) {
    if (swept == key || swept.starts_with(key + ".")) return true;
    return value.is_text() ? swept + ".name" == key : key.starts_with(swept + ".");
  };
  const auto case_touches = [&](const Case& c) {
    return std::any_of(c.values.begin(), c.values.end(), [&](const auto& e) { return touches(e.first, e.second); });
  };
  return std::any_of(axes_.begin(), axes_.end(),
                     [&](const auto& e) { return touches(e.first, e.second.values.front()); }) ||
         std::any_of(cases_.begin(), cases_.end(), case_touches);
}

std::string Sweep::toml() const {
  std::string out;
  if (!axes_.empty()) out += "\n[sweep]\n";
  for (const auto& [key, axis] : axes_) out += toml_line(key, axis.list);
  for (const auto& c : cases_) {
    out += "\n[[sweep.case]]\n" + toml_line("name", node_of(c.name));
    for (const auto& [key, value] : c.values) out += toml_line(key, value);
  }
  return out;
}

}  // namespace surveymc::config
