#pragma once
/// Which reading of a suspect station is wrong, as far as the residuals tell, and the estimate without this station.
#include <optional>
#include <string>
#include <vector>

#include "analysis/readings_analysis.h"
#include "analysis/readings_tests.h"

namespace surveymc::analysis {

/// A reading of the suspect station, tested as the only wrong one (w-test, Baarda 1968).
struct SuspectReading {
  std::string reading;     ///< "gx" ... "bz"
  std::string unit;        ///< of error: "m/s2" or "nT"
  double w = 0;            ///< standard normal under the claimed noise
  double error, error_sd;  ///< size of the error in the sign of the user's readings, if it is the only one
  double correlation =
      0;  ///< of its test with that of the first of the list: near 1 or -1, the two cannot be told apart
  bool in_group = false;  ///< inseparable from the first of the list, or the first itself
};

struct Suspect {
  int station = 0;                          ///< from 0
  std::vector<SuspectReading> readings;     ///< the largest |w| first
  std::optional<ReadingsAnalysis> without;  ///< the run without this station; none where too little is left
};

/// Tests whose correlation is at least this cannot be told apart: with such a correlation the larger test would name
/// the wrong reading in about half of all cases. (Exact ties with correlation 1 are rare: the least angle between two
/// of six directions in the plane of two residuals is seldom 0.)
inline constexpr double kInseparableTests = 0.99;

/// None if no residual was rejected.
std::optional<Suspect> examine_suspect(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                       const sensor::NoiseModel& noise, const estimate::EstimatorOptions& estimator,
                                       const ReadingsAnalysis& analysis, const std::vector<ReadingsTest>& tests);

}  // namespace surveymc::analysis
