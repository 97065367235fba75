#pragma once
/// From two wells to the rows of a clearance table and to the least separation.
///
/// A scan goes along one well, the scanned one, and takes from each of its points the closest point of the other well's
/// path. Going along the reference and going along the offset find different pairs.
#include <array>
#include <vector>

#include "proximity/pair_errors.h"
#include "proximity/separation.h"
#include "proximity/well_path.h"

namespace surveymc::proximity {

enum class ScanDirection { reference, offset };

/// What all formulations have in common: paths, listed azimuths (rad, true north, one a station) and the rule.
struct PairGeometry {
  const WellPath* reference = nullptr;
  const WellPath* offset = nullptr;
  const survey::Survey* reference_survey = nullptr;
  SeparationRule rule;
  double radii = 0;               ///< of both holes, m
  std::size_t first = 0;          ///< station at which both paths begin: that of the kick-off, or 0
  std::size_t first_scanned = 0;  ///< station at which a scan begins: below the kick-off, where both wells are one
};

/// The geometry of one pair of points. Centre lines within a micrometre of each other meet: D = 0 there.
struct PairPoints {
  PathPoint reference, offset;
  PathEnd end = PathEnd::interior;  ///< where the closest point lies on the well that is not scanned
  int minimum = 1;                  ///< 1: the closest; 2 ...: local minima, farther and farther
  double distance = 0;              ///< D, m
  double bearing = 0;               ///< from the reference to the offset, from north, rad, [0, 2 pi); NaN without one
  double toolface = 0;  ///< atan2(lateral, high side) in the reference's frame, rad, [0, 2 pi); NaN without one
};

/// One pair of points in one formulation. Standard deviations are one sigma, m.
struct PairClearance {
  double sd_reference = 0, sd_offset = 0, sd_relative = 0;  ///< pedal radii
  double separation_factor = 0;
  double ellipse_separation = 0;  ///< m
  double sigma_distance = 0, mahalanobis = 0;
  double ellipsoid_factor = 0;  ///< NaN where the errors are not independent
};

/// The closest pair from a measured depth (m) of the scanned well.
PairPoints pair_at(const PairGeometry& geometry, ScanDirection direction, double md);

/// The pairs of a scan: from every station of the scanned well from geometry.first_scanned on, and from points `step`
/// metres apart along it (0: none), the closest point, and further local minima up to `keep` times
/// its distance. In order of depth, the closest first.
std::vector<PairPoints> scan(const PairGeometry& geometry, ScanDirection direction, double step, double keep);

/// `with_factor`: compute ellipsoid_factor, too.
PairClearance clearance_of(const PairGeometry& geometry, const PairErrors& errors, const PairPoints& points,
                           bool with_factor);

/// What is least along the scanned well.
enum class LeastOf { separation_factor, distance, mahalanobis };
inline constexpr std::array<LeastOf, 3> kLeastOf{LeastOf::separation_factor, LeastOf::distance, LeastOf::mahalanobis};

/// A least value at the stations of a scan, and over continuous depth of the scanned well between its first and last
/// station. NaN where no pair has a value.
struct Least {
  double at_station = 0, continuous = 0;  ///< of what is sought: m for the distance
  bool is_everywhere = true;              ///< every pair has a value: there is none that could be less
  PairPoints station_pair, pair;
};
/// Pairs at the stations of a scan and at the quarters of its legs.
std::vector<PairPoints> least_samples(const PairGeometry& geometry, ScanDirection direction);

/// In the order of kLeastOf. `pairs`: of scan() without further minima and points. `samples`: of least_samples().
///
/// Every local minimum among the samples is refined between its neighbours to 2^-24 of their distance (Brent).
std::array<Least, 3> least_clearance(const PairGeometry& geometry, const PairErrors& errors, ScanDirection direction,
                                     const std::vector<PairPoints>& pairs, const std::vector<PairPoints>& samples);

}  // namespace surveymc::proximity
