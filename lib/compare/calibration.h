#pragma once
/// Calibration of a study's claimed distributions: `[calibration]`, and the tables `calibration`, `pit`, `coverage`
/// (stats/calibration.h; docs/results-format.md).
#include <span>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "config/config.h"
#include "estimate/estimator.h"
#include "sensor/magnetometer.h"
#include "stats/calibration.h"
#include "store/table.h"

namespace surveymc::compare {

/// `[calibration] margin (0.01), confidence (0.95), quantities (all), truth ("prior")`. The table turns it on.
struct CalibrationRule {
  bool on = false;
  double margin = 0.01;      ///< largest deviation of a distribution function that agrees; 0: the band's own test
  double confidence = 0.95;  ///< that the whole band holds
  bool truth_as_is = false;  ///< the truth need not be drawn from the estimator's priors
  std::vector<std::string> quantities;  ///< empty: all

  bool wants(const std::string& quantity) const;
};

/// Throws InputError for quantities that no calibrated row of the scenario has.
CalibrationRule read_calibration(config::ConfigReader& config, const std::vector<Row>& rows);

/// An estimator with priors is right on average over truths that are drawn from them: throws InputError unless its
/// priors are the spread of the tools about gains 1 and biases 0, and its prior of a reference that it estimates is the
/// reference's error; also where it claims nothing (`weighs` of estimators.h). Nothing is asked if the rule is not on
/// or takes the truth as it is.
void require_calibrated_inputs(config::ConfigReader& config, const CalibrationRule& rule,
                               const estimate::EstimatorOptions& estimator, const estimate::InputErrors& truth,
                               const sensor::MagnetometerErrors& tool);

/// A quantity with a claimed distribution, and where its errors fall.
struct CalibratedQuantity {
  std::string formulation, quantity;
  stats::ClaimedLaw law;
  stats::PitCells cells;
};

/// Errors in units of the claimed normal's `sd`; squared distances of so many degrees.
CalibratedQuantity normal_quantity(const std::string& formulation, const std::string& quantity, double sd);
/// Angles by their tangents; sd in rad.
CalibratedQuantity angle_quantity(const std::string& formulation, const std::string& quantity, double sd);
CalibratedQuantity chi_squared_quantity(const std::string& formulation, const std::string& quantity, double degrees);

/// The calibrated rows of the scenario that the rule wants; none if it is not on.
std::vector<Row> calibrated_rows(const std::vector<Row>& rows, const CalibrationRule& rule);
/// `rows` without the calibrated ones that the table will not have, for annotations.
std::vector<Row> annotated_rows(std::vector<Row> rows, const CalibrationRule& rule);

/// The three tables from the counts of a tally: stats::kPitSlots of each quantity, one after the other, beginning with
/// counts[first]; an empty tally gives tables without rows, a rule that is not on no tables. `paired`: trials are
/// antithetic pairs, which are the unit of the band.
std::vector<store::Table> calibration_tables(const CalibrationRule& rule,
                                             const std::vector<CalibratedQuantity>& quantities,
                                             const std::vector<std::uint64_t>& counts, std::size_t first, bool paired,
                                             const Annotations& annotations);

}  // namespace surveymc::compare
