#include "config/sensitivity_rule.h"

#include <set>

#include "config/suggest.h"
#include "config/toml_tree.h"

namespace surveymc::config {
namespace {

SensitivityRule::Quantity quantity_at(const TomlNode& n) {
  if (!n.is_text()) refuse_kind(n, "sensitivity.quantity", "must be TABLE.COLUMN, or a list of them");
  const auto dot = n.text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == n.text.size())
    refuse(n, "sensitivity.quantity", "must be TABLE.COLUMN, such as covariance.semi_major_m");
  return {n.text.substr(0, dot), n.text.substr(dot + 1)};
}

}  // namespace

SensitivityRule sensitivity_rule(const TomlNode& sensitivity) {
  if (!sensitivity.is_table()) refuse(sensitivity, "sensitivity", "must be a table: write [sensitivity]");
  SensitivityRule rule;
  static const std::set<std::string> kKeys = {"sensitivity.quantity", "sensitivity.where", "sensitivity.scale",
                                              "sensitivity.confidence"};
  for (const auto& [k, v] : sensitivity.entries)
    if (!kKeys.contains("sensitivity." + k))
      refuse(v.place, join_key("sensitivity", key_text(k)), unknown_key_rule("sensitivity", k, kKeys));
  const TomlNode *quantity = sensitivity.entry("quantity"), *where = sensitivity.entry("where"),
                 *scale = sensitivity.entry("scale"), *confidence = sensitivity.entry("confidence");
  if (!quantity) refuse(sensitivity.place, "sensitivity.quantity", "missing");
  if (quantity->is_array()) {
    for (const TomlNode& n : quantity->items) rule.quantities.push_back(quantity_at(n));
    if (rule.quantities.empty()) refuse(*quantity, "sensitivity.quantity", "must not be empty");
  } else {
    rule.quantities.push_back(quantity_at(*quantity));
  }
  if (where) {
    if (!where->is_table()) refuse_kind(*where, "sensitivity.where", "must be a table { column = \"word\" }");
    for (const auto& [k, v] : where->entries) {
      if (!v.is_text()) refuse_kind(v, "sensitivity.where." + k, "must be a string");
      rule.where.emplace_back(k, v.text);
    }
  }
  if (scale) {
    if (!scale->is_text() || (scale->text != "linear" && scale->text != "log"))
      refuse(*scale, "sensitivity.scale", "must be \"linear\" or \"log\"");
    rule.of_logarithm = scale->text == "log";
  }
  if (confidence) {
    if (!confidence->is_number()) refuse_kind(*confidence, "sensitivity.confidence", "must be a number");
    rule.confidence = confidence->as_double();
    if (!(rule.confidence > 0 && rule.confidence < 1))
      refuse(*confidence, "sensitivity.confidence", "must be in (0, 1)");
  }
  return rule;
}

std::optional<SensitivityRule> sensitivity_rule_of(const std::string& config, const std::string& label) {
  if (config.find("sensitivity") == std::string::npos) return std::nullopt;
  const TomlNode root = parse_document(config, label);
  const TomlNode* sensitivity = root.entry("sensitivity");
  return sensitivity ? std::optional(sensitivity_rule(*sensitivity)) : std::nullopt;
}

}  // namespace surveymc::config
