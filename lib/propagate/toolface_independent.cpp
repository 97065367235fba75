#include "propagate/toolface_independent.h"

#include <cassert>
#include <cmath>

namespace surveymc {

std::array<ToolfaceIndependentTerm, 14> toolface_independent_terms(double inclination, double azimuth,
                                                                   const ReferenceField& field) {
  const double si = std::sin(inclination), ci = std::cos(inclination), sa = std::sin(azimuth), ca = std::cos(azimuth);
  const double tan_dip = std::tan(field.dip), g = field.gravity, bh = field.total * std::cos(field.dip);
  const double root2 = std::sqrt(2.0);
  const SensorTerm ab = kAccelerometerBias, as = kAccelerometerScale, mb = kMagnetometerBias, ms = kMagnetometerScale;
  return {{
      {"ABXY-TI1", ab, 0, true, -ci / g, tan_dip * ci * sa * si / g},
      {"ABXY-TI2", ab, 0, true, 0, (ci - tan_dip * ca * si) / g},  // (cotI - tanD cosA) sinI
      {"ABZ", ab, 2, false, -si / g, tan_dip * si * sa * si / g},
      {"ASXY-TI1", as, 0, false, si * ci / root2, -tan_dip * si * ci * sa * si / root2},
      {"ASXY-TI2", as, 0, true, si * ci / 2, -tan_dip * si * ci * sa * si / 2},
      {"ASXY-TI3", as, 0, true, 0, (tan_dip * si * ca - ci) * si / 2},
      {"ASZ", as, 2, false, -si * ci, tan_dip * si * ci * sa * si},
      {"MBXY-TI1", mb, 0, true, 0, -ci * sa * si / bh},
      {"MBXY-TI2", mb, 0, true, 0, ca * si / bh},
      {"MBZ", mb, 2, false, 0, -si * sa * si / bh},
      {"MSXY-TI1", ms, 0, false, 0, si * sa * (tan_dip * ci + si * ca) * si / root2},
      {"MSXY-TI2", ms, 0, true, 0, sa * (tan_dip * si * ci - ci * ci * ca - ca) * si / 2},
      {"MSXY-TI3", ms, 0, true, 0, (ci * ca * ca - ci * sa * sa - tan_dip * si * ca) * si / 2},
      {"MSZ", ms, 2, false, 0, -(si * ca + tan_dip * ci) * si * sa * si},
  }};
}

std::vector<TangentErrors> toolface_independent_errors(const Survey& survey, const ReferenceField& field,
                                                       const SensorTermArray& sd, ToolfacePropagation propagation) {
  std::vector<TangentErrors> errors;
  for (const Station& s : survey.stations) {
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

}  // namespace surveymc
