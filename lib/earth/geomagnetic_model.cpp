#include "earth/geomagnetic_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>
#include <vector>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/SphericalHarmonic.hpp>

#include "base/error.h"
#include "base/units.h"
#include "earth/shipped_geomagnetic_models.h"

namespace surveymc::earth {

MagneticElements magnetic_elements(const MagneticVector& v) {
  const double horizontal = std::hypot(v.north, v.east);
  return {v, horizontal, std::hypot(horizontal, v.down), std::atan2(v.east, v.north), std::atan2(v.down, horizontal)};
}

MagneticElements elements_per_year(const MagneticVector& v, const MagneticVector& rate) {
  const MagneticElements now = magnetic_elements(v);
  const double horizontal = (v.north * rate.north + v.east * rate.east) / now.horizontal;
  return {rate, horizontal, (now.horizontal * horizontal + v.down * rate.down) / now.total,
          (v.north * rate.east - v.east * rate.north) / (now.horizontal * now.horizontal),
          (now.horizontal * rate.down - v.down * horizontal) / (now.total * now.total)};
}

CompassZone compass_zone(double horizontal) {
  return horizontal < kBlackoutBelow  ? CompassZone::blackout
         : horizontal < kCautionBelow ? CompassZone::caution
                                      : CompassZone::none;
}

MagneticUncertainty wmm2025_uncertainty(double horizontal) {
  MagneticUncertainty sd;
  sd.dip = 0.20 * kDegree;
  sd.declination = std::hypot(0.26, 5417 / horizontal) * kDegree;
  return sd;
}

/// Coefficients as GeographicLib wants them: by columns of one order m, without the sines of order 0.
struct GeomagneticModel::Harmonics {
  static constexpr int kDegreeOfModel = 12;
  static constexpr double kReferenceRadius = 6371200;  // m
  static constexpr double kYears = 5;
  static constexpr std::size_t kCosines = (kDegreeOfModel + 1) * (kDegreeOfModel + 2) / 2;
  static constexpr std::size_t kSines = kCosines - (kDegreeOfModel + 1);

  std::string name;
  double epoch = 0;
  std::vector<double> g = std::vector<double>(kCosines), h = std::vector<double>(kSines), g_rate = g, h_rate = h;
  GeographicLib::SphericalHarmonic main, rate;  // they refer to the vectors

  explicit Harmonics(const std::string& text) {
    std::istringstream lines(text);
    lines.imbue(std::locale::classic());
    std::string line;
    int number = 0;
    std::array<bool, kCosines> seen{};
    while (std::getline(lines, line)) {
      ++number;
      if (line.empty() || line.front() == '#') continue;
      if (line.starts_with("9999")) break;
      std::istringstream words(line);
      words.imbue(std::locale::classic());
      if (name.empty()) {
        require(static_cast<bool>(words >> epoch >> name), "geomagnetic model, line {}: must be: epoch name date",
                number);
        continue;
      }
      int n = 0, m = 0;
      std::array<double, 4> c{};
      require(static_cast<bool>(words >> n >> m >> c[0] >> c[1] >> c[2] >> c[3]),
              "geomagnetic model, line {}: must be: n m g h dg/dt dh/dt", number);
      require(n >= 1 && n <= kDegreeOfModel && m >= 0 && m <= n,
              "geomagnetic model, line {}: degree {}, order {}: must be 1 to {} and 0 to the degree", number, n, m,
              kDegreeOfModel);
      const auto column = static_cast<std::size_t>(m * kDegreeOfModel - m * (m - 1) / 2 + n);
      require(!seen[column], "geomagnetic model, line {}: degree {}, order {}: are there twice", number, n, m);
      seen[column] = true;
      g[column] = c[0];
      g_rate[column] = c[2];
      if (m == 0) continue;
      const std::size_t sine = column - (kDegreeOfModel + 1);
      h[sine] = c[1];
      h_rate[sine] = c[3];
    }
    const auto terms = std::count(seen.begin(), seen.end(), true);
    require(terms == kCosines - 1, "geomagnetic model: has {} of the {} coefficients of degree {}", terms, kCosines - 1,
            kDegreeOfModel);
    main = GeographicLib::SphericalHarmonic(g, h, kDegreeOfModel, kReferenceRadius,
                                            GeographicLib::SphericalHarmonic::SCHMIDT);
    rate = GeographicLib::SphericalHarmonic(g_rate, h_rate, kDegreeOfModel, kReferenceRadius,
                                            GeographicLib::SphericalHarmonic::SCHMIDT);
  }
};

GeomagneticModel::GeomagneticModel(const std::string& text) : harmonics_(std::make_unique<Harmonics>(text)) {}
GeomagneticModel::~GeomagneticModel() = default;
GeomagneticModel::GeomagneticModel(GeomagneticModel&&) noexcept = default;

const std::string& GeomagneticModel::name() const { return harmonics_->name; }
double GeomagneticModel::epoch() const { return harmonics_->epoch; }
double GeomagneticModel::end() const { return harmonics_->epoch + Harmonics::kYears; }

MagneticField GeomagneticModel::field(const Place& place, double year) const {
  const Harmonics& h = *harmonics_;
  const GeographicLib::Geocentric& earth = GeographicLib::Geocentric::WGS84();
  std::array<double, 3> at{};
  // Thread-local, because GeographicLib asks for a vector and a place a microsecond should not allocate one.
  thread_local std::vector<double> rotation(9);  // columns: east, north, up in geocentric axes
  earth.Forward(place.latitude / kDegree, place.longitude / kDegree, place.height, at[0], at[1], at[2], rotation);
  const auto local = [&](const std::array<double, 3>& gradient, double scale) {
    const auto along = [&](std::size_t axis) {
      return scale *
             (rotation[axis] * gradient[0] + rotation[3 + axis] * gradient[1] + rotation[6 + axis] * gradient[2]);
    };
    return MagneticVector{along(1), along(0), -along(2)};
  };
  // The field is minus the gradient of the potential a * sum; GeographicLib gives the gradient of the sum.
  std::array<double, 3> of_main{}, of_rate{};
  h.main(at[0], at[1], at[2], of_main[0], of_main[1], of_main[2]);
  h.rate(at[0], at[1], at[2], of_rate[0], of_rate[1], of_rate[2]);
  MagneticField field{local(of_main, -Harmonics::kReferenceRadius), local(of_rate, -Harmonics::kReferenceRadius)};
  const double years = year - h.epoch;
  field.vector.north += years * field.per_year.north;
  field.vector.east += years * field.per_year.east;
  field.vector.down += years * field.per_year.down;
  return field;
}

const GeomagneticModel& wmm2025() {
  static const GeomagneticModel model{std::string(shipped_wmm2025())};
  return model;
}

}  // namespace surveymc::earth
