#pragma once
/// The toolface-independent (TI) sensor terms of the ISCWSA MWD error model (functions.toml): the twelve sensor errors
/// with the toolface averaged out. Only the sensors' terms; nowhere singular.
#include <array>
#include <vector>

#include "propagate/tangent_propagation.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"

namespace surveymc::propagate {

/// One term. The weights are per unit of the sensor error and of the pair x, y of equal sizes:
///   dI = inclination, sinI dA = lateral: the tangent moves along (cosI cosA, cosI sinA, -sinI) and (-sinA, cosA, 0).
struct ToolfaceIndependentTerm {
  const char* code;
  survey::SensorTerm kind;  ///< whose size it has; x and y are taken to be equal
  int axis;                 ///< 0: the cross-axis pair, 2: z
  bool with_toolface;       ///< a wave in toolface: random when the pipe is rotated between stations
  double inclination, lateral;
};

/// All 14 at one attitude. `azimuth` is magnetic. Revision 4 and later of the model (weighting functions of SPE 67616,
/// table 1, averaged as by Torkildsen and Bang 2000); lateral is the listed azimuth weight times sinI.
std::array<ToolfaceIndependentTerm, 14> toolface_independent_terms(double inclination, double azimuth,
                                                                   const survey::ReferenceField& field);

/// Propagation along the hole of the terms that change with toolface; the others are always constant.
enum class ToolfacePropagation {
  systematic,  ///< slid: one toolface for all stations; ISCWSA's S
  random,      ///< rotated: a toolface of its own at every station; ISCWSA's R
};

/// The terms at every station, for propagate_tangent_errors. sd: sizes; x and y of a kind must be equal (asserted).
std::vector<TangentErrors> toolface_independent_errors(const survey::Survey& survey,
                                                       const survey::ReferenceField& field,
                                                       const survey::SensorTermArray& sd,
                                                       ToolfacePropagation propagation);

}  // namespace surveymc::propagate
