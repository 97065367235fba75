#pragma once
/// An event of multi-station analysis as a region of the normals of a run: an estimated gain or bias, or the error of
/// the final position, beyond a limit. Without a converged estimate a trial has no result.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "analysis/msa_chain.h"
#include "estimate/estimator.h"
#include "rare/limit_state.h"
#include "rare/proposal.h"
#include "sensor/readings_of_normals.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// What an event may be about: gain_x .. bias_z (the estimate: 1, nT), north_m, east_m (final error), distance_m (its
/// length, three dimensions).
inline constexpr std::array<const char*, 9> kMsaEventQuantities{"gain_x", "gain_y",  "gain_z", "bias_x",    "bias_y",
                                                                "bias_z", "north_m", "east_m", "distance_m"};
inline constexpr std::size_t kMsaNorth = 6, kMsaEast = 7, kMsaDistance = 8;

/// quantity < limit, or > limit.
struct MsaEventRule {
  std::size_t quantity = 0;  ///< in kMsaEventQuantities
  double limit = 0;
  bool is_above = false;
};

class MsaEvent final : public rare::LimitState {
 public:
  /// `trials` and `estimator` must outlive this.
  MsaEvent(const MsaTrials& trials, const estimate::Estimator& estimator, const MsaEventRule& rule);

  int dimension() const override { return normals_.rows(); }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override;
  /// Its unit, positive where the event is not.
  double g_of(double quantity) const { return rule_.is_above ? rule_.limit - quantity : quantity - rule_.limit; }

  const sensor::ReadingNormals& normals() const { return normals_; }

 private:
  const MsaTrials& trials_;
  const estimate::Estimator& estimator_;
  MsaEventRule rule_;
  sensor::ReadingNormals normals_;
  std::vector<double> md_;
  Eigen::Vector3d position_;  // true, N, E, V of the last station from the first
};

/// Where the normals stand in the stream: at their places of plain trials.
rare::TrialAddresses addresses_of(const sensor::ReadingNormals& normals, random::Channel choice);

/// The direction in which a linear function of the draws rises, by the weights of its `sum` (0 .. 8: parameters and
/// coordinates): change by every normal.
Eigen::VectorXd gradient_of(const sensor::NoiseWeights& weights, int sum, const sensor::ReadingNormals& normals);

}  // namespace surveymc::analysis
