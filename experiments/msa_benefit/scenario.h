#pragma once
/// The checked settings of a config of `msa_benefit`.
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/msa_benefit_prediction.h"
#include "analysis/well_design.h"
#include "compare/annotations.h"
#include "compare/calibration.h"
#include "compare/tails.h"
#include "compare/trial_plan.h"
#include "random/study_id.h"
#include "scenario/drawn_reference.h"
#include "scenario/prediction_orders.h"
#include "sensor/tool_spread.h"

namespace surveymc::studies::msa_benefit {

/// The quantities that are mapped and verified: "azimuth", "lateral".
constexpr std::array<const char*, 2> kBenefits{"azimuth", "lateral"};
constexpr std::array<const char*, 2> kBenefitUnits{"deg", "m"};

/// Of table `tails`; before the correction nothing reads the reference.
inline const std::vector<std::string> kTailNames{"azimuth_after", "lateral_after"};

/// A direction of the last station where Monte Carlo is asked for.
struct VerifiedDirection {
  double inclination_deg = 0, azimuth_deg = 0;
  config::ConfigPlace place = {};  ///< of the inclination
};

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;                     ///< no trials without [[verify]]
  std::vector<double> inclination_deg, azimuth_deg;  ///< the map, of the last station
  analysis::WellDesign well;
  survey::ReferenceField field;
  sensor::ToolSpread spread;  ///< the a-priori errors
  sensor::NoiseModel noise;
  scenario::DrawnReference reference;  ///< of all directions: their stations are at the same depths
  compare::TailRule tails;
  estimate::InputErrors errors;  ///< sizes of all of these
  estimate::EstimatorOptions estimator;
  scenario::PredictionOrders orders;  ///< of the lateral after MSA
  std::vector<VerifiedDirection> verify;
  compare::VerdictRule verdict;
  compare::CalibrationRule calibration;
  compare::Annotations annotations;
};

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// True for a direction that benefit_well() takes for vertical.
bool is_vertical(double inclination_deg);

/// The well to a direction of the map. A vertical direction is moved 1e-6 rad off the vertical, so that azimuth and
/// lateral are limits.
survey::Survey benefit_well(const Scenario& scenario, double inclination_deg, double azimuth_deg);
survey::Survey benefit_well(const analysis::WellDesign& design, double inclination_deg, double azimuth_deg);

/// "inclination 75 azimuth 30": begins the formulation of its rows.
std::string direction_name(const VerifiedDirection& direction);

}  // namespace surveymc::studies::msa_benefit
