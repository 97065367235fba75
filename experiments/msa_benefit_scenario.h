#pragma once
/// What a config of `msa_benefit` says, checked.
#include <cstdint>
#include <vector>

#include "msa_benefit_prediction.h"
#include "msa_benefit_well.h"
#include "random/study_id.h"
#include "study/annotations.h"
#include "study/scenario.h"

namespace surveymc {

/// What is mapped and verified: "azimuth", "lateral".
constexpr std::array<const char*, 2> kBenefits{"azimuth", "lateral"};
constexpr std::array<const char*, 2> kBenefitUnits{"deg", "m"};

/// A direction of the last station where Monte Carlo is asked for.
struct VerifiedDirection {
  double inclination_deg = 0, azimuth_deg = 0;
  ConfigPlace place = {};  ///< of the inclination
};

struct BenefitScenario {
  StudySeed seed;
  std::uint64_t trials = 0;
  std::vector<double> inclination_deg, azimuth_deg;  ///< the map, of the last station
  WellDesign well;
  ReferenceField field;
  ToolSpread spread;  ///< the a-priori errors
  NoiseModel noise;
  InputErrors errors;  ///< sizes of all of these
  EstimatorOptions estimator;
  std::vector<VerifiedDirection> verify;
  VerdictRule verdict;
  Annotations annotations;
};

/// Throws InputError.
BenefitScenario read_benefit_scenario(ConfigReader& config, StudySeed seed);

/// The well to a direction of the map. Along the vertical it is taken 1e-6 rad off it: there azimuth, and what is
/// lateral, are limits.
Survey benefit_well(const BenefitScenario& scenario, double inclination_deg, double azimuth_deg);

}  // namespace surveymc
