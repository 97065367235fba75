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
#include "rare/mixing_normal.h"
#include "rare/proposal.h"
#include "sensor/readings_of_normals.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// What an event may be about: gain_x .. bias_z (the estimate: 1, nT), north_m, east_m (final error), distance_m (its
/// length, three dimensions), north_in_sd .. along_hole_in_sd (its size along a direction, in standard deviations).
inline constexpr std::array<const char*, 15> kMsaEventQuantities{
    "gain_x",     "gain_y",         "gain_z",          "bias_x",        "bias_y",
    "bias_z",     "north_m",        "east_m",          "distance_m",    "north_in_sd",
    "east_in_sd", "vertical_in_sd", "high_side_in_sd", "lateral_in_sd", "along_hole_in_sd"};
inline constexpr std::size_t kMsaNorth = 6, kMsaEast = 7, kMsaDistance = 8, kMsaInSd = 9;

/// quantity < limit, or > limit.
struct MsaEventRule {
  std::size_t quantity = 0;  ///< in kMsaEventQuantities
  double limit = 0;
  bool is_above = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of kMsaInSd and after: N, E, V over the sd, 1/m
};

class MsaEvent final : public rare::LimitState {
 public:
  /// `trials` and `estimator` must outlive this. `mixing`: errors of the reference that are not normal.
  MsaEvent(const MsaTrials& trials, const estimate::Estimator& estimator, const MsaEventRule& rule,
           const sensor::ReferenceMixing& mixing = {});

  int dimension() const override { return normals_.rows() + 4 * static_cast<int>(mixing_calls_.size()); }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override;
  /// Its unit, positive where the event is not.
  double g_of(double quantity) const { return rule_.is_above ? rule_.limit - quantity : quantity - rule_.limit; }

  const sensor::ReadingNormals& normals() const { return normals_; }
  /// Calls of the V, whose normals stand behind normals(); and which error has which.
  const std::vector<sensor::NormalAddress>& mixing_calls() const { return mixing_calls_; }
  const std::vector<rare::MixingNormal>& mixing() const { return mixing_; }

 private:
  const MsaTrials& trials_;
  const estimate::Estimator& estimator_;
  MsaEventRule rule_;
  sensor::ReadingNormals normals_;
  std::vector<sensor::NormalAddress> mixing_calls_;
  std::vector<rare::MixingNormal> mixing_;
  std::vector<double> md_;
  Eigen::Vector3d position_;  // true, N, E, V of the last station from the first
};

/// Where the normals stand in the stream: at their places of plain trials.
rare::TrialAddresses addresses_of(const sensor::ReadingNormals& normals, random::Channel choice);

/// The direction in which a linear function of the draws rises, by the weights of its `sum` (0 .. 8: parameters and
/// coordinates): change by every normal.
Eigen::VectorXd gradient_of(const sensor::NoiseWeights& weights, int sum, const sensor::ReadingNormals& normals);

}  // namespace surveymc::analysis
