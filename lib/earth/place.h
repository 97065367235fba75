#pragma once
namespace surveymc::earth {

/// A place on or near the Earth, in WGS84.
struct Place {
  double latitude = 0;   ///< geodetic, rad, north positive
  double longitude = 0;  ///< rad, east positive
  double height = 0;     ///< above the ellipsoid (not above sea level), m
};

}  // namespace surveymc::earth
