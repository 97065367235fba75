#include "config/next_round.h"

#include <cmath>
#include <set>

#include <fmt/format.h>

#include "config/suggest.h"
#include "config/toml_tree.h"

namespace surveymc::config {
namespace {

const std::string& text_at(const TomlNode& n, const std::string& key) {
  if (!n.is_text()) refuse_kind(n, key, "must be a string");
  if (n.text.empty()) refuse(n, key, "must not be empty");
  return n.text;
}

double finite_at(const TomlNode& n, const std::string& key) {
  if (!n.is_number()) refuse_kind(n, key, "must be a number");
  return n.as_double();
}

}  // namespace

RefineRule refine_rule(const TomlNode& refine) {
  if (!refine.is_table()) refuse(refine, "refine", "must be a table: write [refine]");
  RefineRule rule;
  rule.place = refine.place;
  static const std::set<std::string> kKeys = {"refine.quantity", "refine.level", "refine.verdict", "refine.cell",
                                              "refine.axes",     "refine.where", "refine.grid"};
  for (const auto& [k, v] : refine.entries)
    if (!kKeys.contains("refine." + k))
      refuse(v.place, join_key("refine", key_text(k)), unknown_key_rule("refine", k, kKeys));
  const TomlNode *quantity = refine.entry("quantity"), *level = refine.entry("level"),
                 *verdict = refine.entry("verdict"), *cell = refine.entry("cell"), *axes = refine.entry("axes"),
                 *where = refine.entry("where"), *grid = refine.entry("grid");
  if (!quantity) refuse(refine.place, "refine.quantity", "missing");
  const std::string& name = text_at(*quantity, "refine.quantity");
  const auto dot = name.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == name.size())
    refuse(*quantity, "refine.quantity", "must be TABLE.COLUMN, such as summary.ratio_best");
  rule.table = name.substr(0, dot);
  rule.column = name.substr(dot + 1);
  if (!level == !verdict) refuse(refine.place, "refine.level", "give either level or verdict");
  if (level) rule.level = finite_at(*level, "refine.level");
  if (verdict) rule.verdict = text_at(*verdict, "refine.verdict");
  if (cell) {
    rule.cell = finite_at(*cell, "refine.cell");
    if (!(rule.cell > 0 && rule.cell < 1)) refuse(*cell, "refine.cell", "must be in (0, 1): a share of the axis");
  }
  if (axes) {
    if (!axes->is_array() || axes->items.empty()) refuse_kind(*axes, "refine.axes", "must be a list of sweep keys");
    for (const TomlNode& a : axes->items) rule.axes.push_back(text_at(a, "refine.axes"));
  }
  if (where) {
    if (!where->is_table()) refuse_kind(*where, "refine.where", "must be a table { column = \"word\" }");
    for (const auto& [k, v] : where->entries) rule.where.emplace_back(k, text_at(v, "refine.where." + k));
  }
  if (grid) {
    if (!grid->is_table()) refuse_kind(*grid, "refine.grid", "must be a table of lists");
    for (const auto& [k, v] : grid->entries) {
      const std::string shown = "refine.grid." + key_text(k);
      if (!v.is_array() || v.items.size() < 2) refuse_kind(v, shown, "must be a list of at least two numbers");
      std::vector<double>& values = rule.grid[k];
      for (const TomlNode& x : v.items) {
        values.push_back(finite_at(x, shown));
        if (values.size() > 1 && !(values.back() > values[values.size() - 2])) refuse(x, shown, "must rise");
      }
    }
  }
  return rule;
}

RefineRule refine_rule_of(const std::string& config, const std::string& label) {
  const TomlNode root = parse_document(config, label);
  const TomlNode* refine = root.entry("refine");
  if (!refine) refuse(label, "refine", "missing table [refine], which names the boundary to follow");
  return refine_rule(*refine);
}

std::string text_without_sweep(const std::string& config, const std::string& label) {
  TomlNode root = parse_document(config, label);
  root.entries.erase("sweep");
  root.entries.erase("refine");
  root.entries.erase("sensitivity");
  return toml_document(root);
}

std::string text_with_points(const std::string& config, const std::string& label, const std::string& file,
                             const std::map<std::string, std::vector<double>>& grid) {
  TomlNode root = parse_document(config, label);
  TomlNode design;
  design.is_inline = true;
  design.entries["kind"] = node_of(std::string("table"));
  design.entries["file"] = node_of(file);
  root.entries.erase("sweep");
  root.entries.erase("sensitivity");  // the keys of a table are not independent
  if (const auto refine = root.entries.find("refine"); refine != root.entries.end() && !grid.empty()) {
    TomlNode lists;
    for (const auto& [key, values] : grid) lists.entries[key] = node_of(values);
    refine->second.entries["grid"] = lists;
  }
  return toml_document(root) + fmt::format("\n[sweep]\n{}", toml_line("design", design));
}

}  // namespace surveymc::config
