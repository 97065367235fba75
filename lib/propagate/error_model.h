#pragma once
/// Instrument performance models as data: which error sources a survey tool has, how large they are, and how each
/// acts on a station's depth, inclination and azimuth (ISCWSA; weighting functions of SPE 67616 and its revisions).
#include <string>
#include <vector>

#include "propagate/error_sum.h"
#include "propagate/weighting_functions.h"

namespace surveymc::propagate {

/// One error source: a row of a model file.
struct ErrorTerm {
  std::string code;                             ///< ISCWSA code, e.g. "ABXY-TI1S"
  const WeightingFunction* function = nullptr;  ///< of weighting_functions()
  double magnitude = 0;                         ///< one standard deviation, in `unit`
  std::string unit;                             ///< as written, e.g. "deg.nT"
  double sigma = 0;                             ///< the magnitude in SI units: m, rad, m/s2, nT, rad nT, 1/m, 1
  PropagationMode mode = PropagationMode::random;
};

struct ErrorModel {
  std::string title, source;
  /// Inclination and azimuth of the first station stand for the whole leg from the tie-on, which has no error: their
  /// part of dr_1/dp_1 counts twice (ISCWSA Rev 5, not Rev 4). The depth part never does.
  bool first_leg_doubled = false;
  std::vector<ErrorTerm> terms;
};

/// Factor from `unit` to SI for a magnitude of this quantity; 0 if it is none of its units.
double unit_factor(Quantity quantity, const std::string& unit);
/// The units of a quantity, for messages: "deg or rad".
std::string unit_names(Quantity quantity);

/// 'R', 'S', 'W' or 'G'.
char mode_letter(PropagationMode mode);

}  // namespace surveymc::propagate
