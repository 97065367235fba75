#include "propagate/gyro_sections.h"

namespace surveymc::propagate {

std::vector<GyroStretch> gyro_stretches(const survey::Survey& survey, std::size_t first, std::size_t end,
                                        const error_model::Gyro& gyro) {
  const auto is_initialised = [&](std::size_t k) {
    return !gyro.initialise_at || survey.stations[k].inclination >= *gyro.initialise_at;
  };
  std::vector<GyroStretch> out;
  int section = 0;
  for (std::size_t k = first; k < end;) {
    GyroStretch stretch;
    stretch.first = k;
    stretch.is_continuous = is_initialised(k);
    while (k < end && is_initialised(k) == stretch.is_continuous) ++k;
    stretch.end = k;
    stretch.section = section;
    if (stretch.is_continuous) {
      ++section;
      const survey::Station& before = survey.stations[stretch.first - 1];
      stretch.initialised_from = stretch.first - 1;
      stretch.initialised_inclination = gyro.initialise_at.value_or(before.inclination);
      stretch.initialised_azimuth = before.azimuth;
      stretch.azimuth_is_of_vertical_station = before.inclination < error_model::kVerticalLimit;
    }
    out.push_back(stretch);
  }
  return out;
}

const error_model::GyroZone* zone_at(const error_model::Gyro& gyro, const std::string& axis, double inclination) {
  for (const error_model::GyroZone& z : gyro.zones) {
    const bool is_last = &z == &gyro.zones.back();
    if (z.axis == axis && inclination >= z.from && (is_last || inclination < z.to)) return &z;
  }
  return nullptr;
}

}  // namespace surveymc::propagate
