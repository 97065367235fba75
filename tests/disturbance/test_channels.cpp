#include <set>

#include <catch2/catch.hpp>

#include "disturbance/process.h"
#include "random/mixing_draws.h"
#include "random/rare_channels.h"

using namespace surveymc;
using random::Channel;

/// Every purpose of a draw; a new one is added here.
TEST_CASE("No two purposes of a draw share the number of their channel") {
  using enum Channel;
  const std::vector<Channel> all{
      magnetometer_noise, accelerometer_noise, reference_field,       tool_errors,         assumed_noise,
      toolface,           sensor_term,         gross_error_study,     sensor_noise,        survey_sensor_noise,
      survey_reference,   survey_toolface,     chained_state,         chained_noise,       chained_toolface,
      chained_profile,    axial_magnetisation, station_reference,     error_source,        station_error,
      random::kWellPlace, random::kRareNormal, random::kRareChoice,   random::kRarePilot,  random::kRarePilotChoice,
      random::kRareChain, disturbed_run,       disturbed_station,     gross_choice,        gross_size,
      robust_subset,      disturbance::kStart, disturbance::kAr1,     disturbance::kStorm, disturbance::kStormVector,
      random::kMixingRun, random::kMixingTerm, random::kMixingStation};
  CHECK(std::set<Channel>(all.begin(), all.end()).size() == all.size());
}
