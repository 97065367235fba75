#include "config/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "config/config_value.h"
#include "config/shipped_models.h"
#include "config/suggest.h"
#include "config/text.h"
#include "random/design_points.h"

namespace surveymc::config {
namespace {

/// True if a sweep that gives `value` to `key` sets `other` too: a string is the name of a table, a table in braces
/// sets its own keys, and anything else replaces the whole table.
bool sets(const std::string& key, const TomlNode& value, const std::string& other) {
  if (key == other) return true;
  if (value.is_text()) return other == key + ".name";
  if (!value.is_table()) return other.starts_with(key + ".");
  return std::any_of(value.entries.begin(), value.entries.end(),
                     [&](const auto& e) { return sets(join_key(key, e.first), e.second, other); });
}

/// A key as written in a sweep -> "a.b.c". `shown`: the key in messages; `given`: its value, or a list of them.
std::string checked_key(const std::string& key, const TomlNode& given, const std::string& shown,
                        const std::string& place) {
  const auto clean = clean_key(key);
  if (!clean) refuse(place, shortened(shown), no_key_rule(key));
  if (is_config_key(*clean) || (*clean + ".").starts_with("sweep.")) refuse(place, shown, "cannot be swept");
  if (*clean == "trials") refuse(place, shown, "cannot be swept: a result has one number of trials");
  const auto sets_family = [&](const TomlNode& value) { return sets(*clean, value, "verdict.family"); };
  if (given.is_array() ? std::any_of(given.items.begin(), given.items.end(), sets_family) : sets_family(given))
    refuse(place, shown, "sets verdict.family, which cannot be swept: a result has one family of verdicts");
  return *clean;
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
    const std::string key = checked_key(written, v, join_key(shown, key_text(written)), v.place);
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
    if (path.empty() && k == "design") {
      read_design(v);
      continue;
    }
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
  const std::string key = checked_key(written, list, "sweep." + key_text(written), list.place);
  const TomlNode values = is_match(list) ? matching_names(key, list, "sweep." + key) : list;
  if (!axes_.emplace(key, Axis{values, {}}).second) refuse(list, "sweep." + key, "is given twice");
}

void Sweep::read_design(const TomlNode& n) {
  const std::string shown = "sweep.design";
  constexpr const char* kKinds = "must be product, zip, latin_hypercube, sobol or table";
  const TomlNode* kind = n.is_table() ? n.entry("kind") : &n;
  if (!kind) refuse(n.place, shown + ".kind", "missing");
  const std::string shown_kind = n.is_table() ? shown + ".kind" : shown;
  if (!kind->is_text()) refuse_kind(*kind, shown_kind, kKinds);
  static const std::map<std::string, Kind> kinds = {{"product", Kind::product},
                                                    {"zip", Kind::zip},
                                                    {"latin_hypercube", Kind::latin_hypercube},
                                                    {"sobol", Kind::sobol},
                                                    {"table", Kind::table}};
  const auto found = kinds.find(kind->text);
  if (found == kinds.end()) refuse(*kind, shown_kind, kKinds);
  design_ = {found->second, 0, 0, n, true};
  const bool is_random = design_.kind == Kind::latin_hypercube || design_.kind == Kind::sobol;
  std::set<std::string> needed;
  if (is_random) needed = {"points", "seed"};
  if (design_.kind == Kind::table) needed = {"file"};
  for (const std::string& key : needed)
    if (!n.is_table() || !n.entry(key))
      refuse(n.place, join_key(shown, key), fmt::format("missing: a design of kind {} needs it", kind->text));
  std::set<std::string> known = {shown + ".kind"};
  for (const std::string& key : needed) known.insert(join_key(shown, key));
  for (const auto& [k, v] : n.entries)
    if (k != "kind" && !needed.contains(k))
      refuse(v.place, join_key(shown, key_text(k)), unknown_key_rule(shown, k, known));
  if (!is_random) return;
  const auto whole = [&](const char* key, double least, double most, const std::string& rule) {
    const TomlNode& x = *n.entry(key);
    const std::string full = join_key(shown, key);
    if (x.kind != TomlNode::Kind::integer) refuse_kind(x, full, "must be an integer");
    if (x.as_double() < least || x.as_double() > most) refuse(x, full, rule);
    return static_cast<std::uint64_t>(x.integer);
  };
  design_.points = whole("points", 1, kMostPoints, "must be in [1, 1099511627776]");
  design_.seed = whole("seed", 0, 0x1p63, "must be in [0, 9223372036854775807]");
}

void Sweep::set_list(const std::string& key, const TomlNode& list) {
  if (key == "design") {
    read_design(list);
    return;
  }
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
  if (design_.kind == Kind::table) fixed_.emplace_back(key, value);
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

void Sweep::expand(const std::function<InputFile(const TomlNode&, const std::string&)>& file_of) {
  if (design_.kind == Kind::table)
    expand_table(file_of);
  else
    expand_axes();
  const double points = static_cast<double>(cases_or_one()) * static_cast<double>(in_design_);
  if (points > kMostPoints) refuse(design_.written.place, "sweep", "has more than 2^40 points");
  count_ = cases_or_one() * in_design_;
}

void Sweep::expand_axes() {
  const bool is_random = design_.kind == Kind::latin_hypercube || design_.kind == Kind::sobol;
  if (design_.is_given && design_.kind != Kind::product && axes_.empty())
    refuse(design_.written, "sweep.design", "needs keys to vary: give some in [sweep]");
  if (design_.kind == Kind::sobol && axes_.size() > random::kSobolAxes)
    refuse(design_.written.place, "sweep.design",
           fmt::format("has {} keys; a design of kind sobol has at most {}", axes_.size(), random::kSobolAxes));
  double points = 1;
  for (auto& [key, axis] : axes_) {
    const std::string shown = "sweep." + key;
    axis.values = SweepAxis(axis.list, shown, design_.kind == Kind::zip);
    if (axis.values.is_interval() && !is_random) {
      // What is missing of a grid is a step; whoever wrote a scale meant a count.
      const bool has_scale = axis.list.entry("scale") != nullptr;
      refuse(axis.list.place, shown + (has_scale ? ".count" : ".step"),
             has_scale ? "missing" : "missing (or count; only latin_hypercube and sobol draw from an interval)");
    }
    refuse_twins(key, axis.values.value(0), axis.list.place);
    if (design_.kind == Kind::zip && axis.values.size() != axes_.begin()->second.values.size())
      refuse(axis.list.place, shown,
             fmt::format("has {} values, but sweep.{} has {}: with design = \"zip\" all lists have the same length",
                         axis.values.size(), axes_.begin()->first, axes_.begin()->second.values.size()));
    points *= static_cast<double>(axis.values.size());
    if (design_.kind == Kind::product && points * static_cast<double>(cases_or_one()) > kMostPoints)
      refuse(axis.list.place, "sweep", "has more than 2^40 points");
  }
  if (design_.kind == Kind::product) in_design_ = static_cast<std::size_t>(points);
  if (design_.kind == Kind::zip) in_design_ = axes_.begin()->second.values.size();
  if (is_random) in_design_ = design_.points;
}

void Sweep::expand_table(const std::function<InputFile(const TomlNode&, const std::string&)>& file_of) {
  if (!axes_.empty())
    refuse(axes_.begin()->second.list.place, "sweep." + axes_.begin()->first,
           "cannot be swept beside a table of points: make it a column of that table");
  const TomlNode& name = *design_.written.entry("file");
  table_ = std::make_unique<SweepTable>(file_of(name, "sweep.design.file"));
  const std::vector<TomlNode> first = table_->row(0);
  for (std::size_t c = 0; c < first.size(); ++c) {
    const std::string& written = table_->names()[c];
    const std::string key = checked_key(written, first[c], written, table_->path());
    if (!first_row_.emplace(key, first[c]).second) refuse(table_->path(), key, "two columns have this name");
    for (const auto& [fixed, value] : fixed_)
      if (sets(fixed, value, key) || sets(key, first[c], fixed))
        refuse(value, fixed, fmt::format("{} is a column of {}: delete that column", key, table_->path()));
    columns_.emplace_back(key, c);
  }
  for (const auto& [key, value] : first_row_) refuse_twins(key, value, table_->path());  // of all columns, in any order
  std::sort(columns_.begin(), columns_.end());
  in_design_ = table_->rows();
}

void Sweep::check_table(const std::function<void()>& between) const {
  if (table_) table_->check(between);
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

/// Two dimensions that set the same key. `value`: of `key`, at some point.
void Sweep::refuse_twins(const std::string& key, const TomlNode& value, const std::string& place) const {
  const auto twin = axes_.find(key + ".name");
  if (twin != axes_.end() && value.is_text()) {
    refuse(twin->second.list, "sweep." + twin->first, fmt::format("is the same as sweep.{}", key));
  }
  if (first_row_.contains(key + ".name") && value.is_text()) refuse(place, key, "is the same as " + key + ".name");
  for (const auto& c : cases_) {
    for (const auto& [other, other_value] : c.values) {
      if (!sets(other, other_value, key) && !sets(key, value, other)) continue;
      refuse(other_value, other,
             fmt::format("{}is also in [sweep]: a key can vary with the case or by itself",
                         other == key ? "" : key + " "));
    }
  }
}

// ------------------------------------------------------------------------------------------------------------ points

std::vector<std::pair<std::string, TomlNode>> Sweep::design_values(std::size_t at) const {
  std::vector<std::pair<std::string, TomlNode>> out;
  if (table_) {
    std::vector<TomlNode> row = table_->row(at);
    for (const auto& [key, column] : columns_) out.emplace_back(key, std::move(row[column]));
    return out;
  }
  unsigned axis = 0;
  for (const auto& [key, a] : axes_) {
    switch (design_.kind) {
      case Kind::latin_hypercube:
        out.emplace_back(key, a.values.at(random::latin_hypercube(at, design_.points, axis, design_.seed)));
        break;
      case Kind::sobol:
        out.emplace_back(key, a.values.at(random::sobol(at, axis, design_.seed)));
        break;
      case Kind::zip:
        out.emplace_back(key, a.values.value(at));
        break;
      default:
        out.emplace_back(key, TomlNode{});
    }
    ++axis;
  }
  if (design_.kind == Kind::product) {  // the last key fastest
    auto it = out.rbegin();
    for (auto a = axes_.rbegin(); a != axes_.rend(); ++a, ++it) {
      it->second = a->second.values.value(at % a->second.values.size());
      at /= a->second.values.size();
    }
  }
  return out;
}

namespace {

SweepValue value_at(const std::string& key, const TomlNode& n) {
  if (n.is_number()) return {key, n.as_double()};
  return {key, n.is_text() ? n.text : plain_text(n)};
}

}  // namespace

std::vector<SweepValue> Sweep::values(std::size_t point) const {
  std::vector<SweepValue> out;
  if (has_cases()) out.push_back({"case", cases_[case_of(point)].name});
  for (const auto& [key, n] : design_values(in_case(point))) {
    out.push_back(value_at(key, n));
    // A column is of numbers or of text: that of its first row. A list is of one kind anyway.
    const auto first = first_row_.find(key);
    if (first != first_row_.end() && first->second.is_number() != n.is_number()) {
      if (first->second.is_number())
        refuse(n, key, fmt::format("must be a number, as in the first row of {}", table_->path()));
      out.back().value = plain_text(n);
    }
  }
  return out;
}

std::vector<SweepDimension> Sweep::dimensions() const {
  std::vector<SweepDimension> out;
  if (has_cases()) {
    std::vector<std::string> names;
    for (const Case& c : cases_) names.push_back(c.name);
    out.push_back({"case", std::move(names)});
  }
  for (const auto& [key, axis] : axes_) {
    const bool is_number = axis.values.value(0).is_number();
    std::vector<double> numbers;
    std::vector<std::string> words;
    for (std::uint64_t i = 0; i < axis.values.size(); ++i) {
      const SweepValue v = value_at(key, axis.values.value(i));
      if (is_number)
        numbers.push_back(std::get<double>(v.value));
      else
        words.push_back(std::get<std::string>(v.value));
    }
    if (is_number)
      out.push_back({key, std::move(numbers)});
    else
      out.push_back({key, std::move(words)});
  }
  return out;
}

std::vector<std::size_t> Sweep::sample(std::size_t most_of_axis, std::size_t random) const {
  std::set<std::size_t> points;
  for (std::size_t c = 0; c < cases_or_one(); ++c) points.insert({c * in_design_, (c + 1) * in_design_ - 1});
  if (is_product()) {  // every value of every key, with the first values of the others
    std::size_t stride = 1;
    for (auto a = axes_.rbegin(); a != axes_.rend(); ++a) {
      const std::size_t n = a->second.values.size(), count = std::min(n, most_of_axis);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t value = count == n ? i : i * (n - 1) / (count - 1);
        points.insert(value * stride);
      }
      stride *= n;
    }
  }
  // The same points for every reader of this config: those of a permutation.
  const std::size_t count = std::min(random, count_);
  for (std::size_t i = 0; i < count; ++i) points.insert(random::permuted(i, count_, 0, count_));
  return {points.begin(), points.end()};
}

std::string Sweep::case_name(std::size_t point) const { return has_cases() ? cases_[case_of(point)].name : ""; }

void Sweep::apply(TomlNode& root, std::size_t point) const {
  if (has_cases()) {
    for (const auto& [key, value] : cases_[case_of(point)].values) assign(root, key, value);
  }
  for (const auto& [key, value] : design_values(in_case(point))) assign(root, key, value);
}

bool Sweep::varies(const std::string& key) const {
  const auto touches = [&](const std::string& swept, const TomlNode& value) {
    if (swept == key || swept.starts_with(key + ".")) return true;
    return value.is_text() ? swept + ".name" == key : key.starts_with(swept + ".");
  };
  const auto any_touches = [&](const std::map<std::string, TomlNode>& values) {
    return std::any_of(values.begin(), values.end(), [&](const auto& e) { return touches(e.first, e.second); });
  };
  return std::any_of(axes_.begin(), axes_.end(),
                     [&](const auto& e) { return touches(e.first, e.second.values.value(0)); }) ||
         any_touches(first_row_) ||
         std::any_of(cases_.begin(), cases_.end(), [&](const Case& c) { return any_touches(c.values); });
}

std::string Sweep::toml() const {
  std::string out;
  if (!axes_.empty() || design_.is_given) out += "\n[sweep]\n";
  if (design_.is_given) {
    TomlNode inline_design = design_.written;
    inline_design.is_inline = true;
    out += toml_line("design", inline_design);
  }
  for (const auto& [key, axis] : axes_) out += toml_line(key, axis.list);
  for (const auto& c : cases_) {
    out += "\n[[sweep.case]]\n" + toml_line("name", node_of(c.name));
    for (const auto& [key, value] : c.values) out += toml_line(key, value);
  }
  return out;
}

}  // namespace surveymc::config
