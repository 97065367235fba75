#include "earth/geomagnetic_model.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "earth/shipped_geomagnetic_models.h"

using namespace surveymc;
using namespace surveymc::earth;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A row of WMM2025_TEST_VALUES, which NOAA's National Centers for Environmental Information publish with the model
/// (https://www.ncei.noaa.gov/products/world-magnetic-model): public domain. About a quarter of the table.
struct PublishedRow {
  double year, height_km, latitude, longitude;                           // above the ellipsoid; degrees
  double declination, dip;                                               // degrees, to 0.01
  double horizontal, north, east, down, total;                           // nT
  double declination_rate, dip_rate;                                     // degrees a year
  double horizontal_rate, north_rate, east_rate, down_rate, total_rate;  // nT a year
};
constexpr PublishedRow kPublished[] = {
    {2025, 28, 89, -121, -99.77, 88.47, 1504.298146, -255.388723, -1482.460628, 56194.288771, 56214.419888, 2.491706,
     -0.009987, 10.28564, 62.723738, -21.242793, 18.075146, 18.343917},
    {2025, 54, 82, 87, 54.89, 87.68, 2302.427342, 1324.336929, 1883.42862, 56740.772059, 56787.4668, 0.884574, 0.03613,
     -34.169939, -48.732002, -7.505574, 41.134755, 39.715524},
    {2025, 51, -33, 109, -5.49, -67.5, 21838.046477, 21737.778822, -2090.274098, -52710.00392, 57054.752538, 0.069861,
     0.026375, 29.809763, 32.221578, 23.651711, -3.33404, 14.490015},
    {2025, 3, -50, -103, 27.96, -54.89, 22106.041373, 19526.532799, 10362.99098, -31437.562789, 38431.724126, -0.032104,
     0.024888, -42.140973, -31.417096, -30.696074, 88.952383, -97.003616},
    {2025.5, 8, -52, -75, 14.91, -49.63, 20005.506364, 19331.857134, 5147.774727, -23532.664273, 30886.996822,
     -0.098427, -0.028885, -58.502212, -47.688987, -48.263512, 44.775999, -72.006513},
    {2025.5, 22, -37, 140, 9.28, -68.62, 21688.84759, 21404.761773, 3498.89743, -55397.58776, 59492.006517, 0.028818,
     0.004094, 0.393984, -1.37102, 10.829532, 10.653875, -9.77701},
    {2026, 69, 23, 63, 1.17, 35.92, 34565.858527, 34558.605297, 708.078839, 25043.405885, 42684.54936, 0.013234,
     0.010624, 23.857027, 23.688475, 8.470762, 27.058242, 35.194683},
    {2026, 83, 86, -46, -30.61, 86.84, 3000.255301, 2582.099403, -1527.839829, 54279.308437, 54362.16383, 1.221388,
     -0.002547, 3.280093, 35.392266, 53.372894, 15.551936, 15.709262},
    {2026.5, 14, 0, 80, -3.1, -17.15, 39489.089663, 39431.415992, -2133.456168, -12188.838466, 41327.424134, 0.056431,
     0.021103, 33.618195, 35.670346, 37.019904, 5.553327, 30.484922},
    {2026.5, 44, -46, -42, -11.36, -54.39, 14140.316272, 13863.176808, -2785.834358, -19744.304022, 24285.511845,
     0.039043, -0.119143, -63.277988, -60.139435, 21.913412, 1.623579, -38.163791},
    {2026.5, 12, -79, 115, -137.58, -77.37, 13023.480845, -9613.650418, -8785.714482, -58104.306533, 59545.961164,
     -0.241722, 0.014808, 7.471685, -42.581077, 35.51814, 37.027107, -34.496496},
    {2027, 37, -66, -5, -17.22, -59.04, 17159.8365, 16390.771268, -5079.626554, -28608.243575, 33360.029814, -0.04363,
     0.039964, -2.074991, -5.850093, -11.867216, 48.69553, -42.826703},
    {2027, 44, 22, 174, 6.46, 31.89, 28867.487799, 28683.97251, 3249.857362, 17961.198575, 33999.066253, -0.024375,
     -0.000168, 2.815221, 4.179894, -11.885941, 1.634357, 3.253718},
    {2027, 12, -63, 178, 57.87, -79.14, 11720.691727, 6233.774935, 9925.455386, -61075.730989, 62190.188377, 0.151793,
     0.036783, 27.353301, -11.747306, 39.678751, 69.308326, -62.911163},
    {2027.5, 8, 62, 53, 19.39, 76.67, 12997.751893, 12260.425578, 4315.497527, 54849.810218, 56368.814385, 0.099601,
     0.030088, -12.884268, -19.655269, 17.035218, 74.003425, 69.038304},
    {2027.5, 16, 66, -178, 0.37, 75.67, 13821.614337, 13821.326215, 89.244328, 54092.646409, 55830.559897, -0.327448,
     0.003026, -1.280867, -0.770805, -78.997758, 6.899408, 6.367545},
    {2028, 21, 6, -32, -14.34, -8.7, 28453.070088, 27567.09426, -7045.034525, -4352.046687, 28783.980055, 0.17796,
     -0.31147, -29.041854, -6.255704, 92.814073, -153.852374, -5.445988},
    {2028.5, 39, -65, -88, 29.45, -60.2, 20609.270068, 17946.905687, 10131.662696, -35982.872979, 41466.964689,
     -0.076076, 0.014457, -36.693634, -18.500934, -41.868201, 85.117374, -92.097328},
    {2028.5, 65, 48, 148, -9.55, 61.79, 23693.546804, 23365.16701, -3931.047029, 44177.553125, 50130.233993, -0.040524,
     0.019409, 4.495479, 1.652822, -17.271572, 44.310648, 41.173752},
    {2029, 50, 87, -154, -73.48, 89.07, 906.920459, 257.87742, -869.484879, 55992.308183, 55999.652503, 1.562405,
     -0.064156, 62.930173, 41.603892, -53.300475, 13.406039, 14.423442},
    {2029, 49, -50, -179, 32.11, -71.33, 18080.59379, 15315.042731, 9610.272521, -53522.651338, 56494.088877, 0.110906,
     0.012602, -5.111774, -22.932228, 26.927867, 53.95627, -52.754307},
    {2029.5, 51, -76, 40, -56.34, -66.22, 18517.441118, 10263.650094, -15412.758102, -42018.541264, 45917.898858,
     -0.148779, 0.015688, 0.140771, -39.943896, -26.768531, 30.856345, -28.179249},
    {2029.5, 18, 9, -172, 9.24, 15.85, 30922.51441, 30520.999126, 4966.941695, 8779.472279, 32144.689001, -0.000053,
     0.016657, -17.13715, -16.910013, -2.781046, 4.848633, -15.161302},
    {2029.5, 33, 17, 5, 0.89, 13.77, 34026.126581, 34021.976056, 531.446418, 8341.137769, 35033.582023, 0.078642,
     0.026998, 3.099752, 2.369935, 46.745426, 17.756374, 7.238224},
};

Place place_of(const PublishedRow& r) { return {r.latitude * kDegree, r.longitude * kDegree, r.height_km * 1000}; }

}  // namespace

TEST_CASE("WMM2025 gives the published test values") {
  // East agrees to its last printed digit. The printed north components scatter about the model by up to 5.2e-4 nT
  // (1e-8 of the field), and so do H and F, which hold them, and down by 1/300 of it, the tilt of the ellipsoid's
  // normal: two independent summations of the coefficients (GeographicLib's and a plain one) agree with each other to
  // 1e-8 nT.
  constexpr double kLastDigit = 1.5e-6, kScatterOfNorth = 6e-4, kScatterOfDown = 3e-6, kRateDigit = 2.1e-6;  // nT
  for (const PublishedRow& r : kPublished) {
    CAPTURE(r.year, r.latitude, r.longitude);
    const MagneticField field = wmm2025().field(place_of(r), r.year);
    const MagneticElements e = magnetic_elements(field.vector);
    CHECK_THAT(e.vector.north, WithinAbs(r.north, kScatterOfNorth));
    CHECK_THAT(e.vector.east, WithinAbs(r.east, kLastDigit));
    CHECK_THAT(e.vector.down, WithinAbs(r.down, kScatterOfDown));
    CHECK_THAT(e.horizontal, WithinAbs(r.horizontal, kScatterOfNorth));
    CHECK_THAT(e.total, WithinAbs(r.total, kScatterOfNorth));
    CHECK_THAT(e.declination / kDegree, WithinAbs(r.declination, 0.005001));
    CHECK_THAT(e.dip / kDegree, WithinAbs(r.dip, 0.005001));
    const MagneticElements rate = elements_per_year(field.vector, field.per_year);
    CHECK_THAT(rate.vector.north, WithinAbs(r.north_rate, kRateDigit));
    CHECK_THAT(rate.vector.east, WithinAbs(r.east_rate, kRateDigit));
    CHECK_THAT(rate.vector.down, WithinAbs(r.down_rate, kRateDigit));
    CHECK_THAT(rate.horizontal, WithinAbs(r.horizontal_rate, kRateDigit));
    CHECK_THAT(rate.total, WithinAbs(r.total_rate, kRateDigit));
    CHECK_THAT(rate.declination / kDegree, WithinAbs(r.declination_rate, 0.5001e-6));
    CHECK_THAT(rate.dip / kDegree, WithinAbs(r.dip_rate, 0.5001e-6));
  }
}

TEST_CASE("The rates of the elements are their differences") {
  const Place place{60 * kDegree, 3 * kDegree, 0};
  const MagneticField field = wmm2025().field(place, 2027);
  const MagneticElements rate = elements_per_year(field.vector, field.per_year);
  // Second differences of an element are some 1e-2 nT and 1e-7 rad in a year, so that central ones of 1/100 year are
  // right to 1e-6 and 1e-11; rounding of 5e4 nT adds 1e-9.
  const double h = 0.01;
  const MagneticElements before = magnetic_elements(wmm2025().field(place, 2027 - h).vector),
                         after = magnetic_elements(wmm2025().field(place, 2027 + h).vector);
  CHECK_THAT(rate.total, WithinAbs((after.total - before.total) / (2 * h), 1e-6));
  CHECK_THAT(rate.horizontal, WithinAbs((after.horizontal - before.horizontal) / (2 * h), 1e-6));
  CHECK_THAT(rate.dip, WithinAbs((after.dip - before.dip) / (2 * h), 1e-11));
  CHECK_THAT(rate.declination, WithinAbs((after.declination - before.declination) / (2 * h), 1e-11));
}

TEST_CASE("At the poles and the date line the field is the limit of its neighbours") {
  for (const double pole : {-90.0, 90.0}) {
    const double off = pole * (1 - 1e-9);  // 1e-2 m away: the gradient of 1e-2 nT a metre is the bound
    for (const double longitude : {-180.0, -30.0, 0.0, 90.0, 250.0}) {
      const MagneticVector at = wmm2025().field({pole * kDegree, longitude * kDegree, 0}, 2026).vector,
                           near = wmm2025().field({off * kDegree, longitude * kDegree, 0}, 2026).vector;
      CHECK_THAT(at.north, WithinAbs(near.north, 1e-3));
      CHECK_THAT(at.east, WithinAbs(near.east, 1e-3));
      CHECK_THAT(at.down, WithinAbs(near.down, 1e-3));
    }
  }
  const MagneticVector west = wmm2025().field({0.5, -kPi, 0}, 2026).vector,
                       east = wmm2025().field({0.5, kPi, 0}, 2026).vector;
  CHECK_THAT(west.north, WithinRel(east.north, 1e-12));
  CHECK_THAT(west.east, WithinRel(east.east, 1e-12));
}

TEST_CASE("The zones of the compass and the model's uncertainty") {
  CHECK(compass_zone(1999.9) == CompassZone::blackout);
  CHECK(compass_zone(2000) == CompassZone::caution);
  CHECK(compass_zone(5999.9) == CompassZone::caution);
  CHECK(compass_zone(6000) == CompassZone::none);
  const MagneticUncertainty sd = wmm2025_uncertainty(10000);
  CHECK(sd.total == 138);
  CHECK_THAT(sd.dip, WithinRel(0.20 * kDegree, 1e-15));
  CHECK_THAT(sd.declination / kDegree, WithinRel(std::sqrt(0.26 * 0.26 + 0.5417 * 0.5417), 1e-14));
}

TEST_CASE("WMM2025 is valid from 2025.0 to 2030.0, both ends included") {
  CHECK(wmm2025().name() == "WMM-2025");
  CHECK(wmm2025().is_valid_in(2025.0));
  CHECK(wmm2025().is_valid_in(2030.0));
  CHECK_FALSE(wmm2025().is_valid_in(2024.999));
  CHECK_FALSE(wmm2025().is_valid_in(2030.001));
}

TEST_CASE("A coefficient file with a line that is wrong, missing or there twice is refused") {
  const std::string good(shipped_wmm2025());
  const auto with = [&](const std::string& a, const std::string& b) {
    std::string text = good;
    text.replace(text.find(a), a.size(), b);
    return text;
  };
  CHECK_NOTHROW(GeomagneticModel(good));
  CHECK_THROWS_WITH(GeomagneticModel(with("  1  1   -1410.8", "  1  2   -1410.8")),
                    Contains("degree 1, order 2: must be 1 to 12 and 0 to the degree"));
  CHECK_THROWS_WITH(GeomagneticModel(with("  1  1   -1410.8", "  1  0   -1410.8")), Contains("are there twice"));
  CHECK_THROWS_WITH(GeomagneticModel(with("  1  1   -1410.8", "# 1  1   -1410.8")),
                    Contains("has 89 of the 90 coefficients"));
  CHECK_THROWS_WITH(GeomagneticModel(with("  1  1   -1410.8", "  1  1   nought ")), Contains("must be: n m g h"));
  CHECK_THROWS_AS(GeomagneticModel(""), InputError);
}
