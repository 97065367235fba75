#pragma once
#include <string>
#include <vector>

#include "analysis/readings_analysis.h"
#include "analysis/readings_profile.h"
#include "analysis/readings_tests.h"
#include "analysis/suspect_readings.h"

namespace surveymc::analysis {

/// What an engineer must know before using an estimate. Severity: "severe" (do not use it as it is), "warning", "info".
struct Warning {
  std::string severity, message;
};

/// The severe ones first. Few stations, poor rotation, combinations that the stations do not determine, implausible
/// parameters, residuals that do not fit, suspect stations, accelerometers that do not read gravity, intervals that are
/// not those of the covariance.
std::vector<Warning> warnings_of_estimate(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                          const sensor::NoiseModel& noise, const ReadingsAnalysis& analysis,
                                          const std::vector<ReadingsTest>& tests,
                                          const std::optional<Suspect>& examined,
                                          const std::vector<ProfiledInterval>& profiled = {});

}  // namespace surveymc::analysis
