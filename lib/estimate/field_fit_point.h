#pragma once
/// One trial of a fit of field_fit.h by itself: its unknowns, and the minimum that a start leads to.
#include <array>

#include "estimate/estimator.h"
#include "estimate/field_fit.h"
#include "survey/readings.h"

namespace surveymc::estimate {

/// The unknowns of one trial: p, q / total, z (zero unless joint).
struct FieldFitPoint {
  std::array<double, 8> x{1, 1, 1, 0, 0, 0, 0, 0};
  double cost = 0;  ///< nT^2
  bool converged = false;
};

/// The unknowns of an estimate: gains, biases (nT), and of a joint estimate the reference (nT) at the first station
/// beside the one that was given.
FieldFitPoint field_fit_point(const FieldFitModel& model, const EstimateBlock& estimates,
                              const survey::ReadingBlock& readings, int trial);

/// The minimum of one trial of `readings` that Newton's steps from `start` lead to: its branch, where there are more.
FieldFitPoint field_fit_from(const FieldFitModel& model, const survey::ReadingBlock& readings, int trial,
                             const FieldFitPoint& start, double step_tolerance);

}  // namespace surveymc::estimate
