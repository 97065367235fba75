#include "earth/geographic_probe.h"

#include "base/units.h"
#include "earth/geodesy.h"
#include "earth/geomagnetic_model.h"

namespace surveymc::earth {

std::vector<double> geographic_probe() {
  constexpr int kPlaces = 64;
  constexpr double kYear = 2026.3;
  std::vector<double> values;
  for (int i = 0; i < kPlaces; ++i) {
    const Place place{(-79 + 2.5 * i) * kDegree, (-175 + 5.5 * i) * kDegree, 37.0 * i};
    const MagneticVector field = wmm2025().field(place, kYear).vector;
    for (const double x :
         {field.north, field.east, field.down, normal_gravity(place), utm_convergence(place, utm_zone(place))})
      values.push_back(x);
  }
  return values;
}

}  // namespace surveymc::earth
