#pragma once
/// Tables of the study clearance (docs/results-format.md).
#include <vector>

#include "clearance/scenario.h"
#include "compare/table_rows.h"
#include "stats/heavy_tail.h"
#include "store/table.h"

namespace surveymc::studies::clearance {

/// One pair of points in one formulation, by the names of published_quantities().
double quantity_of(const std::string& name, const proximity::PairPoints& points,
                   const proximity::PairClearance& clearance);

/// The tables, filled pair of wells after pair of wells.
class Tables {
 public:
  explicit Tables(const Scenario& scenario);

  void add(const Pair& pair);
  std::vector<store::Table> take(const Reference& reference);

 private:
  struct PublishedRow {
    const Published* published;
    std::string quantity;
    double analytic, value;
  };

  void add_clearance(const Pair& pair, proximity::ScanDirection direction,
                     const std::vector<proximity::PairPoints>& points);
  void add_least(const Pair& pair, proximity::ScanDirection direction,
                 const std::vector<proximity::PairPoints>& stations, const std::vector<proximity::PairPoints>& samples);
  void add_covariance(const Pair& pair, const proximity::PairErrors& errors, const std::string& where,
                      const proximity::PairPoints& points);
  void add_tail(const Pair& pair, const proximity::PairErrors& errors, const proximity::PairPoints& points);
  void write_tail(const std::string& offset, const std::string& formulation, const proximity::PairPoints& points,
                  double sd, double factor, const std::vector<stats::HeavyPart>& parts);
  void add_published(const Pair& pair);
  void add_warnings(const Well& well, const std::vector<propagate::NonFiniteTerm>& non_finite);
  void write_covariance(const std::string& offset, const std::string& formulation, const std::string& where,
                        const proximity::PairPoints& points, const std::string& of, const Eigen::Matrix3d& covariance);
  store::Table parameters_table() const;

  const Scenario& s_;
  compare::TableRows clearance_, least_, covariance_, tails_;
  std::vector<PublishedRow> published_;
  std::vector<compare::Warning> warnings_;
};

}  // namespace surveymc::studies::clearance
