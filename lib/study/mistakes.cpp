#include "study/mistakes.h"

#include <algorithm>

namespace surveymc::study {

std::vector<std::string> all_mistakes(const Experiment& experiment, config::Config config,
                                      const config::KnownKeys& known, const std::string& first) {
  constexpr std::size_t kMostPoints = 100, kMostMistakes = 40;
  std::vector<std::size_t> points;
  if (config.point_count() > kMostReadWhole)
    points = config.sample_points();
  else
    for (std::size_t i = 0; i < config.point_count(); ++i) points.push_back(i);
  const std::size_t step = 1 + points.size() / kMostPoints;
  std::vector<std::string> all;
  for (std::size_t i = 0; i < points.size() && all.size() < kMostMistakes; i += step)
    for (std::string& message : config::ConfigReader::mistakes_of(
             config, points[i], known, [&](config::ConfigReader& reader) { read_point(experiment, config, reader); }))
      if (std::find(all.begin(), all.end(), message) == all.end()) all.push_back(std::move(message));
  if (all.size() < 2) return {first};  // its words are those of who knows most
  return all;
}

}  // namespace surveymc::study
