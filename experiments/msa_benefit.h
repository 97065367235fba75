#pragma once
/// One point of the study `msa_benefit` (see msa_benefit.cpp): its maps, and the trials that verify them.
#include <memory>
#include <vector>

#include "msa_benefit_scenario.h"
#include "study/experiment.h"
#include "survey/readings.h"

namespace surveymc {

class MsaBenefit final : public StudyPoint {
 public:
  explicit MsaBenefit(BenefitScenario scenario);

  std::uint64_t trials() const override { return s_.trials; }
  Tally run_block(TrialBlock block) const override;
  PointResult finish(const Tally& tally) const override;
  std::string replay(std::uint64_t trial) const override;

 private:
  /// A direction of [[verify]]: what its trials start from.
  struct Verified {
    VerifiedDirection direction;
    Survey survey;
    CleanReadings clean;
    Eigen::RowVector3d lateral_N, position;  ///< the true ones
    Benefit benefit;
  };
  struct Errors;  // of a batch
  Errors simulate(const Verified& v, std::uint64_t first, int count) const;
  Table verification_table(const Tally& tally) const;

  BenefitScenario s_;
  std::unique_ptr<Estimator> estimator_;
  LaneArray uncorrected_;  ///< parameters that leave readings as they are
  std::vector<Verified> verified_;
};

/// `benefits` on the grid of the scenario, azimuth fastest.
std::vector<Map> benefit_maps(const BenefitScenario& scenario, const std::vector<Benefit>& benefits);
/// A row each for azimuth and lateral: where MSA helps, where it harms.
Table benefit_summary(const BenefitScenario& scenario, const std::vector<Benefit>& benefits);

}  // namespace surveymc
