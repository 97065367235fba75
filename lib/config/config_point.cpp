#include "config/config_point.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/suggest.h"
#include "config/text.h"

namespace surveymc::config {

bool ConfigReader::Point::asked_below(const std::string& key) const {
  for (const std::string& head : {key + ".", key + "["}) {
    const auto it = asked.lower_bound(head);
    if (it != asked.end() && it->starts_with(head)) return true;
  }
  return false;
}

// ------------------------------------------------------------------------------------------------------------ values

ConfigValue ConfigReader::Point::look_up(const TomlNode& table, const std::string& path, const std::string& key) const {
  if (key.find('.') == std::string::npos) {
    const TomlNode* found = table.entry(key);
    return found ? ConfigValue{found, join_key(path, key)} : ConfigValue{};
  }
  const auto parts = split_key(key);
  const TomlNode* at = &table;
  std::string full = path;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const TomlNode* next = at->entry(parts[i]);
    if (!next) return {};
    full = join_key(full, parts[i]);
    const std::size_t parts_left = parts.size() - 1 - i;
    if (parts_left == 0) return {next, full};
    if (next->is_text() && parts_left == 1 && parts.back() == "name") {
      if (path.empty()) {
        const std::scoped_lock lock(doc->showing);
        doc->named.insert(full);
      }
      return {next, full};
    }
    if (!next->is_table()) return {next, full, true};
    at = next;
  }
  return {};
}

// ----------------------------------------------------------------------------------------------------- matches_point

bool ConfigReader::Point::has_values(const std::string& where, const TomlNode& expected,
                                     const std::string& name) const {
  bool all = true;
  for (const auto& [k, v] : expected.entries) {
    const std::string key = join_key(name, k);
    const bool one = v.is_table() ? has_values(where, v, key) : has_value(where, key, v);
    all = all && one;  // every entry is checked, also behind one that differs
  }
  return all;
}

const TomlNode* ConfigReader::Point::value_or_default(const std::string& key) const {
  if (const ConfigValue found = look_up(root, "", key)) return found.node;
  const auto it = defaults.find(key);
  return it == defaults.end() ? nullptr : &it->second;
}

bool ConfigReader::Point::has_value(const std::string& where, const std::string& name, const TomlNode& expected) const {
  const auto equals = [&](const TomlNode& n) {
    if (n.is_number() && expected.is_number()) return n.as_double() == expected.as_double();
    return n.kind == expected.kind && plain_text(n) == plain_text(expected);
  };
  const Sweep& sweep = doc->sweep;
  const auto clean = clean_key(name);
  if (clean == "case" && sweep.has_cases()) {
    if (!expected.is_text()) refuse_kind(expected, where + ".case", "must be a string");
    return expected.text == sweep.case_name(index);
  }
  if (clean) {
    const TomlNode* value = value_or_default(*clean);
    if (expected.is_text() && (!value || value->is_table())) {
      if (const TomlNode* its_name = value_or_default(*clean + ".name")) value = its_name;
    }
    if (value) return equals(*value);
    if (sweep.varies(*clean)) return false;  // another case has it
  }
  std::set<std::string> known = asked;
  if (sweep.has_cases()) known.insert("case");
  const auto dot = name.rfind('.');
  const std::string at_key = dot == std::string::npos ? "" : name.substr(0, dot);
  refuse(expected.place, fmt::format("{}: {}", where, name), unknown_key_rule(at_key, name.substr(dot + 1), known));
}

// ------------------------------------------------------------------------------------------------------ unknown keys

void ConfigReader::Point::find_unknown(const TomlNode& at, const std::string& at_key,
                                       std::vector<UnknownKey>& out) const {
  for (const auto& [k, v] : at.entries) {
    const std::string full = join_key(at_key, k);
    if (at_key.empty() && is_config_key(k)) continue;
    if (!is_bare_key(k)) {
      const auto clean = clean_key(k);
      const bool is_known = clean && asked.contains(join_key(at_key, *clean));
      out.push_back({&v, join_key(at_key, in_quotes(k)),
                     is_known ? fmt::format("unknown key: write {} without quotes", *clean) : "unknown key"});
      continue;
    }
    const bool is_asked = asked.contains(full), is_asked_below = !is_asked && asked_below(full);
    if (whole.contains(full)) continue;
    if (v.is_table() && (is_asked || is_asked_below)) {
      find_unknown(v, full, out);
    } else if (arrays.contains(full)) {
      for (std::size_t i = 0; i < v.items.size(); ++i) {
        const std::string element = fmt::format("{}[{}]", full, i);
        if (!is_for_other_point(element)) find_unknown(v.items[i], element, out);
      }
    } else if (is_asked || (v.is_text() && asked.contains(full + ".name"))) {
      continue;
    } else if (is_asked_below) {
      out.push_back({&v, fmt::format("{} = {}", full, shortened(plain_text(v))),
                     fmt::format("must be a table: write [{}]", full)});
    } else {
      std::set<std::string> known = asked;
      known.insert({"experiment", "seed", "title", "trials", "sweep"});  // keys that any file may have
      out.push_back({&v, full, unknown_key_rule(at_key, k, known)});
    }
  }
}

/// An element of an array of tables that a reader left at once, because matches_point() was false.
bool ConfigReader::Point::is_for_other_point(const std::string& element) const {
  const auto it = unmatched.find(element);
  if (it == unmatched.end()) return false;
  const std::string head = element + ".";
  const auto first = asked.lower_bound(head);  // `at` is the only key of the element that was asked for
  return first != asked.end() && *first == it->second &&
         (std::next(first) == asked.end() || !std::next(first)->starts_with(head));
}

}  // namespace surveymc::config
