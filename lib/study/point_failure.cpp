#include "study/point_failure.h"

namespace surveymc::study {

std::string without_place(const std::string& message) {
  const std::size_t end = message.find(": ");
  if (end == std::string::npos) return message;
  const std::string place = message.substr(0, end);
  const std::size_t colon = place.rfind(':');
  const bool has_line = colon != std::string::npos && colon + 1 < place.size() &&
                        place.find_first_not_of("0123456789", colon + 1) == std::string::npos;
  return has_line ? message.substr(end + 2) : message;
}

PointResult failed_point(std::size_t point, const std::string& reason) {
  return {{{kFailedPoints,
            "points of the sweep that could not be run",
            {{"point", "1", "number of the point", std::vector<std::int64_t>{static_cast<std::int64_t>(point)}},
             {"reason", "", "what is wrong with it", std::vector<std::string>{reason}}}}},
          {},
          {}};
}

bool is_failed(const PointResult& r) { return r.tables.size() == 1 && r.tables.front().name == kFailedPoints; }

}  // namespace surveymc::study
