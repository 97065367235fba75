#pragma once
/// Two wells drawn from their error models in one trial, with the draws that they share: nonlinear Monte Carlo of the
/// relative position at fixed pairs of points (propagate/drawn_well.h draws one well).
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "propagate/drawn_well.h"
#include "proximity/pair_errors.h"
#include "proximity/well_path.h"

namespace surveymc::proximity {

/// Draws of the reference and of the offset that are one error: their numbers in WellErrors::draws.
using SharedDraws = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// The draws of the sources that shared_sources() gives.
SharedDraws shared_draws(const propagate::WellErrors& reference, const propagate::WellErrors& offset,
                         const PairErrors& pair);
/// Those of a sidetrack: R of the stations down to `kickoff`, S of the runs that begin there, all of W and G.
SharedDraws draws_of_shared_hole(const propagate::WellErrors& reference, const propagate::WellErrors& offset,
                                 std::size_t kickoff);

/// The point of a path for the drawn well.
propagate::WellPoint well_point(const PathPoint& point);

/// Covariance of the offset's error less the reference's, m2, to first order; "effects" between stations.
Eigen::Matrix3d relative_covariance(const propagate::WellErrors& reference, const propagate::WellErrors& offset,
                                    const SharedDraws& shared, const propagate::WellPoint& reference_point,
                                    const propagate::WellPoint& offset_point, propagate::FirstOrder which);

/// Addresses of an offset's draws in the stream: behind those of the reference; shared draws have the reference's.
std::vector<propagate::DrawPlace> offset_places(const propagate::WellErrors& reference,
                                                const propagate::WellErrors& offset, const SharedDraws& shared);

/// A well drawn at points in any order: drawn_points().
class DrawnPoints {
 public:
  const propagate::DrawnWell& well() const { return well_; }
  /// Error of a point in trial `trial` of an output of well().draw(), N, E, V, m; and what the same draws give to first
  /// order (minimum curvature).
  Eigen::Vector3d error(const survey::LaneArray& out, int trial, std::size_t point) const;
  Eigen::Vector3d first_order(const survey::LaneArray& out, int trial, std::size_t point) const;

 private:
  friend DrawnPoints drawn_points(const propagate::WellErrors&, const std::vector<propagate::WellPoint>&,
                                  const std::vector<propagate::DrawPlace>&);
  DrawnPoints(std::vector<std::size_t> position, propagate::DrawnWell well)
      : position_(std::move(position)), well_(std::move(well)) {}

  std::vector<std::size_t> position_;  ///< where each point stands in the order of their stations
  propagate::DrawnWell well_;
};

DrawnPoints drawn_points(const propagate::WellErrors& errors, const std::vector<propagate::WellPoint>& points,
                         const std::vector<propagate::DrawPlace>& places);

}  // namespace surveymc::proximity
