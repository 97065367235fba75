#pragma once
/// Counting and tables of `chained_multistation`, study "performance".
#include "chained_quantities.h"
#include "montecarlo/run_blocks.h"
#include "store/table.h"

namespace surveymc {

/// Where the numbers of a trial stand in a tally.
class PerformanceLayout {
 public:
  PerformanceLayout(const ChainedScenario& s, std::size_t kept_runs);

  std::size_t estimators() const { return estimators_; }
  Eigen::Index numbers() const;  ///< of one estimator
  std::size_t counts() const { return count_count_; }
  std::size_t kept() const { return kept_; }
  bool along() const { return along_; }

  // Groups of a tally: one of every estimator, over the trials that it solved; then squared errors along the well
  std::size_t along_groups() const { return along_ ? estimators_ * kChainedQuantities : 0; }
  std::size_t group(std::size_t estimator, std::size_t quantity) const {
    return estimators_ + estimator * kChainedQuantities + quantity;
  }
  /// Empty before the first trial.
  const Moments& moments(const Tally& tally, std::size_t estimator) const;
  // Columns of an estimator's group; all are means over the stations of a trial
  Eigen::Index square(std::size_t quantity) const;   ///< of the error
  Eigen::Index claimed(std::size_t quantity) const;  ///< variance
  Eigen::Index z_square(std::size_t z) const;
  Eigen::Index nees() const;
  Eigen::Index cost() const;
  Eigen::Index worse(std::size_t quantity) const;  ///< its RMS in runs worse than single, else 0
  // Counts
  std::size_t worse_runs(std::size_t estimator, std::size_t quantity) const;  ///< RMS over the run above single's
  std::size_t worse_last(std::size_t estimator, std::size_t quantity) const;  ///< error at the last station
  std::size_t z_bin(std::size_t estimator) const;                             ///< the first of kBins
  std::size_t nees_bin(std::size_t estimator) const;                          ///< the first of kBins
  std::size_t cost_bin(std::size_t estimator) const;                          ///< the first of kBins
  std::size_t ended(std::size_t estimator, ChainedStatus status) const;       ///< trials that ended so
  std::uint64_t failed(const Tally& tally, std::size_t estimator) const;      ///< trials that did not converge

  static constexpr std::size_t kBins = 40;
  static constexpr double kZWidth = 0.25, kZFirst = -5, kNeesWidth = 1;
  double cost_width() const { return cost_width_; }

  /// What estimators know of a block's trials: as many rows are filled as each has solved.
  struct Block {
    std::vector<Eigen::MatrixXd> numbers, along;
    std::vector<Eigen::Index> rows;
  };
  Block block(Eigen::Index trials, int stations) const;
  /// One trial; estimators that failed are counted, by status, and left out one by one.
  void add(const std::vector<RunCheck>& checks, Block& block, std::vector<std::uint64_t>& counts) const;
  /// As groups of a tally.
  std::vector<Moments> groups(const Block& block) const;
  /// RMS of the run, by estimator and quantity, behind the others; NaN of those that failed.
  void keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const;

 private:
  std::vector<bool> chained_;
  std::size_t estimators_, kept_;
  int single_ = -1;  ///< its place among the estimators
  bool along_;
  double cost_width_;
  std::size_t count_count_;
};

/// Rows that annotations may name.
std::vector<RowName> performance_rows(const ChainedScenario& s);

/// rms, consistency, stations, worse, runs, histogram, failures, failed_trials.
std::vector<Table> performance_tables(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally);

/// Biases of the first trial, true and estimated (slide 9).
Table tracks_table(const ChainedScenario& s, const Stream& stream);

}  // namespace surveymc
