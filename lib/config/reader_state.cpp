#include "config/reader_state.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/suggest.h"
#include "config/text.h"

namespace surveymc::config {

bool ConfigPoint::asked_below(const std::string& key) const {
  for (const std::string& head : {key + ".", key + "["}) {
    const auto it = asked.lower_bound(head);
    if (it != asked.end() && it->starts_with(head)) return true;
  }
  return false;
}

// ------------------------------------------------------------------------------------------------------------ values

ConfigReader::State::Found ConfigReader::State::look_up(const std::string& key) const {
  if (key.find('.') == std::string::npos) {
    const TomlNode* found = table->entry(key);
    return found ? Found{found, join_key(path, key)} : Found{};
  }
  const auto parts = split_key(key);
  const TomlNode* at = table;
  std::string full = path;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const TomlNode* next = at->entry(parts[i]);
    if (!next) return {};
    full = join_key(full, parts[i]);
    const std::size_t parts_left = parts.size() - 1 - i;
    if (parts_left == 0) return {next, full};
    if (next->is_text() && parts_left == 1 && parts.back() == "name") {
      if (path.empty()) point->doc->named.insert(full);
      return {next, full};
    }
    if (!next->is_table()) return {nullptr, full, next};
    at = next;
  }
  return {};
}

ConfigReader::State::Found ConfigReader::State::find(const std::string& key) {
  point->asked.insert(full_key(key));
  const Found found = look_up(key);
  if (found.not_a_table && !found.not_a_table->is_text()) {
    refuse(*found.not_a_table, found.key, fmt::format("must be a table: write [{}]", found.key));
  }
  return found;
}

ConfigReader::State::Found ConfigReader::State::need(const std::string& key) {
  const Found found = find(key);
  if (!found) refuse_missing(key);
  return found;
}

ConfigReader::State::Found ConfigReader::State::its_name(const Found& found) {
  const Found name = name_or_self(found);
  if (name) point->asked.insert(name.key);
  return name;
}

ConfigReader::State::Found ConfigReader::State::name_or_self(const Found& found) {
  const TomlNode* name = found && found.node->is_table() ? found.node->entry("name") : nullptr;
  return name ? Found{name, found.key + ".name"} : found;
}

/// Mentions the first key of the table that looks as if it was meant.
void ConfigReader::State::refuse_missing(const std::string& key) const {
  const std::string full = full_key(key);
  if (KeyLog* log = point->doc->log.get()) log->missing = full;
  const auto parts = split_key(key);
  const TomlNode* at = table;
  std::string at_key = path;
  std::size_t i = 0;
  while (const TomlNode* next = at->entry(parts[i])) {  // ends at the part that is missing
    at_key = join_key(at_key, parts[i++]);
    if (!next->is_table()) refuse(next->place, full, fmt::format("missing ({} is only a name)", at_key));
    at = next;
  }
  const bool is_last = i + 1 == parts.size();
  for (const auto& [k, v] : at->entries) {
    const std::string other = join_key(at_key, k);
    if (point->asked.contains(other) || point->asked_below(other) || is_config_key(other)) continue;
    if (const UnitFault fault = unit_fault(k, parts[i]); is_last && fault != UnitFault::none) {
      refuse(v.place, full, fmt::format("missing (found {}: {})", other, describe(fault)));
    }
    if (resembles(k, parts[i])) refuse(v.place, full, fmt::format("missing (found {})", other));
  }
  refuse(place(), full, "missing");
}

// -------------------------------------------------------------------------------------------------------------- the
// log

namespace {

void add(std::vector<std::string>& list, const std::string& word) {
  if (std::find(list.begin(), list.end(), word) == list.end()) list.push_back(word);
}

}  // namespace

void ConfigReader::State::log_use(const std::string& key, const std::string& type, const std::string& rule,
                                  const std::string& sample) const {
  KeyLog* log = point->doc->log.get();
  if (!log) return;
  const std::string full = full_key(key);
  log->asked.insert(full);
  KeyUse& use = log->use(full);
  if (log->with_default != full) {
    log->with_default = "";
    use.is_needed = true;
  }
  add(use.types, type);
  if (!rule.empty()) add(use.rules, rule.starts_with("must be ") ? rule.substr(8) : rule);
  if (use.sample.empty()) use.sample = sample;
  const Found found = name_or_self(look_up(key));
  if (found && use.example.empty() && !found.node->is_tables() && !log->supposed.contains(full))
    use.example = toml_text(*found.node);
}

void ConfigReader::State::log_choices(const std::string& key, const std::vector<std::string>& allowed) const {
  KeyLog* log = point->doc->log.get();
  if (!log) return;
  log_use(key, "text");
  for (const std::string& word : allowed) add(log->use(full_key(key)).choices, word);
}

void ConfigReader::State::log_default(const std::string& key, const TomlNode& value, bool is_value) const {
  KeyLog* log = point->doc->log.get();
  if (!log) return;
  log->with_default = full_key(key);
  add(log->use(log->with_default).defaults, is_value ? toml_text(value) : "");
}

void ConfigReader::State::use_default(const std::string& key, const TomlNode& value, bool is_value) {
  if (!is_value) return;
  point->defaults[full_key(key)] = value;
  point->doc->use_default(full_key(key), value, point->index);
}

// ----------------------------------------------------------------------------------------------------- matches_point

bool ConfigReader::State::entries_match(const std::string& where, const TomlNode& expected,
                                        const std::string& name) const {
  bool all = true;
  for (const auto& [k, v] : expected.entries) {
    const std::string key = join_key(name, k);
    const bool one = v.is_table() ? entries_match(where, v, key) : entry_matches(where, key, v);
    all = all && one;  // every entry is checked, also behind one that differs
  }
  return all;
}

const TomlNode* ConfigReader::State::value_or_default(const std::string& key) const {
  if (const Found found = State{point, &point->root, ""}.look_up(key)) return found.node;
  const auto it = point->defaults.find(key);
  return it == point->defaults.end() ? nullptr : &it->second;
}

bool ConfigReader::State::entry_matches(const std::string& where, const std::string& name,
                                        const TomlNode& expected) const {
  const auto equals = [&](const TomlNode& n) {
    if (n.is_number() && expected.is_number()) return n.as_double() == expected.as_double();
    return n.kind == expected.kind && plain_text(n) == plain_text(expected);
  };
  const Sweep& sweep = point->doc->sweep;
  const auto clean = clean_key(name);
  if (clean == "case" && sweep.has_cases()) {
    if (!expected.is_text()) refuse_kind(expected, where + ".case", "must be a string");
    return expected.text == sweep.case_name(point->index);
  }
  if (clean) {
    const TomlNode* value = value_or_default(*clean);
    if (expected.is_text() && (!value || value->is_table())) {
      if (const TomlNode* its_name = value_or_default(*clean + ".name")) value = its_name;
    }
    if (value) return equals(*value);
    if (sweep.varies(*clean)) return false;  // another case has it
  }
  std::set<std::string> known = point->asked;
  if (sweep.has_cases()) known.insert("case");
  const auto dot = name.rfind('.');
  const std::string at_key = dot == std::string::npos ? "" : name.substr(0, dot);
  refuse(expected.place, fmt::format("{}: {}", where, name), unknown_key_rule(at_key, name.substr(dot + 1), known));
}

// ------------------------------------------------------------------------------------------------------ unknown keys

void ConfigReader::State::find_unknown(const TomlNode& at, const std::string& at_key,
                                       std::vector<UnknownKey>& out) const {
  for (const auto& [k, v] : at.entries) {
    const std::string full = join_key(at_key, k);
    if (at_key.empty() && is_config_key(k)) continue;
    if (!is_bare_key(k)) {
      const auto clean = clean_key(k);
      const bool is_known = clean && point->asked.contains(join_key(at_key, *clean));
      out.push_back({&v, join_key(at_key, in_quotes(k)),
                     is_known ? fmt::format("unknown key: write {} without quotes", *clean) : "unknown key"});
      continue;
    }
    const bool is_asked = point->asked.contains(full), is_asked_below = !is_asked && point->asked_below(full);
    if (point->whole.contains(full)) continue;
    if (v.is_table() && (is_asked || is_asked_below)) {
      find_unknown(v, full, out);
    } else if (point->arrays.contains(full)) {
      for (std::size_t i = 0; i < v.items.size(); ++i) {
        const std::string element = fmt::format("{}[{}]", full, i);
        if (!is_for_other_point(element)) find_unknown(v.items[i], element, out);
      }
    } else if (is_asked || (v.is_text() && point->asked.contains(full + ".name"))) {
      continue;
    } else if (is_asked_below) {
      out.push_back({&v, fmt::format("{} = {}", full, shortened(plain_text(v))),
                     fmt::format("must be a table: write [{}]", full)});
    } else {
      std::set<std::string> known = point->asked;
      known.insert({"experiment", "seed", "title", "trials", "sweep"});  // keys that any file may have
      out.push_back({&v, full, unknown_key_rule(at_key, k, known)});
    }
  }
}

/// An element of an array of tables that a reader left at once, because matches_point() was false.
bool ConfigReader::State::is_for_other_point(const std::string& element) const {
  const auto it = point->unmatched.find(element);
  if (it == point->unmatched.end()) return false;
  const std::string head = element + ".";
  const auto first = point->asked.lower_bound(head);  // `at` is the only key of the element that was asked for
  return first != point->asked.end() && *first == it->second &&
         (std::next(first) == point->asked.end() || !std::next(first)->starts_with(head));
}

}  // namespace surveymc::config
