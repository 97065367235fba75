#pragma once
/// One pair of wells in one formulation of what they share: the event that they touch.
#include <memory>
#include <string>
#include <vector>

#include "collision/scenario.h"
#include "proximity/contact_design.h"
#include "proximity/contact_state.h"
#include "rare/event_trials.h"

namespace surveymc::studies::collision {

/// What is said of a pair before anything is drawn. Standard deviations and covariances have the slots in them.
struct Predictions {
  proximity::PairPoints closest, least_sf_pair;
  double separation_factor = kNaN;                       ///< the least, by the rule of `[separation]`
  double mahalanobis = kNaN;                             ///< at the closest pair
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< relative, of its points, m2
  double sd = kNaN;                                      ///< along the line between them, m
  bool is_equidistant = false;  ///< the wells are as near over a tenth of the reference: "closest" is arbitrary
  std::array<double, kFormulations.size()> probability{};
};

class PairEvent {
 public:
  const std::string& offset() const { return offset_; }
  const std::string& correlation() const { return correlation_; }
  const events::PreparedEvent& event() const { return event_; }
  const Predictions& predictions() const { return predictions_; }
  const std::vector<proximity::TouchingPair>& touching() const { return touching_; }
  int dimension() const { return state_->dimension(); }
  double radii() const { return radii_; }

  /// Of the probability p: d ln p / d ln (size of all errors), the slots' left out: p falls with larger errors below 0.
  struct SizeSlope {
    double value = kNaN, lo = kNaN, hi = kNaN;
  };
  /// `hits`: moments of weights of hits and of weights times score(), over all trials (0 where there is no hit).
  SizeSlope size_slope(const stats::Moments& hits, double confidence) const;

  /// weighted: as EventTrials, then the hits by depth of contact: kContactBins of the reference, as many of the offset.
  static constexpr std::size_t kContactBins = 20;
  stats::Tally run_block(std::uint64_t first, int count, std::size_t number) const;
  stats::Tally subset_replicates(std::uint64_t first, int count) const;
  /// How many WeightedHits a block has.
  std::size_t weights() const;
  /// Least and largest measured depth of the bins: 0 the reference, 1 the offset; m.
  std::pair<double, double> depths(int well) const { return depths_[static_cast<std::size_t>(well)]; }

  std::string replay(std::uint64_t trial) const;

  /// alpha_i^2 of every design point, summed by source and well; the nearest one first, of each the largest first.
  struct Importance {
    std::size_t design = 0;
    std::string code, mode, well;
    double factor = 0;
    Eigen::VectorXd direction = {};  ///< of the source's normals towards the design point, unit length
  };
  std::vector<Importance> importance() const;

  /// Numbers of a sample of the table hits: number of the event, trial, weight, component, two depths, the linear
  /// displacement at the closest pair in the plane across the wells, two numbers (m), and how far the first kLeading
  /// sources of importance() are drawn towards the first design point (sd; NaN where there are fewer).
  static constexpr int kLeading = 3;
  /// Predictions::covariance in that plane, m2.
  Eigen::Matrix2d plane_covariance() const { return plane_ * predictions_.covariance * plane_.transpose(); }

 private:
  friend std::unique_ptr<const PairEvent> pair_event(const Scenario&, const scenario::PairReference&,
                                                     const propagate::WellErrors&, std::size_t,
                                                     const scenario::PairFormulation&, const random::Stream&);
  PairEvent(const Scenario& scenario, const random::Stream& stream, std::string offset, std::string correlation)
      : s_(scenario), stream_(stream), offset_(std::move(offset)), correlation_(std::move(correlation)) {}

  /// Normals of V among which the nearest way to touch is sought: the errors that last are wider at the larger ones,
  /// and the design point nearer.
  std::vector<double> wider_errors() const;
  /// J with the V that belong to `v`.
  Eigen::Matrix3Xd with_mixing(Eigen::Matrix3Xd j, double v) const;
  rare::Prepared prepare(const propagate::WellErrors& reference, const propagate::WellErrors& offset);
  /// What a trial says of the size of the errors: with y = U'z of the mixture's directions and M = U'U of the rows that
  /// are errors, y'M y - tr M. The other directions do not lead to the event: to first order they say nothing.
  double score(const rare::DrawnTrials& drawn, int trial) const;
  /// `first`: station of both wells from which on the pair counts.
  void predict(const scenario::WellPair& pair, const proximity::PairErrors& errors, std::size_t first);

  const Scenario& s_;
  random::Stream stream_;
  std::string offset_, correlation_;
  double radii_ = 0;
  std::unique_ptr<proximity::ContactState> state_;
  std::unique_ptr<proximity::HitState> hits_;
  std::vector<proximity::TouchingPair> touching_;
  std::array<std::pair<double, double>, 2> depths_;
  std::vector<propagate::ErrorSource> reference_sources_, offset_sources_;
  Predictions predictions_;
  Eigen::Vector3d closest_r_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 2, 3> plane_;
  Eigen::Matrix3Xd closest_j_;
  Eigen::Matrix3d slots_ = Eigen::Matrix3d::Zero();
  events::PreparedEvent event_;
  std::unique_ptr<rare::EventTrials> trials_;
  std::vector<Importance> leading_;      ///< the first kLeading of importance()
  Eigen::MatrixXd directions_, scaled_;  ///< U and M of score(); empty without a design point
};

/// Predicts and prepares. `drawn`: errors of the reference. The scenario must outlive it.
std::unique_ptr<const PairEvent> pair_event(const Scenario& scenario, const scenario::PairReference& reference,
                                            const propagate::WellErrors& drawn, std::size_t offset,
                                            const scenario::PairFormulation& formulation, const random::Stream& stream);

}  // namespace surveymc::studies::collision
