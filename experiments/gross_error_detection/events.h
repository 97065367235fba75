#pragma once
/// Events of a gross-error study, where the config has `[[event]]`.
#include <vector>

#include "gross_error_detection/scenario.h"

namespace surveymc::studies::gross_error_detection {

/// `scenario` with sizes. Predictions: linear and nonlinear theory where they are good enough, the error's own test
/// alone, and of false alarms those of independent tests and the sum of all.
std::vector<study::TrialEvent> events_of(const Scenario& scenario);

}  // namespace surveymc::studies::gross_error_detection
