#pragma once
/// The path of a well as minimum curvature draws it, and the points of it that come closest to another point.
///
/// From a point q, the distance to an arc of radius R with tangent t1 and normal n at its beginning p1 is least at
///   phi = atan2((q - p1).t1, R - (q - p1).n),                 (from t1; R - .. : the centre stays out of it)
/// to a straight leg at the projection of q. The derivative of the distance along the hole has the sign of (p - q).t,
/// which is continuous at stations; within a leg, which turns by less than pi, it changes once at most. So a leg has a
/// minimum exactly where (p - q).t goes from negative to positive: nothing has to be searched.
#include <vector>

#include <Eigen/Core>

#include "survey/survey.h"

namespace surveymc::proximity {

/// A point of a path. At station k: leg k, share 0; at the last station: the last leg, share 1.
struct PathPoint {
  std::size_t leg = 0;                                 ///< from station `leg` to the next
  double share = 0;                                    ///< of the leg's length that lies before the point, [0, 1]
  double md = 0;                                       ///< m
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< north, east, down, m
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitZ();
};

enum class PathEnd { interior, start, end };

struct ClosestPoint {
  PathPoint point;
  double distance = 0;  ///< m
  PathEnd end = PathEnd::interior;
};

class WellPath {
 public:
  std::size_t stations() const { return md_.size(); }
  double md(std::size_t station) const { return md_[station]; }
  PathPoint at_station(std::size_t station) const;
  /// The point at a measured depth, which is taken to lie within the path.
  PathPoint at(double md) const;
  PathPoint at(std::size_t leg, double share) const;

  /// All points from station `first` on at which the distance from `q` has a local minimum, ends included, in order of
  /// depth; of a stretch at one distance, the shallowest.
  void local_minima(const Eigen::Vector3d& q, std::size_t first, std::vector<ClosestPoint>& out) const;
  /// The nearest of them, of equal ones the shallowest.
  ClosestPoint closest(const Eigen::Vector3d& q, std::size_t first) const;

 private:
  friend WellPath well_path(const survey::Survey&, const Eigen::Vector3d&);
  WellPath() = default;
  struct Leg {
    double length = 0, dogleg = 0;                     ///< m, rad
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< from the beginning towards the centre; zero: a straight leg
  };
  template <class Visit>
  void visit_minima(const Eigen::Vector3d& q, std::size_t first, Visit visit) const;
  ClosestPoint closest_of_leg(const Eigen::Vector3d& q, std::size_t leg) const;

  std::vector<double> md_;
  std::vector<Eigen::Vector3d> positions_, tangents_;
  std::vector<Leg> legs_;
};

/// `slot`: north, east, down of the first station, m.
WellPath well_path(const survey::Survey& survey, const Eigen::Vector3d& slot);

}  // namespace surveymc::proximity
