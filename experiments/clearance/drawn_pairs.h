#pragma once
/// Monte Carlo of the relative position: both wells of a pair drawn in one trial, at the depths of report_md_m.
#include <memory>
#include <string>
#include <vector>

#include "clearance/scenario.h"
#include "proximity/drawn_pair.h"
#include "random/stream.h"
#include "stats/tally.h"
#include "store/table.h"

namespace surveymc::studies::clearance {

class DrawnPairs {
 public:
  stats::Tally run_block(std::uint64_t first_trial, int count) const;
  /// Table relative_position.
  store::Table relative_position(const stats::Tally& tally) const;
  /// Samples relative_realisations.
  store::Table realisations(const stats::Tally& tally) const;
  /// One trial in words.
  std::string replay(std::uint64_t trial) const;

 private:
  friend std::unique_ptr<const DrawnPairs> drawn_pairs(const Scenario&);
  DrawnPairs(const Scenario& scenario, const random::Stream& stream) : s_(scenario), stream_(stream) {}

  /// Draws of an offset: which of the reference's they share.
  struct Truth {
    std::string formulation;
    std::unique_ptr<proximity::DrawnPoints> offset;
    std::vector<Eigen::Matrix3d> control;  ///< covariance of the first-order relative error, at every depth
  };
  /// A prediction and the draws that it is held against.
  struct Judgement {
    std::string formulation;
    std::size_t truth;
    struct AtDepth {
      Eigen::Matrix<double, 3, 4> directions;  ///< u, then the axes of the ellipsoid, largest first
      Eigen::Vector4d sd;
      Eigen::Matrix3d weight;  ///< inverse covariance; NaN where there is none
    };
    std::vector<AtDepth> at;
  };
  struct Offset {
    std::string name;
    std::vector<std::size_t> depths;  ///< indices into report_md
    std::vector<proximity::PairPoints> points;
    std::vector<Truth> truths;
    std::vector<Judgement> judgements;
  };
  static constexpr int kDirections = 4;

  void add_offset(const Reference& reference, const propagate::WellErrors& drawn_reference, const Well& well);
  template <class Visit>
  void visit_trials(std::uint64_t first_trial, int count, Visit visit) const;

  const Scenario& s_;
  random::Stream stream_;
  std::unique_ptr<proximity::DrawnPoints> reference_;
  std::vector<Offset> offsets_;
};

/// `scenario` must outlive it.
std::unique_ptr<const DrawnPairs> drawn_pairs(const Scenario& scenario);

}  // namespace surveymc::studies::clearance
