#pragma once
/// Counting and tables of `chained_multistation`, study "performance".
#include "chained_multistation/quantities.h"
#include "montecarlo/run_blocks.h"
#include "stats/layout.h"
#include "store/table.h"

namespace surveymc::studies::chained_multistation {

/// Layout of the numbers of a trial in a tally.
class PerformanceLayout {
 public:
  explicit PerformanceLayout(const Scenario& s);

  static constexpr std::size_t kBins = 40;

  /// Columns of an estimator's Moments, by quantity or state; all are means over the stations of a trial.
  struct Numbers : stats::Layout {
    stats::Slots square = slots(kRunQuantities);   ///< of the error
    stats::Slots claimed = slots(kRunQuantities);  ///< variance
    stats::Slots worse = slots(kRunQuantities);    ///< RMS of the error in runs worse than single, else 0
    stats::Slots z_square = slots(kTestedStates), nees = slots(), cost = slots();
  };
  struct Counts : stats::Layout {
    explicit Counts(std::size_t n) : estimators(n) {}
    std::size_t estimators;
    stats::Slots worse_runs = slots(estimators, kRunQuantities);  ///< RMS over the run above single's
    stats::Slots worse_last = slots(estimators, kRunQuantities);  ///< error at the last station
    stats::Slots z = slots(estimators, kBins), nees = slots(estimators, kBins), cost = slots(estimators, kBins);
    stats::Slots ended = slots(estimators, stats::kDescentStatuses);  ///< trials that ended with this status
  };
  struct Groups : stats::Layout {
    Groups(std::size_t n, bool along) : estimators(n), squares(along ? n : 0) {}
    std::size_t estimators, squares;
    stats::Slots solved = slots(estimators);               ///< Numbers, over the trials that the estimator solved
    stats::Slots square = slots(squares, kRunQuantities);  ///< errors at every station; none if there are too many
  };
  const Numbers numbers;
  const Counts counts;
  const Groups groups;

  /// Empty before the first trial.
  const stats::Moments& moments(const stats::Tally& tally, std::size_t estimator) const;
  /// Trials that did not converge.
  std::uint64_t failed(const stats::Tally& tally, std::size_t estimator) const;

  std::size_t kept() const { return kept_; }
  bool along() const { return groups.squares > 0; }

  static constexpr double kZWidth = 0.25, kZFirst = -5, kNeesWidth = 1;
  double cost_width() const { return cost_width_; }

  /// Results of the estimators for a block's trials: each fills as many rows as it has solved trials.
  struct Block {
    std::vector<Eigen::MatrixXd> numbers, along;
    std::vector<Eigen::Index> rows;
  };
  Block block(Eigen::Index trials, int stations) const;
  /// One trial; estimators that failed are counted, by status, and left out one by one.
  void add(const std::vector<RunCheck>& checks, Block& block, std::vector<std::uint64_t>& events) const;
  /// The moments of a block, as groups of a tally.
  std::vector<stats::Moments> moments_of(const Block& block) const;
  /// RMS of the run, by estimator and quantity, behind the others; NaN of those that failed.
  void keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const;

 private:
  std::vector<bool> chained_;
  std::size_t kept_;
  int single_ = -1;  ///< its place among the estimators
  double cost_width_;
};

/// Counts of claimed distributions of the chained estimators: twelve states and NEES of the first, middle and last
/// station, and the cost.
class PerformanceCalibration {
 public:
  explicit PerformanceCalibration(const Scenario& s);

  /// How many counts it has.
  std::size_t size() const { return quantities_.size() * stats::kPitSlots; }
  /// One trial, by estimator; those that failed are left out. `counts`: size() of them.
  void add(const std::vector<RunCheck>& checks, std::uint64_t* counts) const;
  const std::vector<compare::CalibratedQuantity>& quantities() const { return quantities_; }

 private:
  /// Where the number of a quantity is found in a RunCheck.
  struct Source {
    std::size_t estimator = 0, station = 0;
    int state = 0;  ///< of twelve; kNees, kCost
  };
  static constexpr int kNees = -1, kCost = -2;

  std::vector<compare::CalibratedQuantity> quantities_;
  std::vector<Source> sources_;
};

/// All rows of the tables rms and consistency, and of the calibration in the order in which it counts.
std::vector<compare::Row> rows_of(const Scenario& s);
/// Of the tables rms and consistency, without annotations.
compare::RowsOfTables performance_rows(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally);

/// rms, consistency, stations, worse, runs, histogram, failures, failed_trials; and looks where the stop is on.
std::vector<store::Table> performance_tables(const Scenario& s, const PerformanceLayout& layout,
                                             const compare::VerdictStop& stop, const stats::Tally& tally);

/// Biases of the first trial, true and estimated (slide 9).
store::Table tracks_table(const Scenario& s, const random::Stream& stream);

}  // namespace surveymc::studies::chained_multistation
