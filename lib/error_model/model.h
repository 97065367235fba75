#pragma once
/// Instrument performance models as data: which error sources a survey tool has, how large they are, and by which
/// formulas each acts on a station's depth, inclination and azimuth (ISCWSA; OWSG tool codes).
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "error_model/dimension.h"
#include "error_model/expression.h"

namespace surveymc::error_model {

/// How an error at one station goes with that at another (ISCWSA's letters R, S, W, G).
enum class PropagationMode {
  random,      ///< R: another error at every station
  systematic,  ///< S: one error per survey leg (tool run)
  well,        ///< W: one error per well: joins across its legs
  global       ///< G: one error for all wells of the field: joins across legs as W does
};
/// 'R', 'S', 'W' or 'G'.
char mode_letter(PropagationMode mode);

/// True of an error that joins across the legs of a well.
inline bool joins_legs(PropagationMode mode) {
  return mode == PropagationMode::well || mode == PropagationMode::global;
}

/// What an error of one unit does, and how long it lasts.
enum class Kind {
  station,     ///< an error of the station's measurement: it moves the hole on both sides of the station
  course,      ///< of the course between two stations: its weight times the interval displaces the interval's end
  stationary,  ///< of a gyrocompass: a station's, but a hybrid gyro keeps the value of its initialisation
  continuous   ///< of a continuous gyro: a running sum since its section began
};
/// "station" ...
std::string kind_name(Kind kind);

/// A weighting function: the effect of one unit of an error source. Formulas that are not there are 0.
struct Function {
  std::string name;
  Kind kind = Kind::station;
  std::string axis;          ///< of a continuous function: the zones of the gyro in which it grows
  bool per_section = false;  ///< of a continuous function: the errors of two sections are independent (random walks)
  Expression depth;          ///< m
  Expression inclination;    ///< rad
  Expression azimuth;        ///< rad; times sinI it moves the hole
  Expression lateral;        ///< rad: sinI times the azimuth's weight in closed form, instead of `azimuth`
  /// Displacement by north and east over metres of the course, in place of all effects of angles below
  /// kVerticalLimit. With `azimuth` only.
  Expression vertical_north, vertical_east;
  Dimension magnitude;  ///< of a source with this function: magnitude_dimension()
  std::string file;     ///< where it is from, for tables

  /// The formula of the azimuth or of the lateral effect, whichever there is.
  const Expression& azimuth_or_lateral() const { return lateral.empty() ? azimuth : lateral; }
  /// Every formula, with its key.
  std::vector<std::pair<const char*, const Expression*>> formulas() const;
  bool names(Variable v) const;
};

/// Inclination (rad) below which a station counts as vertical: 0.0001 deg, as in the ISCWSA workbooks.
inline constexpr double kVerticalLimit = 0.0001 * kDegree;

/// One error source: a row of a model file.
struct Term {
  std::string code;                          ///< ISCWSA code, e.g. "ABXY-TI1S"
  std::shared_ptr<const Function> function;  ///< shared by the terms and models that name it
  double magnitude = 0;                      ///< one standard deviation, in `unit`
  std::string unit;                          ///< as written, e.g. "deg.nT"
  double sigma = 0;                          ///< the magnitude in SI units with radians and seconds
  PropagationMode mode = PropagationMode::random;
};

/// A range of inclinations in which a continuous gyro measures about one axis (or all: "XYZ").
struct GyroZone {
  std::string axis;
  double from = 0, to = 0;  ///< rad, from <= I < to; the last zone has no upper end
  double speed = 0;         ///< m/s along the hole
};

/// A gyro that is a compass in the upper hole and continuous beyond.
struct Gyro {
  /// rad: where it changes from the one to the other; nothing: it is initialised at the start of the leg.
  std::optional<double> initialise_at;
  std::vector<GyroZone> zones;
};

struct Parameters {
  double min_course_length = 10;                ///< m
  double tortuosity = kDegree / (100 * kFoot);  ///< rad/m: 1 deg / 100 ft
  double noise_reduction = 1;                   ///< of a continuous gyro's random errors, at its initialisation
};

struct Model {
  std::string name;       ///< as chosen: "MWD+IFR1"
  std::string catalogue;  ///< the file it is from, without folder and ending
  std::string title, source, prefix, revision, date, tool, note;
  /// Inclination and azimuth of the first station stand for the whole interval from the tie-on, which has no error:
  /// their part of dr_1/dp_1 counts twice (ISCWSA Rev 5, not Rev 4). The depth part never does.
  bool first_leg_doubled = false;
  double inclination_min = 0, inclination_max = kPi;  ///< rad: where the model holds
  double east_west_exclusion = 0;  ///< rad: it does not hold within this angle of horizontal magnetic east or west
  Parameters parameters;
  std::optional<Gyro> gyro;
  std::vector<Term> terms;  ///< none: a tool without errors

  bool names(Variable v) const;
};

/// Angle (rad) between the hole and horizontal magnetic east or west, whichever is nearer.
double angle_to_east_west(double inclination, double magnetic_azimuth);

// ------------------------------------------------------------------------------------------------------- units

/// The dimension of the magnitude of a source with this function: magnitude times formula is metres for depth and a
/// pure number for all else. Throws FormulaError where the formulas want different ones, or have none.
Dimension magnitude_dimension(const Function& f);
/// Factor from `unit` to SI for a magnitude of this dimension; 0 if it is none of its units.
double unit_factor(const Dimension& dimension, const std::string& unit);
/// The units of a dimension, for messages: `"m" or "ft"`; the dimension's own text where no unit has it.
std::string unit_names(const Dimension& dimension);

}  // namespace surveymc::error_model
