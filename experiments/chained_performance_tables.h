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

  /// Columns of Moments, by estimator and quantity or state; all are means over the stations of a trial.
  struct Numbers : Layout {
    explicit Numbers(std::size_t n) : estimators(n) {}
    std::size_t estimators;
    Slots square = slots(estimators, kChainedQuantities);   ///< of the error
    Slots claimed = slots(estimators, kChainedQuantities);  ///< variance
    Slots worse = slots(estimators, kChainedQuantities);    ///< its RMS in runs worse than single, else 0
    Slots z_square = slots(estimators, kChainedZ), nees = slots(estimators), cost = slots(estimators);
  };
  struct Counts : Layout {
    explicit Counts(std::size_t n) : estimators(n) {}
    std::size_t estimators;
    Slots worse_runs = slots(estimators, kChainedQuantities);  ///< RMS over the run above single's
    Slots worse_last = slots(estimators, kChainedQuantities);  ///< error at the last station
    Slots z = slots(estimators, kBins), nees = slots(estimators, kBins), cost = slots(estimators, kBins);
  };
  struct Groups : Layout {  ///< squared errors at every station; none if there are too many of them
    explicit Groups(std::size_t estimators) : square(slots(estimators, kChainedQuantities)) {}
    Slots square;
  };
  const Numbers numbers;
  const Counts counts;
  const Groups groups;

  std::size_t kept() const { return kept_; }
  bool along() const { return groups.size() > 0; }

  static constexpr double kZWidth = 0.25, kZFirst = -5, kNeesWidth = 1;
  double cost_width() const { return cost_width_; }

  /// One trial; `row` of the arrays is its own.
  void add(const std::vector<RunCheck>& checks, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> values,
           std::vector<Eigen::MatrixXd>& along, Eigen::Index row, std::vector<std::uint64_t>& events) const;
  /// RMS of the run, by estimator and quantity, behind the others.
  void keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const;

 private:
  std::vector<bool> chained_;
  std::size_t kept_;
  int single_ = -1;  ///< its place among the estimators
  double cost_width_;
};

/// Rows that annotations may name.
std::vector<RowName> performance_rows(const ChainedScenario& s);

/// rms, consistency, stations, worse, runs, histogram.
std::vector<Table> performance_tables(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally);

/// Biases of the first trial, true and estimated (slide 9).
Table tracks_table(const ChainedScenario& s, const Stream& stream);

}  // namespace surveymc
