#pragma once
/// The statistical tests of a run of readings, judged at the user's levels.
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/readings_analysis.h"
#include "base/units.h"

namespace surveymc::analysis {

/// `[tests] alpha, alpha_w` and `confidence` of the config.
struct TestLevels {
  double confidence = 0.95;  ///< of parameter intervals
  double alpha = 0.05;       ///< of the tests of the run as a whole
  double alpha_w = 0.001;    ///< of each residual: Baarda's usual value, as there are many
};

/// One row of the table `tests`. NaN: not there.
struct ReadingsTest {
  std::string test = {};       ///< "variance_factor", "perfect_tool" or "residual"
  std::int64_t station = -1;   ///< from 0; -1 for the run as a whole
  double md = kNaN;            ///< m
  std::string component = {};  ///< "horizontal" or "vertical"
  double statistic = kNaN, critical_low = kNaN, critical_high = kNaN, p_value = kNaN;
  double error = kNaN, error_sd = kNaN;  ///< nT: size of the error in this residual, if it is the only one
  std::string decision = {};             ///< "accepted", "rejected" or "not tested"
  std::string note = {};
};

/// First the whole run, then every residual in the order of the stations.
std::vector<ReadingsTest> judge_readings(const survey::SixAxisReadings& readings, const ReadingsAnalysis& analysis,
                                         const TestLevels& levels);

/// Index of the rejected residual with the largest statistic; -1 if none is rejected.
int suspect(const std::vector<ReadingsTest>& tests);

}  // namespace surveymc::analysis
