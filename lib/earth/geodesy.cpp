#include "earth/geodesy.h"

#include <cmath>

#include <GeographicLib/Math.hpp>
#include <GeographicLib/NormalGravity.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include "base/units.h"

namespace surveymc::earth {
namespace {

double central_meridian_deg(int zone) { return 6.0 * zone - 183; }

}  // namespace

double normal_gravity(const Place& place) {
  double north = 0, up = 0;  // of the vector: it leans to the equator above the ellipsoid
  GeographicLib::NormalGravity::WGS84().Gravity(place.latitude / kDegree, place.height, north, up);
  return std::hypot(north, up);
}

bool has_utm(const Place& place) { return place.latitude >= -80 * kDegree && place.latitude <= 84 * kDegree; }

int utm_zone(const Place& place) {
  return GeographicLib::UTMUPS::StandardZone(place.latitude / kDegree, place.longitude / kDegree,
                                             GeographicLib::UTMUPS::UTM);
}

double distance_from_central_meridian(const Place& place, int zone) {
  return std::abs(GeographicLib::Math::AngDiff(central_meridian_deg(zone), place.longitude / kDegree)) * kDegree;
}

double utm_convergence(const Place& place, int zone) {
  double x = 0, y = 0, convergence = 0, scale = 0;
  GeographicLib::TransverseMercator::UTM().Forward(central_meridian_deg(zone), place.latitude / kDegree,
                                                   place.longitude / kDegree, x, y, convergence, scale);
  return convergence * kDegree;
}

}  // namespace surveymc::earth
