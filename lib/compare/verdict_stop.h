#pragma once
/// A run that ends when named rows of its comparison tables are decided: `[stop] verdict` (trial_plan.h: TrialPlan).
/// Its intervals are those of confidence sequences, so that any look may be the last. The moments of the trials between
/// two looks are kept in the tally: what every look saw can be told at the end, also of a run that went on from a
/// checkpoint.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "compare/comparison.h"
#include "compare/trial_plan.h"
#include "montecarlo/blocks.h"
#include "stats/tally.h"

namespace surveymc::compare {

/// Allowed values of `trials`; `stop.max_trials` is at least 4096.
struct TrialLimits {
  std::int64_t fewest = 2, most = 1'000'000'000'000;
};

/// read_trial_plan() of a study whose runs end by verdicts alone.
TrialPlan read_verdict_plan(config::ConfigReader& config, const std::vector<Row>& rows, VerdictRule& verdict,
                            const TrialLimits& limits);

/// Rows of a comparison table. `place` tells rows of one name apart: "420 m"; "" where a table has each name once.
struct RowsOfTable {
  std::string table;
  std::vector<ComparisonRow> rows;
  std::string place = {};
};
using RowsOfTables = std::vector<RowsOfTable>;

/// Parts of a tally, besides moments and pairs, that a study makes its rows from: the first so many of each list.
struct KeptParts {
  std::size_t own_groups = 0;  ///< groups that the study's tallies have; those of the looks come behind
  std::size_t groups = 0, controlled = 0, controlled_pairs = 0, counts = 0;
  bool failed = false;  ///< and the numbers of failed and of left out trials
};

class VerdictStop {
 public:
  /// Off where the plan names no row. `rows` makes the rows from the trials, moments, pairs and `kept` parts of a
  /// tally, of which nothing else is set.
  VerdictStop(const TrialPlan& plan, const VerdictRule& rule, std::function<RowsOfTables(const stats::Tally&)> rows,
              const KeptParts& kept = {});

  bool is_on() const { return !decisive_.empty(); }
  /// Keeps what `rows` needs of a whole block for its look, in tally.groups; numbers of events as moments of no
  /// quantity, which only count. Does nothing if off.
  void keep(montecarlo::TrialBlock block, stats::Tally& tally) const;
  /// The number of trials that would decide all named rows; the present number if they are decided. A row without a
  /// verdict neither ends the run nor keeps it going, since no trials give it one. If no named row has a verdict,
  /// nothing is decided: the result is one more than the present number.
  std::uint64_t trials_needed(const stats::Tally& tally) const;
  /// Says of the named rows among `rows` of a table at which look the run ended, and where their figure of merit fell
  /// by more than 10 % since the first look, which is the sign of a heavy tail.
  void add_notes(const std::string& table, std::vector<ComparisonRow>& rows, const stats::Tally& tally,
                 const std::string& place = {}) const;
  /// Table `looks`: the named rows at every look.
  store::Table looks_table(const stats::Tally& tally) const;

 private:
  struct NamedRow {
    std::string table;
    ComparisonRow row;
    std::string place;
  };
  std::vector<NamedRow> named_rows(const stats::Tally& tally) const;
  bool is_named(const std::string& table, const ComparisonRow& row) const;
  /// Of the trials before look `look`.
  stats::Tally tally_at_look(const stats::Tally& tally, std::size_t look) const;
  /// 1 / (standard error^2 x trials): does not depend on the number of trials, but for heavy tails.
  double merit_of(const ComparisonRow& row, const stats::Tally& tally) const;

  std::size_t size_of_look() const;

  std::vector<Row> decisive_;
  std::vector<std::uint64_t> looks_;
  VerdictRule rule_;
  std::function<RowsOfTables(const stats::Tally&)> rows_;
  KeptParts kept_;
};

}  // namespace surveymc::compare
