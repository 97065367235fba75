#include "propagate/toolface_independent.h"

#include <cassert>
#include <cmath>

#include "propagate/weighting_functions.h"

namespace surveymc::propagate {

namespace {

struct Kind {
  const char* code;
  survey::SensorTerm kind;
  int axis;
  bool with_toolface;
};
constexpr std::array<Kind, 14> kKinds{{{"ABXY-TI1", survey::kAccelerometerBias, 0, true},
                                       {"ABXY-TI2", survey::kAccelerometerBias, 0, true},
                                       {"ABZ", survey::kAccelerometerBias, 2, false},
                                       {"ASXY-TI1", survey::kAccelerometerScale, 0, false},
                                       {"ASXY-TI2", survey::kAccelerometerScale, 0, true},
                                       {"ASXY-TI3", survey::kAccelerometerScale, 0, true},
                                       {"ASZ", survey::kAccelerometerScale, 2, false},
                                       {"MBXY-TI1", survey::kMagnetometerBias, 0, true},
                                       {"MBXY-TI2", survey::kMagnetometerBias, 0, true},
                                       {"MBZ", survey::kMagnetometerBias, 2, false},
                                       {"MSXY-TI1", survey::kMagnetometerScale, 0, false},
                                       {"MSXY-TI2", survey::kMagnetometerScale, 0, true},
                                       {"MSXY-TI3", survey::kMagnetometerScale, 0, true},
                                       {"MSZ", survey::kMagnetometerScale, 2, false}}};

}  // namespace

std::array<ToolfaceIndependentTerm, 14> toolface_independent_terms(double inclination, double azimuth,
                                                                   const survey::ReferenceField& field) {
  StationGeometry s{};
  s.sin_i = std::sin(inclination);
  s.cos_i = std::cos(inclination);
  s.sin_am = std::sin(azimuth);
  s.cos_am = std::cos(azimuth);
  s.gravity = field.gravity;
  s.tan_dip = std::tan(field.dip);
  s.horizontal_field = field.total * std::cos(field.dip);
  std::array<ToolfaceIndependentTerm, 14> terms{};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Kind& k = kKinds[i];
    const Weights w = find_weighting_function(k.code)->weights(s);
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
