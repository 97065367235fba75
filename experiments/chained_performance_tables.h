#pragma once
/// Counting and tables of `chained_multistation`, study "performance".
#include "chained_quantities.h"
#include "montecarlo/run_blocks.h"
#include "stats/layout.h"
#include "store/table.h"

namespace surveymc {

/// Where the numbers of a trial stand in a tally.
class PerformanceLayout {
 public:
  PerformanceLayout(const ChainedScenario& s, std::size_t kept_runs);

  static constexpr std::size_t kBins = 40;

  /// Columns of an estimator's Moments, by quantity or state; all are means over the stations of a trial.
  struct Numbers : Layout {
    Slots square = slots(kChainedQuantities);   ///< of the error
    Slots claimed = slots(kChainedQuantities);  ///< variance
    Slots worse = slots(kChainedQuantities);    ///< its RMS in runs worse than single, else 0
    Slots z_square = slots(kChainedZ), nees = slots(), cost = slots();
  };
  struct Counts : Layout {
    explicit Counts(std::size_t n) : estimators(n) {}
    std::size_t estimators;
    Slots worse_runs = slots(estimators, kChainedQuantities);  ///< RMS over the run above single's
    Slots worse_last = slots(estimators, kChainedQuantities);  ///< error at the last station
    Slots z = slots(estimators, kBins), nees = slots(estimators, kBins), cost = slots(estimators, kBins);
    Slots ended = slots(estimators, kChainedStatuses);  ///< trials that ended so
  };
  struct Groups : Layout {
    Groups(std::size_t n, bool along) : estimators(n), squares(along ? n : 0) {}
    std::size_t estimators, squares;
    Slots solved = slots(estimators);                   ///< Numbers, over the trials that the estimator solved
    Slots square = slots(squares, kChainedQuantities);  ///< errors at every station; none if there are too many
  };
  const Numbers numbers;
  const Counts counts;
  const Groups groups;

  /// Empty before the first trial.
  const Moments& moments(const Tally& tally, std::size_t estimator) const;
  /// Trials that did not converge.
  std::uint64_t failed(const Tally& tally, std::size_t estimator) const;

  std::size_t kept() const { return kept_; }
  bool along() const { return groups.squares > 0; }

  static constexpr double kZWidth = 0.25, kZFirst = -5, kNeesWidth = 1;
  double cost_width() const { return cost_width_; }

  /// What estimators know of a block's trials: as many rows are filled as each has solved.
  struct Block {
    std::vector<Eigen::MatrixXd> numbers, along;
    std::vector<Eigen::Index> rows;
  };
  Block block(Eigen::Index trials, int stations) const;
  /// One trial; estimators that failed are counted, by status, and left out one by one.
  void add(const std::vector<RunCheck>& checks, Block& block, std::vector<std::uint64_t>& events) const;
  /// As groups of a tally.
  std::vector<Moments> moments_of(const Block& block) const;
  /// RMS of the run, by estimator and quantity, behind the others; NaN of those that failed.
  void keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const;

 private:
  std::vector<bool> chained_;
  std::size_t kept_;
  int single_ = -1;  ///< its place among the estimators
  double cost_width_;
};

/// Rows that annotations may name.
std::vector<RowName> performance_rows(const ChainedScenario& s);

/// rms, consistency, stations, worse, runs, histogram, failures, failed_trials.
std::vector<Table> performance_tables(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally);

/// Biases of the first trial, true and estimated (slide 9).
Table tracks_table(const ChainedScenario& s, const Stream& stream);

}  // namespace surveymc
