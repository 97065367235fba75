#include "sweep/config_schema.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/json.h"
#include "sweep/config_keys.h"

namespace surveymc::sweep {
namespace {

using render::json_string;
using Members = std::vector<std::pair<std::string, std::string>>;  // names, and values as JSON

std::string object(const Members& members, const char* between = ", ") {
  std::string out;
  for (const auto& [name, value] : members)
    out += fmt::format("{}{}: {}", out.empty() ? "" : between, json_string(name), value);
  return "{" + out + "}";
}

std::string list(const std::vector<std::string>& items) { return fmt::format("[{}]", fmt::join(items, ", ")); }

std::string of_type(const char* type) { return object({{"type", json_string(type)}}); }

/// What any of these allows.
std::string any_of(std::vector<std::string> schemas) {
  std::sort(schemas.begin(), schemas.end());
  schemas.erase(std::unique(schemas.begin(), schemas.end()), schemas.end());
  return schemas.size() == 1 ? schemas.front() : object({{"anyOf", list(schemas)}});
}

std::string array_of(const std::string& items, int least = 1, int most = -1) {
  Members members{{"type", "\"array\""}, {"items", items}};
  if (least > 0) members.emplace_back("minItems", std::to_string(least));
  if (most >= 0) members.emplace_back("maxItems", std::to_string(most));
  return object(members);
}

/// A table: its keys, and no others.
std::string table_of(const Members& properties, const std::vector<std::string>& required = {}) {
  Members members{{"type", "\"object\""}, {"properties", object(properties)}, {"additionalProperties", "false"}};
  if (!required.empty()) members.emplace_back("required", list(required));
  return object(members);
}

/// An end that differs between the branches of a study, or between examples, depends on other keys: it is none here.
config::Range common_range(const std::vector<config::Range>& ranges) {
  if (ranges.empty()) return {};
  config::Range out = ranges.front();
  for (const config::Range& r : ranges) {
    if (r.lo != out.lo || r.lo_open != out.lo_open) out.lo = -kInfinity;
    if (r.hi != out.hi || r.hi_open != out.hi_open) out.hi = kInfinity;
  }
  return out;
}

std::string number_of(const char* type, const config::Range& range) {
  Members members{{"type", json_string(type)}};
  if (range.lo > -kInfinity)
    members.emplace_back(range.lo_open ? "exclusiveMinimum" : "minimum", render::json_number(range.lo));
  if (range.hi < kInfinity)
    members.emplace_back(range.hi_open ? "exclusiveMaximum" : "maximum", render::json_number(range.hi));
  return object(members);
}

std::string word_of(const config::KeyUse& use) {
  if (use.choices.empty() || use.has_other_words) return of_type("string");
  std::vector<std::string> words;
  for (const std::string& word : use.choices) {
    words.push_back(json_string(word));
    if (word == "true" || word == "false") words.push_back(word);  // may stand without quotes
  }
  return object({{"enum", list(words)}});
}

/// { from, to, step }, { from, to, count, scale }, { from, to, scale }.
std::string range_table() {
  const std::string number = of_type("number");
  return table_of({{"from", number},
                   {"to", number},
                   {"step", number},
                   {"count", number_of("integer", {1, kInfinity})},
                   {"scale", object({{"enum", R"(["linear", "log"])"}})}},
                  {"\"from\"", "\"to\""});
}

/// The values that a getter takes which asks for this type; `tables`: of the tables in a list.
std::vector<std::string> values_of(const std::string& type, const config::KeyUse& use, const std::string& tables) {
  const std::string number = number_of("number", common_range(use.ranges)), word = word_of(use);
  int count = 0;
  if (type == "number") return {number};
  if (type == "integer") return {number_of("integer", common_range(use.ranges))};
  if (type == "true or false") return {of_type("boolean")};
  if (type == "text" || type.ends_with("file")) return {word};
  if (type == "date")
    return {of_type("number"), object({{"type", "\"string\""}, {"pattern", R"("^\\d{4}-\\d\\d-\\d\\d$")"}})};
  if (type == "list of numbers") return {array_of(number)};
  if (type == "number or list") return {number, array_of(number)};
  if (type == "number, list or { from, to, step }") return {number, array_of(number), range_table()};
  if (type == "list of texts") return {array_of(word)};
  if (type == "text or list of texts") return {word, array_of(word)};
  if (type == "table of numbers") return {object({{"type", "\"object\""}, {"additionalProperties", number}})};
  if (type == "table of keys") return {of_type("object")};
  if (type == "array of tables") return {array_of(tables, 0)};
  if (type == "list of texts or tables") return {array_of(any_of({word, tables}))};
  if (std::sscanf(type.c_str(), "list of %d number", &count) == 1) return {array_of(number, count, count)};
  throw std::logic_error("config_schema: no schema of type " + type);
}

/// A table of keys, or a key, by its name.
struct Node {
  const ListedKey* key = nullptr;
  bool is_array = false;  ///< of tables, which `inside` are alike
  std::map<std::string, Node> inside = {};
};

void add(Node& root, const ListedKey& key) {
  Node* at = &root;
  for (std::size_t begin = 0; begin < key.key.size();) {
    const std::size_t end = std::min(key.key.find('.', begin), key.key.size());
    std::string name = key.key.substr(begin, end - begin);
    const bool is_array = name.ends_with("[]");
    if (is_array) name.resize(name.size() - 2);
    at = &at->inside[name];
    at->is_array = at->is_array || is_array;
    begin = end + 1;
  }
  at->key = &key;
}

bool is_json(const std::string& toml) {
  return toml == "true" || toml == "false" ||
         (!toml.empty() && toml.find_first_of("{'") == std::string::npos && toml.find("\\U") == std::string::npos);
}

class Schema {
 public:
  explicit Schema(const study::Experiment& experiment) : experiment_(experiment), keys_(listed_keys(experiment)) {
    for (const ListedKey& key : keys_)
      if (!key.key.starts_with("sweep.")) add(root_, key);
  }

  std::string text() {
    root_.inside.at("experiment").inside.clear();
    Members properties = properties_of(root_, "");
    for (auto& [name, value] : properties)
      if (name == "experiment")
        value = object({{"const", json_string(experiment_.name())}, {"description", "\"name of the study\""}});
    properties.emplace_back("sweep", sweep());
    // What a sweep or its cases give need not stand elsewhere.
    const std::string needed = required_of(root_);
    Members members{{"$schema", "\"https://json-schema.org/draft/2020-12/schema\""},
                    {"title", json_string("config of surveymc: " + experiment_.name())},
                    {"description", json_string(experiment_.summary)},
                    {"type", "\"object\""},
                    {"required", "[\"experiment\"]"},
                    {"properties", object(properties, ",\n  ")},
                    {"additionalProperties", "false"}};
    if (!needed.empty()) {
      members.emplace_back("if", R"({"not": {"required": ["sweep"]}})");
      members.emplace_back("then", needed);
    }
    members.emplace_back("$defs", object(definitions_, ",\n  "));
    return object(members, ",\n ") + "\n";
  }

 private:
  /// A reference to the schema of a key or table, which is defined once: it stands in the file, in cases and in sweeps.
  std::string reference(const Node& node, const std::string& path) {
    if (defined_.insert(path).second) {
      const std::string schema = schema_of(node, path);
      definitions_.emplace_back(path, schema);
    }
    return object({{"$ref", json_string("#/$defs/" + path)}});
  }

  Members properties_of(const Node& table, const std::string& path) {
    Members out;
    for (const auto& [name, node] : table.inside)
      out.emplace_back(name, reference(node, path.empty() ? name : path + "." + name));
    return out;
  }

  std::string schema_of(const Node& node, const std::string& path) {
    static const config::KeyUse kNothing{};
    const config::KeyUse& use = node.key ? node.key->use : kNothing;
    std::vector<std::string> allowed;
    const std::string inside =
        node.inside.empty() ? of_type("object") : table_of(properties_of(node, path), required_in(node));
    for (const std::string& type : use.types) {
      const std::vector<std::string> more = values_of(type, use, inside);
      allowed.insert(allowed.end(), more.begin(), more.end());
    }
    if (!node.inside.empty() && node.is_array && use.types.empty()) allowed.push_back(array_of(inside, 0));
    if (!node.inside.empty() && !node.is_array) allowed.push_back(inside);
    // estimator = "msa" is estimator.name = "msa".
    if (const auto name = node.inside.find("name"); name != node.inside.end() && !node.is_array)
      allowed.push_back(reference(name->second, path + ".name"));
    const std::string schema = any_of(allowed);
    const std::string said = node.key ? description(*node.key) : "";
    if (said.empty()) return schema;
    std::string out = schema.substr(0, schema.size() - 1) + ", \"description\": " + json_string(said);
    const std::vector<std::string>& defaults = use.defaults;
    if (defaults.size() == 1 && is_json(defaults.front()) && !use.is_needed)
      out += ", \"default\": " + defaults.front();
    return out + "}";
  }

  static std::string description(const ListedKey& key) {
    std::string out = fmt::format("{}", fmt::join(key.use.meanings, "; or "));
    const std::string unit = config::unit_of_key(key.key);
    if (!unit.empty()) out += fmt::format("{}in {}", out.empty() ? "" : "; ", unit);
    if (!key.use.rules.empty()) out += fmt::format(" ({})", fmt::join(key.use.rules, "; or "));
    return out;
  }

  /// Keys that every table of an array must have.
  static std::vector<std::string> required_in(const Node& table) {
    std::vector<std::string> out;
    if (!table.is_array) return out;
    for (const auto& [name, node] : table.inside)
      if (node.key && node.key->is_required) out.push_back(json_string(name));
    return out;
  }

  /// The keys that any config must have, and the tables that hold them; "" if there are none. A table may be a name.
  static std::string required_of(const Node& table) {
    std::vector<std::string> names;
    Members inside;
    for (const auto& [name, node] : table.inside) {
      const std::string more = node.is_array ? "" : required_of(node);
      const bool is_needed = node.key && node.key->is_required;
      if (is_needed || !more.empty()) names.push_back(json_string(name));
      if (!more.empty()) inside.emplace_back(name, more);
    }
    if (names.empty()) return "";
    Members members{{"required", list(names)}};  // of a value that is no table, JSON Schema asks nothing
    if (!inside.empty()) members.emplace_back("properties", object(inside));
    return object(members);
  }

  /// Tables and keys below `table` that a sweep may name with dots, in quotes.
  void dotted(const Node& table, const std::string& path, std::vector<std::pair<std::string, const Node*>>& out) const {
    for (const auto& [name, node] : table.inside) {
      const std::string full = path.empty() ? name : path + "." + name;
      if (!path.empty()) out.emplace_back(full, &node);
      if (!node.is_array) dotted(node, full, out);
    }
  }

  static bool is_fixed(const std::string& path) {
    static const std::set<std::string> kFixed{"experiment", "seed",        "title",         "trials",
                                              "refine",     "sensitivity", "verdict.family"};
    return kFixed.contains(path);
  }

  /// Lists of the values of a key; of a table, the same of its keys, or names.
  std::string swept(const Node& node, const std::string& path) {
    std::vector<std::string> allowed;
    if (node.key || node.inside.contains("name")) {
      allowed.push_back(array_of(reference(node, path)));
      allowed.push_back("{\"$ref\": \"#/$defs/values_from_to\"}");
    }
    if (path == "error_model" || path == "error_model.name") {
      const std::string pattern = any_of({of_type("string"), array_of(of_type("string"))});
      allowed.push_back(table_of({{"match", pattern}, {"without", pattern}}, {"\"match\""}));
    }
    if (!node.inside.empty() && !node.is_array) allowed.push_back(table_of(swept_inside(node, path)));
    return any_of(allowed);
  }

  Members swept_inside(const Node& table, const std::string& path) {
    Members out;
    for (const auto& [name, node] : table.inside) {
      const std::string full = path.empty() ? name : path + "." + name;
      if (!node.is_array && !is_fixed(full)) out.emplace_back(name, swept(node, full));
    }
    return out;
  }

  std::string sweep() {
    definitions_.emplace_back("values_from_to", range_table());
    std::vector<std::pair<std::string, const Node*>> below;
    dotted(root_, "", below);
    Members lists = swept_inside(root_, "");
    Members cases{{"name", object({{"type", "\"string\""}, {"minLength", "1"}})}};
    for (const auto& [name, node] : root_.inside)
      if (!is_fixed(name)) cases.emplace_back(name, reference(node, name));
    for (const auto& [path, node] : below) {
      if (is_fixed(path)) continue;
      if (!node->is_array) lists.emplace_back(path, swept(*node, path));
      cases.emplace_back(path, reference(*node, path));
    }
    lists.emplace_back("design", design());
    lists.emplace_back("case", array_of(table_of(cases, {"\"name\""})));
    std::string out = table_of(lists);
    return out.substr(0, out.size() - 1) +
           ", \"description\": \"keys and their values: a point of the sweep for each combination, or what design "
           "says\"}";
  }

  static std::string design() {
    const auto kind = [](const char* words) { return object({{"enum", words}}); };
    const std::string points = number_of("integer", {1, kInfinity}), seed = number_of("integer", {0, kInfinity});
    return any_of({kind(R"(["product", "zip"])"), table_of({{"kind", kind(R"(["product", "zip"])")}}, {"\"kind\""}),
                   table_of({{"kind", kind(R"(["latin_hypercube", "sobol"])")}, {"points", points}, {"seed", seed}},
                            {"\"kind\"", "\"points\"", "\"seed\""}),
                   table_of({{"kind", kind(R"(["table"])")}, {"file", of_type("string")}}, {"\"kind\"", "\"file\""})});
  }

  const study::Experiment& experiment_;
  std::vector<ListedKey> keys_;
  Node root_;
  Members definitions_;
  std::set<std::string> defined_;
};

}  // namespace

std::string config_schema(const study::Experiment& experiment) { return Schema(experiment).text(); }

}  // namespace surveymc::sweep
