#include "chained/reading_tests.h"

#include <cmath>

#include "base/units.h"

namespace surveymc::chained {

ReadingTests reading_tests(const Model& m, const Readings& readings, const Solution& solution) {
  const Point at = point_of(solution);
  ReadingTests t;
  for (int k = 0; k < readings.stations(); ++k) {
    const StationLinear s = linearise(m, readings, at, k);
    Eigen::Matrix<double, 6, 12> j;
    j << s.by_delta, s.by_chain;
    std::array<double, 6> w, sensitivity;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double left =
          1 - j.row(row).dot(solution.stations[static_cast<std::size_t>(k)].covariance * j.row(row).transpose());
      const bool tested = readings.used(k, i) && left > 1e-12;
      sensitivity[i] = tested ? std::sqrt(left) : kNaN;
      w[i] = s.residual[row] / sensitivity[i];
    }
    t.w.push_back(w);
    t.sensitivity.push_back(sensitivity);
  }
  return t;
}

double minimal_detectable(const Model& m, const ReadingTests& t, std::size_t station, std::size_t axis, double gate,
                          double normal_power) {
  return (gate + normal_power) * m.noise[axis] / t.sensitivity[station][axis];
}

Suspect find_suspect(const ReadingTests& t, const Gate& gate) {
  Suspect s;
  for (std::size_t k = 0; k < t.w.size(); ++k)
    for (std::size_t i = 0; i < 6; ++i)
      if (std::abs(t.w[k][i]) > std::abs(s.w)) {
        s.w = t.w[k][i];
        s.station = static_cast<int>(k);
        s.axis = i;
      }
  if (s.station < 0) return s;
  for (std::size_t i = 0; i < 6; ++i) {
    const double w = std::abs(t.w[static_cast<std::size_t>(s.station)][i]);
    if (i != s.axis && w > s.second) s.second = w;
  }
  s.found = std::abs(s.w) > gate.gate;
  s.dominant = s.found && s.w * s.w - s.second * s.second >= gate.dominance;
  return s;
}

}  // namespace surveymc::chained
