#pragma once
/// A run that ends when named rows of its comparison tables are decided: `[stop] verdict` (scenario.h: TrialPlan). Its
/// intervals are those of confidence sequences, so that any look may be the last. The moments of the trials between two
/// looks are kept in the tally: what every look saw can be told at the end, also of a run that went on from a
/// checkpoint.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "montecarlo/blocks.h"
#include "stats/tally.h"
#include "study/comparison.h"
#include "study/scenario.h"

namespace surveymc::study {

/// Rows of comparison tables, by name of the table.
using RowsOfTables = std::vector<std::pair<std::string, std::vector<ComparisonRow>>>;

class VerdictStop {
 public:
  /// Off where the plan names no row. `rows` makes the rows from the trials, moments and pairs of a tally, of which
  /// nothing else is set.
  VerdictStop(const TrialPlan& plan, const VerdictRule& rule, std::function<RowsOfTables(const stats::Tally&)> rows);

  bool is_on() const { return !decisive_.empty(); }
  /// Keeps trials, moments and pairs of a block for its look, in tally.groups. Does nothing if off.
  void keep(montecarlo::TrialBlock block, stats::Tally& tally) const;
  /// Trials that would decide all named rows; as many as there are where they are decided.
  std::uint64_t trials_needed(const stats::Tally& tally) const;
  /// Says of the named rows among `rows` of a table at which look the run ended, and where their figure of merit fell
  /// by more than 10 % since the first look, which is the sign of a heavy tail.
  void add_notes(const std::string& table, std::vector<ComparisonRow>& rows, const stats::Tally& tally) const;
  /// Table `looks`: the named rows at every look.
  store::Table looks_table(const stats::Tally& tally) const;

 private:
  struct NamedRow {
    std::string table;
    ComparisonRow row;
  };
  std::vector<NamedRow> named_rows(const stats::Tally& tally) const;
  bool is_named(const std::string& table, const ComparisonRow& row) const;
  /// Of the trials before look `look`.
  stats::Tally tally_at_look(const stats::Tally& tally, std::size_t look) const;
  /// 1 / (standard error^2 x trials): does not depend on the number of trials, but for heavy tails.
  double merit_of(const ComparisonRow& row, const stats::Tally& tally) const;

  std::vector<RowName> decisive_;
  std::vector<std::uint64_t> looks_;
  VerdictRule rule_;
  std::function<RowsOfTables(const stats::Tally&)> rows_;
};

}  // namespace surveymc::study
