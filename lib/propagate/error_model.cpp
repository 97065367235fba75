#include "propagate/error_model.h"

#include <array>

#include "base/units.h"

namespace surveymc::propagate {
namespace {

struct Unit {
  Quantity quantity;
  const char* name;
  double factor;
};
constexpr std::array<Unit, 12> kUnits{{{Quantity::length, "m", 1},
                                       {Quantity::length, "ft", kFoot},
                                       {Quantity::per_length, "1/m", 1},
                                       {Quantity::per_length, "1/ft", 1 / kFoot},
                                       {Quantity::ratio, "-", 1},
                                       {Quantity::acceleration, "m/s2", 1},
                                       {Quantity::magnetic_field, "nT", 1},
                                       {Quantity::magnetic_field, "uT", 1000},
                                       {Quantity::angle, "deg", kDegree},
                                       {Quantity::angle, "rad", 1},
                                       {Quantity::angle_by_field, "deg.nT", kDegree},
                                       {Quantity::angle_by_field, "rad.nT", 1}}};

}  // namespace

double unit_factor(Quantity quantity, const std::string& unit) {
  for (const Unit& u : kUnits)
    if (u.quantity == quantity && unit == u.name) return u.factor;
  return 0;
}

std::string unit_names(Quantity quantity) {
  std::string names;
  for (const Unit& u : kUnits)
    if (u.quantity == quantity) names += (names.empty() ? "\"" : " or \"") + std::string(u.name) + "\"";
  return names;
}

char mode_letter(PropagationMode mode) {
  switch (mode) {
    case PropagationMode::random:
      return 'R';
    case PropagationMode::systematic:
      return 'S';
    case PropagationMode::well:
      return 'W';
    case PropagationMode::global:
      break;
  }
  return 'G';
}

}  // namespace surveymc::propagate
