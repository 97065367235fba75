#pragma once
/// A place, and its normal gravity and grid north. GeographicLib computes both.
namespace surveymc::earth {

/// A place on or near the Earth, in WGS84.
struct Place {
  double latitude = 0;   ///< geodetic, rad, north positive
  double longitude = 0;  ///< rad, east positive
  double height = 0;     ///< above the ellipsoid (not above sea level), m
};

/// Size of normal gravity of WGS84 at the place, m/s2: that of the ellipsoid with the Earth's mass and rotation,
/// continued to the place's height in free air. What is not modelled: anomalies of gravity (some 1e-4 of it), and the
/// rock above a place below the ground.
double normal_gravity(const Place& place);

/// Where the universal transverse Mercator grid is used: from 80 degrees south to 84 degrees north.
bool has_utm(const Place& place);

/// The UTM zone (1 to 60) that a place belongs to, with the exceptions of southern Norway and Svalbard.
int utm_zone(const Place& place);

/// How far the place lies from the central meridian of a UTM zone, rad, without sign.
double distance_from_central_meridian(const Place& place, int zone);

/// Meridian convergence of the UTM grid of `zone` at the place, rad: bearing of grid north, clockwise from true north,
/// so that true azimuth = grid azimuth + convergence. `place` is at most 90 degrees from the central meridian.
double utm_convergence(const Place& place, int zone);

}  // namespace surveymc::earth
