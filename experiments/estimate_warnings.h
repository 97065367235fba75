#pragma once
#include <string>
#include <vector>

#include "readings_analysis.h"
#include "readings_suspect.h"
#include "readings_tests.h"

namespace surveymc {

/// What an engineer must know before using an estimate. Severity: "severe" (do not use it as it is), "warning", "info".
struct EstimateWarning {
  std::string severity, message;
};

/// The severe ones first. Few stations, poor rotation, combinations that the stations do not determine, implausible
/// parameters, residuals that do not fit, suspect stations, accelerometers that do not read gravity.
std::vector<EstimateWarning> estimate_warnings(const SixAxisReadings& readings, const ReferenceField& field,
                                               const NoiseModel& noise, const ReadingsAnalysis& analysis,
                                               const std::vector<ReadingsTest>& tests,
                                               const std::optional<Suspect>& examined);

}  // namespace surveymc
