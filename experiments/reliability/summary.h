#pragma once
/// Summary of a reliability map in a few rows: extremes, medians, infinities, and the comparison with published
/// statements.
#include <functional>
#include <string>
#include <vector>

#include "config/config.h"
#include "montecarlo/run_blocks.h"
#include "reliability/layers.h"
#include "store/table.h"

namespace surveymc::studies::reliability {

/// Values first .. first + count - 1 of the layers of one subject, counted from 0: [layer][point].
using LayerSource =
    std::function<std::vector<std::vector<double>>(std::size_t subject, std::size_t first, std::size_t count)>;

/// Table `summary`: a row per subject and layer with the smallest, median and largest finite size |x| over all
/// points, where the extremes are, and how many points are infinite. `exact`: medians exactly, from all values at once;
/// otherwise to 1e-6, from one or two passes. `source` is asked for pieces by the threads of `options`; the table does
/// not depend on them. Throws Interrupted.
store::Table summary_table(const ReliabilityGrid& grid, const std::vector<ErrorSubject>& subjects,
                           const std::vector<std::string>& layers, const LayerSource& source, bool exact,
                           const montecarlo::RunOptions& options);

/// A statement of a publication about a map; `[[statement]]` of a config.
struct Statement {
  std::string text, quantity, statistic, crosses, expected;
  std::size_t subject = 0;
  std::vector<std::pair<std::string, double>> where, relative_to;  ///< parts of the grid: "inclination_deg" = 30
  double level = 0, published = 0, tolerance = 0;
};

/// `[[statement]] text, observation, quantity, statistic, published, tolerance (0.02), where, relative_to, level,
/// crosses, expected, at`. statistic: "minimum", "maximum", "median", "infinite_points" of |x| over the part of the
/// grid that `where` names; "largest_ratio": of |x| where over relative_to, point by point; "crossing": the inclination
/// at which |x| passes `level`, or the size in the map that `crosses` names, by linear interpolation. With relative_to
/// the others are divided by their value there.
std::vector<Statement> read_statements(config::ConfigReader& config, const ReliabilityGrid& grid,
                                       const std::vector<ErrorSubject>& subjects,
                                       const std::vector<std::string>& layers);

/// Table `statements`: found, published, ratio and verdict: "agrees" within the tolerance, else "differs".
store::Table statements_table(const ReliabilityGrid& grid, const std::vector<ErrorSubject>& subjects,
                              const std::vector<std::string>& layers, const std::vector<Statement>& statements,
                              const LayerSource& source);

}  // namespace surveymc::studies::reliability
