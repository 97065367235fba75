#pragma once
/// The reference field of a config: by its numbers, or by the place and date of the well.
#include <optional>

#include "config/config.h"
#include "earth/geomagnetic_model.h"
#include "store/table.h"
#include "survey/reference_field.h"

namespace surveymc::scenario {

/// The reference field at a place and date, with its origin.
struct PlacedField {
  earth::Place place;
  double year = 0;  ///< decimal
  earth::MagneticField magnetic;
  earth::CompassZone zone = earth::CompassZone::none;
  survey::ReferenceField field;
};

/// `[field] model = "wmm2025", latitude_deg, longitude_deg, height_m (0, above the ellipsoid), date`, and what grid
/// north is by read_convergence(). Nothing where there is no field.model. Gravity is normal gravity of WGS84 at the
/// place. The blackout zone of the model is refused unless `field.blackout = "allow"`; the caution zone is a warning.
/// Throws InputError, also where one of the numbers that the model gives stands beside it.
std::optional<PlacedField> read_placed_field(config::ConfigReader& config);

/// A model's field at one height and date, for maps over places: nothing is refused near the magnetic poles, where the
/// horizontal field is small.
struct FieldOfPlaces {
  double height = 0;                                                   ///< m
  double year = 0;                                                     ///< decimal
  survey::ReferenceField at(double latitude, double longitude) const;  ///< rad; convergence 0
};
/// `[field] model = "wmm2025", height_m (0), date` of a config whose places stand elsewhere. Throws InputError, also
/// where one of the numbers that the model gives, or a place, stands beside it.
FieldOfPlaces read_field_of_places(config::ConfigReader& config);

/// `field.convergence_deg` (0), or `field.grid = { crs = "utm", zone }` (zone: that of the place), which needs
/// `latitude_deg` and `longitude_deg`: rad.
double read_convergence(config::ConfigReader& config);

/// `[field] total_nT, dip_deg, declination_deg (0), gravity_mps2 (9.80665)` and read_convergence(), or the field of a
/// place: read_placed_field().
survey::ReferenceField read_field(config::ConfigReader& config);

/// The same for a study whose azimuths are from magnetic north: a declination other than 0 is refused; that of a model
/// has no meaning there.
survey::ReferenceField read_field_of_magnetic_north(config::ConfigReader& config);

/// Sizes of a model's error as draws of the reference: one standard deviation.
struct ReferenceSize {
  double total = 0;  ///< nT
  double dip = 0;    ///< rad
};

/// Sizes that the name "wmm2025" stands for.
ReferenceSize reference_size(const std::string& name);
inline const std::vector<std::string> kFieldModels{"wmm2025"};

/// Table `reference_field`, one row: place, date, what studies take from them, the model's sds. Table
/// `magnetic_elements`: the seven elements, their change in a year, the model's sds.
std::vector<store::Table> field_tables(const PlacedField& field);

}  // namespace surveymc::scenario
