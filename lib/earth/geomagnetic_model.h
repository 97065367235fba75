#pragma once
/// The Earth's main magnetic field by a spherical harmonic model, of which the program brings WMM2025.
/// GeographicLib sums the harmonics. What is not modelled: the crust's field, and that of currents above the ground.
#include <memory>
#include <string>

#include "earth/geodesy.h"

namespace surveymc::earth {

/// A magnetic vector in the local frame of a place: geodetic north, east, down.
struct MagneticVector {
  double north = 0, east = 0, down = 0;  ///< nT, or nT a year
};

/// The seven elements of a field: north X, east Y, down Z, horizontal H, total F, declination D, dip I.
struct MagneticElements {
  MagneticVector vector;             ///< nT
  double horizontal = 0, total = 0;  ///< nT
  double declination = 0;            ///< rad, from north, positive east, in (-pi, pi]
  double dip = 0;                    ///< rad, positive down
};
MagneticElements magnetic_elements(const MagneticVector& vector);

/// What one year adds to each element, to first order: nT, rad.
MagneticElements elements_per_year(const MagneticVector& vector, const MagneticVector& per_year);

/// A field and its secular variation.
struct MagneticField {
  MagneticVector vector;    ///< nT
  MagneticVector per_year;  ///< nT a year
};

/// Where a compass is unreliable near the magnetic poles, by the horizontal field: WMM's specification (MIL-PRF-89500B)
/// calls it a caution zone below 6000 nT, and a blackout zone below 2000 nT.
enum class CompassZone { none, caution, blackout };
CompassZone compass_zone(double horizontal);
inline constexpr double kCautionBelow = 6000, kBlackoutBelow = 2000;  ///< nT

/// One standard deviation of what WMM2025 says of an element, over the globe and the model's five years, against what a
/// compass sees: crust and daily variation are in it. Source: NOAA's error model of WMM2025 (technical report, section
/// on the model's uncertainties).
struct MagneticUncertainty {
  double north = 137, east = 89, down = 141, horizontal = 133, total = 138;  ///< nT
  double dip = 0;                                                            ///< rad: 0.20 degrees
  double declination = 0;                                                    ///< rad: sqrt(0.26^2 + (5417 nT/H)^2) deg
};
MagneticUncertainty wmm2025_uncertainty(double horizontal);

class GeomagneticModel {
 public:
  /// From the text of a coefficient file in the form of WMM.COF: a line "epoch name date", lines
  /// "n m g h dg/dt dh/dt" in nT and nT a year, and a line of nines. Lines that begin with # are comments. Throws
  /// InputError.
  explicit GeomagneticModel(const std::string& text);
  ~GeomagneticModel();
  GeomagneticModel(GeomagneticModel&&) noexcept;

  const std::string& name() const;  ///< as in the file: "WMM-2025"
  double epoch() const;             ///< decimal year; the model is valid for five years from it
  double end() const;
  bool is_valid_in(double year) const { return year >= epoch() && year <= end(); }

  /// Field at the place in the decimal year: coefficients grow linearly with time from the epoch.
  MagneticField field(const Place& place, double year) const;

 private:
  struct Harmonics;
  std::unique_ptr<Harmonics> harmonics_;
};

/// The World Magnetic Model that comes with the program (lib/earth/wmm2025.cof), read at the first call.
const GeomagneticModel& wmm2025();

}  // namespace surveymc::earth
