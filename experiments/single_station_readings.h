#pragma once
/// Estimators "single_station" and "axial_correction" of the experiment `estimate`: every station of a user's run by
/// itself.
#include <vector>

#include "config/config.h"
#include "estimate/single_station.h"
#include "field/reference_field.h"
#include "readings_tests.h"
#include "store/table.h"
#include "survey/six_axis.h"

namespace surveymc {

/// "single_station", "axial_correction".
const std::vector<std::string>& station_estimators();

struct StationEstimation {
  StationMethod method = StationMethod::basic;
  StationSigmas sigmas;
};

/// `[estimator] name`, `method` ("basic" or "optimising" of single_station; "extended", "simple" or "extended_bh" of
/// axial_correction; the first is the default) and `[sigma]`.
StationEstimation read_station_estimation(ConfigReader& config);

/// Tables `stations`, `tests`, `warnings`. Stations without a solution have NaN.
std::vector<Table> station_estimate_tables(const SixAxisReadings& readings, const ReferenceField& field,
                                           const StationEstimation& how, const TestLevels& levels);

}  // namespace surveymc
