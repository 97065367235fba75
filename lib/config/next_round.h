#pragma once
/// [refine] of a config, which says where a sweep gets more points after a round, and the config of the next round.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "config/toml_tree.h"

namespace surveymc::config {

/// Cells of a grid that a level of a quantity crosses, or where its verdict changes, get points at their midpoints.
struct RefineRule {
  std::string table, column;                               ///< quantity = "TABLE.COLUMN"
  std::vector<std::pair<std::string, std::string>> where;  ///< words that choose the row: {column, word}
  double level = 0;
  std::string verdict;            ///< if not empty, the boundary of where `column` has this word
  double cell = 0.01;             ///< size of a cell that is not divided any more, as a share of its axis
  std::vector<std::string> axes;  ///< sweep keys that are divided; empty: all numeric ones
  std::map<std::string, std::vector<double>> grid;  ///< values of the axes in the first round; of later rounds
  std::string place;                                ///< of [refine], for messages
};

/// [refine] of a parsed config. Throws InputError.
RefineRule refine_rule(const TomlNode& refine);
/// Of the text of a config; InputError if it has none.
RefineRule refine_rule_of(const std::string& config, const std::string& label);

/// The config without [sweep] and [refine].
std::string text_without_sweep(const std::string& config, const std::string& label);

/// The config with the points of `file` as its sweep, and with the axes of the first round in [refine], if it has that.
std::string text_with_points(const std::string& config, const std::string& label, const std::string& file,
                             const std::map<std::string, std::vector<double>>& grid);

}  // namespace surveymc::config
