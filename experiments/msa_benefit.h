#pragma once
/// One point of the study `msa_benefit` (see msa_benefit.cpp): its maps, and the trials that verify them.
#include <memory>
#include <vector>

#include "msa_benefit_scenario.h"
#include "study/experiment.h"
#include "survey/readings.h"

namespace surveymc {

/// A direction of [[verify]]: what its trials start from.
struct VerifiedWell {
  VerifiedDirection direction;
  Survey survey;
  CleanReadings clean;
  Eigen::RowVector3d lateral_N, position;  ///< the true ones
  Benefit benefit;
};
/// Of all directions. Throws InputError where the stations do not determine the estimated parameters.
std::vector<VerifiedWell> verified_wells(const BenefitScenario& scenario);

class MsaBenefit final : public StudyPoint {
 public:
  MsaBenefit(BenefitScenario scenario, std::vector<VerifiedWell> verified);

  Tally run_block(TrialBlock block) const override;
  PointResult report(const Tally& tally, const RunOptions& options) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  struct Errors;  // of a batch
  Errors simulate(const VerifiedWell& v, std::uint64_t first, int count) const;
  Table verification_table(const Tally& tally) const;

  BenefitScenario s_;
  std::unique_ptr<Estimator> estimator_;
  LaneArray uncorrected_;  ///< parameters that leave readings as they are
  std::vector<VerifiedWell> verified_;
};

/// `benefits` on the grid of the scenario, azimuth fastest.
std::vector<Map> benefit_maps(const BenefitScenario& scenario, const std::vector<Benefit>& benefits);
/// A row each for azimuth and lateral: where MSA helps, where it harms.
Table benefit_summary(const BenefitScenario& scenario, const std::vector<Benefit>& benefits);

}  // namespace surveymc
