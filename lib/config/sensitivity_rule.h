#pragma once
/// [sensitivity] of a config: which quantity of a sweep the table `sensitivity` traces back to the sweep's keys.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/toml_tree.h"

namespace surveymc::config {

struct SensitivityRule {
  struct Quantity {
    std::string table, column;
  };
  std::vector<Quantity> quantities;                        ///< quantity = "TABLE.COLUMN", or a list of them
  std::vector<std::pair<std::string, std::string>> where;  ///< words that choose the row of a point: {column, word}
  bool of_logarithm = false;                               ///< scale = "log"
  double confidence = 0.95;                                ///< of all intervals of a quantity together
};

/// [sensitivity] of a parsed config. Throws InputError.
SensitivityRule sensitivity_rule(const TomlNode& sensitivity);
/// Of the text of a config; nothing if it has none.
std::optional<SensitivityRule> sensitivity_rule_of(const std::string& config, const std::string& label);

}  // namespace surveymc::config
