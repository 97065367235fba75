#include "propagate/toolface_independent.h"

#include <cassert>
#include <cmath>

namespace surveymc::propagate {

namespace {

/// sinI, cosI, sin and cos of the magnetic azimuth, and the field.
struct Geometry {
  double sin_i, cos_i, sin_am, cos_am, gravity, tan_dip, horizontal_field;
};
/// Of inclination and lateral (sinI times that of azimuth), rad per unit.
struct Weights {
  double inclination, lateral;
};
using G = Geometry;
constexpr double kSqrt2 = 1.41421356237309505;

/// Errors of accelerometers that change only the measured inclination, by w, and with it the azimuth: an inclination
/// error w turns the azimuth by -w tanD sinAm.
Weights tilt(const G& s, double w) { return {w, -w * s.tan_dip * s.sin_i * s.sin_am}; }
/// Errors of the measured azimuth alone.
Weights turn(double lateral) { return {0, lateral}; }

struct Kind {
  const char* code;
  survey::SensorTerm kind;
  int axis;
  bool with_toolface;
  Weights (*weights)(const Geometry&);
};
/// The formulas of configs/error_models/functions.toml in closed form (held together by a test).
constexpr std::array<Kind, 14> kKinds{{
    {"ABXY-TI1", survey::kAccelerometerBias, 0, true, [](const G& s) { return tilt(s, -s.cos_i / s.gravity); }},
    {"ABXY-TI2", survey::kAccelerometerBias, 0, true,
     [](const G& s) { return turn((s.cos_i - s.tan_dip * s.sin_i * s.cos_am) / s.gravity); }},
    {"ABZ", survey::kAccelerometerBias, 2, false, [](const G& s) { return tilt(s, -s.sin_i / s.gravity); }},
    {"ASXY-TI1", survey::kAccelerometerScale, 0, false, [](const G& s) { return tilt(s, s.sin_i * s.cos_i / kSqrt2); }},
    {"ASXY-TI2", survey::kAccelerometerScale, 0, true, [](const G& s) { return tilt(s, s.sin_i * s.cos_i / 2); }},
    {"ASXY-TI3", survey::kAccelerometerScale, 0, true,
     [](const G& s) { return turn(s.sin_i * (s.tan_dip * s.sin_i * s.cos_am - s.cos_i) / 2); }},
    {"ASZ", survey::kAccelerometerScale, 2, false, [](const G& s) { return tilt(s, -s.sin_i * s.cos_i); }},
    {"MBXY-TI1", survey::kMagnetometerBias, 0, true,
     [](const G& s) { return turn(-s.sin_i * s.cos_i * s.sin_am / s.horizontal_field); }},
    {"MBXY-TI2", survey::kMagnetometerBias, 0, true,
     [](const G& s) { return turn(s.sin_i * s.cos_am / s.horizontal_field); }},
    {"MBZ", survey::kMagnetometerBias, 2, false,
     [](const G& s) { return turn(-s.sin_i * s.sin_i * s.sin_am / s.horizontal_field); }},
    {"MSXY-TI1", survey::kMagnetometerScale, 0, false,
     [](const G& s) {
       return turn(s.sin_i * s.sin_i * s.sin_am * (s.tan_dip * s.cos_i + s.sin_i * s.cos_am) / kSqrt2);
     }},
    {"MSXY-TI2", survey::kMagnetometerScale, 0, true,
     [](const G& s) {
       return turn(s.sin_i * s.sin_am * (s.tan_dip * s.sin_i * s.cos_i - s.cos_i * s.cos_i * s.cos_am - s.cos_am) / 2);
     }},
    {"MSXY-TI3", survey::kMagnetometerScale, 0, true,
     [](const G& s) {
       return turn(s.sin_i * (s.cos_i * (s.cos_am * s.cos_am - s.sin_am * s.sin_am) - s.tan_dip * s.sin_i * s.cos_am) /
                   2);
     }},
    {"MSZ", survey::kMagnetometerScale, 2, false,
     [](const G& s) { return turn(-s.sin_i * s.sin_i * s.sin_am * (s.sin_i * s.cos_am + s.tan_dip * s.cos_i)); }},
}};

}  // namespace

std::array<ToolfaceIndependentTerm, 14> toolface_independent_terms(double inclination, double azimuth,
                                                                   const survey::ReferenceField& field) {
  const Geometry s{std::sin(inclination),
                   std::cos(inclination),
                   std::sin(azimuth),
                   std::cos(azimuth),
                   field.gravity,
                   std::tan(field.dip),
                   field.total * std::cos(field.dip)};
  std::array<ToolfaceIndependentTerm, 14> terms{};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Kind& k = kKinds[i];
    const Weights w = k.weights(s);
    terms[i] = {k.code, k.kind, k.axis, k.with_toolface, w.inclination, w.lateral};
  }
  return terms;
}

std::vector<TangentErrors> toolface_independent_errors(const survey::Survey& survey,
                                                       const survey::ReferenceField& field,
                                                       const survey::SensorTermArray& sd,
                                                       ToolfacePropagation propagation) {
  std::vector<TangentErrors> errors;
  for (const survey::Station& s : survey.stations) {
    const auto terms = toolface_independent_terms(s.inclination, s.azimuth - field.declination, field);
    const double si = std::sin(s.inclination), ci = std::cos(s.inclination), sa = std::sin(s.azimuth),
                 ca = std::cos(s.azimuth);
    const Eigen::Vector3d high(ci * ca, ci * sa, -si), right(-sa, ca, 0);
    TangentErrors e{Eigen::Matrix3Xd(3, 14), Eigen::Matrix3Xd::Zero(3, 14)};
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const auto kind = static_cast<std::size_t>(terms[i].kind), axis = static_cast<std::size_t>(terms[i].axis);
      assert(sd[kind] == sd[kind + 1]);
      e.constant.col(static_cast<Eigen::Index>(i)) =
          sd[kind + axis] * (terms[i].inclination * high + terms[i].lateral * right);
      if (propagation == ToolfacePropagation::random && terms[i].with_toolface)
        e.independent.col(static_cast<Eigen::Index>(i)).swap(e.constant.col(static_cast<Eigen::Index>(i)));
    }
    errors.push_back(std::move(e));
  }
  return errors;
}

}  // namespace surveymc::propagate
