#pragma once
/// Uncertainty of a surveyed direction and position before and after multi-station analysis, to first order.
#include <optional>

#include "analysis/first_order.h"
#include "estimate/estimator.h"
#include "estimate/sensitivity.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// One standard deviation each: azimuth of the last station (rad), last position to the side of the hole (lateral of
/// HLA at the last station; m, relative to the first station).
struct BenefitSd {
  double azimuth = 0, lateral = 0;
};

struct Benefit {
  BenefitSd before, after;       ///< `after`: infinite where the stations do not determine the estimated parameters
  double condition = 1;          ///< as in Sensitivity; infinite where `after` is
  double gain_bias_correlation;  ///< of the errors of gain z and bias z; NaN where `after` is infinite or one is fixed
  /// What the reference's draws do to azimuth (rad) and lateral (m) after the correction, columns 2 pair + {0 total
  /// field, 1 dip}; empty where `after` is infinite.
  Eigen::Matrix2Xd after_by_reference;
};

/// Every run has a tool of its own: gains 1 and biases 0, each with an error of sd errors.gain, errors.bias_sd.
///   before  uncorrected readings: the errors of the tool, and the last station's (all stations') own noise
///   after   readings corrected with the estimate: its error, which comes from the reference's error, the noise of all
///           stations, and the errors of parameters that are not estimated; and the same noise, with its correlation
/// Both are linear in all draws and exact to first order. Undefined in azimuth at inclination 0 and 180 deg.
/// `correlation`: of the reference's draws, 2 station + {0 total field, 1 dip}, where they are drawn at every station;
/// null: they are independent.
Benefit predict_benefit(const survey::Survey& survey, const survey::ReferenceField& field,
                        const estimate::InputErrors& errors, const estimate::EstimatorOptions& estimator,
                        const Eigen::MatrixXd* correlation = nullptr);

/// What each draw does to the azimuth of the last station (rad) and to the lateral (m). `after`: empty without an
/// estimate.
struct BenefitEffects {
  InputEffects<2> before;
  std::optional<InputEffects<2>> after;
};
/// `truth`: of an error-free tool in this well; `estimated`: of an estimator there.
BenefitEffects benefit_effects(const survey::Survey& survey, const estimate::NominalTruth& truth,
                               const std::optional<estimate::Sensitivity>& estimated,
                               const estimate::InputErrors& errors);

/// after / before. 1 where both are 0; infinite where only `before` is 0.
double benefit_ratio(double before, double after);

}  // namespace surveymc::analysis
