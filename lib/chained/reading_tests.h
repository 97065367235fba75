#pragma once
/// Is a reading wrong? Normalised residuals of a chained solution, and what to do about the largest.
#include "chained/linearised_station.h"

namespace surveymc::chained {

/// Six numbers a station, in the order of StationReading. NaN for readings left out.
struct ReadingTests {
  /// w = e / sqrt(s^2 - J C J'): standard normal if the model is right and nothing is wrong.
  std::vector<std::array<double, 6>> w;
  /// Root of the redundancy number: sqrt(1 - J C J' / s^2). An error of x shifts its own w by x/s times it.
  std::vector<std::array<double, 6>> sensitivity;
};
ReadingTests reading_tests(const Model& model, const Readings& readings, const Solution& solution);

/// Smallest error that a test at `gate` finds with probability `power`: (gate + z_power) s / sensitivity.
/// `normal_power` is z_power, 0.8416 for 80 %.
double minimal_detectable(const Model& model, const ReadingTests& tests, std::size_t station, std::size_t axis,
                          double gate, double normal_power = 0.8416212335729143);

/// The suspect. A wrong reading shifts the other tests of its station almost as much as its own: the station is
/// nearly always right, the reading often not, and deleting a right reading leaves the wrong one without a check.
struct Suspect {
  bool found = false;    ///< the largest |w| is beyond the gate
  int station = -1;      ///< from 0
  std::size_t axis = 0;  ///< of the largest |w|
  double w = 0;
  double second = 0;      ///< the largest |w| of another reading of that station
  bool dominant = false;  ///< w^2 - second^2 is at least `dominance`: the one reading may be deleted
};
struct Gate {
  double gate = 4.2;      ///< false alarms in 0.17 % of runs of 18 stations
  double dominance = 18;  ///< twice the log of the odds of the first suspect against the second: e^9 = 8000
};
Suspect find_suspect(const ReadingTests& tests, const Gate& gate = {});

}  // namespace surveymc::chained
