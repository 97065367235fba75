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

  Eigen::Index numbers() const { return number_count_; }
  std::size_t groups() const { return along_ ? estimators_ * kChainedQuantities : 0; }
  std::size_t counts() const { return count_count_; }
  std::size_t kept() const { return kept_; }
  bool along() const { return along_; }

  // Columns of Moments; all are means over the stations of a trial
  Eigen::Index square(std::size_t estimator, std::size_t quantity) const;   ///< of the error
  Eigen::Index claimed(std::size_t estimator, std::size_t quantity) const;  ///< variance
  Eigen::Index z_square(std::size_t estimator, std::size_t z) const;
  Eigen::Index nees(std::size_t estimator) const;
  Eigen::Index cost(std::size_t estimator) const;
  Eigen::Index worse(std::size_t estimator, std::size_t quantity) const;  ///< its RMS in runs worse than single, else 0
  std::size_t group(std::size_t estimator, std::size_t quantity) const {
    return estimator * kChainedQuantities + quantity;
  }
  // Counts
  std::size_t worse_runs(std::size_t estimator, std::size_t quantity) const;  ///< RMS over the run above single's
  std::size_t worse_last(std::size_t estimator, std::size_t quantity) const;  ///< error at the last station
  std::size_t z_bin(std::size_t estimator) const;                             ///< the first of kBins
  std::size_t nees_bin(std::size_t estimator) const;                          ///< the first of kBins
  std::size_t cost_bin(std::size_t estimator) const;                          ///< the first of kBins

  static constexpr std::size_t kBins = 40;
  static constexpr double kZWidth = 0.25, kZFirst = -5, kNeesWidth = 1;
  double cost_width() const { return cost_width_; }

  /// One trial; `row` of the arrays is its own.
  void add(const std::vector<RunCheck>& checks, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> numbers,
           std::vector<Eigen::MatrixXd>& along, Eigen::Index row, std::vector<std::uint64_t>& counts) const;
  /// RMS of the run, by estimator and quantity, behind the others.
  void keep(const std::vector<RunCheck>& checks, std::vector<double>& samples) const;

 private:
  std::vector<bool> chained_;
  std::size_t estimators_, kept_;
  int single_ = -1;  ///< its place among the estimators
  bool along_;
  double cost_width_;
  Eigen::Index number_count_;
  std::size_t count_count_;
};

/// Rows that annotations may name.
std::vector<RowName> performance_rows(const ChainedScenario& s);

/// rms, consistency, stations, worse, runs, histogram.
std::vector<Table> performance_tables(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally);

/// Biases of the first trial, true and estimated (slide 9).
Table tracks_table(const ChainedScenario& s, const Stream& stream);

}  // namespace surveymc
