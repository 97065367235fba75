#pragma once
/// Uncertainty of a surveyed direction and position before and after multi-station analysis, to first order.
#include <Eigen/Core>

#include "estimate/estimator.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// One standard deviation each: azimuth of the last station (rad), last position to the side of the hole (lateral of
/// HLA at the last station; m, relative to the first station).
struct BenefitSd {
  double azimuth = 0, lateral = 0;
};

struct Benefit {
  BenefitSd before, after;       ///< infinite after, where the stations do not determine the estimated parameters
  double condition = 1;          ///< as in Sensitivity; infinite there
  double gain_bias_correlation;  ///< of the errors of gain z and bias z; NaN there and unless both are estimated
};

/// Every run has a tool of its own: gains 1 and biases 0, each with an error of sd errors.gain, errors.bias_sd.
///   before  the readings as they are: these errors, and the last station's (all stations') own noise
///   after   corrected with what `estimator` finds: its error, which has in it the reference's error, the noise of all
///           stations, and the errors of parameters that are not estimated; and the same noise, with its correlation
/// Both are linear in all draws and exact to first order. Undefined in azimuth at inclination 0 and 180 deg.
Benefit predict_benefit(const survey::Survey& survey, const survey::ReferenceField& field,
                        const estimate::InputErrors& errors, const estimate::EstimatorOptions& estimator);

/// after / before. Nothing to gain and nothing done (0 / 0) is 1; infinite where only `before` is 0.
double benefit_ratio(double before, double after);

}  // namespace surveymc::analysis
