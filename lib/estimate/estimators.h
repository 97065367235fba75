#pragma once
/// The table of estimators: name, inputs, results, factory and prediction of each.
/// Factory, predictions, config check, law tests and the test of the docs all read this table and nothing else.
#include <memory>
#include <string_view>
#include <vector>

#include "estimate/estimator.h"
#include "estimate/sensitivity.h"

namespace surveymc::estimate {

/// The inputs from which an estimator is made. `truth` and `expected`: see make_estimator.
struct EstimatorInput {
  const EstimatorOptions& options;
  const survey::ReferenceField& field;
  const std::vector<survey::StationFields>& truth;
  const std::vector<survey::Vec3<double>>& expected;
};

/// One line of the table.
struct EstimatorKind {
  std::string_view name;        ///< value of `estimator.name`
  std::string_view fits;        ///< what is fitted, for messages and documents
  bool estimates_all = true;    ///< all six gains and biases; false: a fixed subset of its own
  bool takes_subset = false;    ///< EstimatorOptions::estimated may leave some out
  bool needs_attitude = false;  ///< needs the true field at every station: not for readings alone
  /// Weighs by EstimatorOptions::assumed: needs assumed.magnetometer > 0, and claims a covariance by these sizes.
  bool weighs = false;
  bool weighs_each_reading = false;  ///< by ReadingBlock::assumed_sd, if the readings have it
  bool estimates_reference = false;  ///< total field and dip too
  std::string_view derivative = {};  ///< default of EstimatorOptions::derivative; "": there is no choice
  bool has_second_solvers = false;   ///< NLopt's solvers
  /// The options have been checked. Never null.
  std::unique_ptr<Estimator> (*make)(const EstimatorInput& input) = nullptr;
  /// First-order effect of the estimator's inputs; null: the estimator has no prediction, and is refused where one is
  /// needed. Returns a condition >= 1e13 and no derivatives where the stations determine too little.
  Sensitivity (*predict)(const EstimatorOptions& options, const NominalTruth& truth) = nullptr;
};

/// All estimators, in the order in which messages list them.
const std::vector<EstimatorKind>& estimators();

/// The line of this name. Throws InputError ("estimator.name = ...: must be one of ...") if there is none.
const EstimatorKind& estimator_kind(std::string_view name);

}  // namespace surveymc::estimate
