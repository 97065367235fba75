#pragma once
/// Estimators "single_station" and "axial_correction" of the experiment `estimate`: every station of a user's run by
/// itself.
#include <vector>

#include "analysis/readings_tests.h"
#include "config/config.h"
#include "single_station/station_solution.h"
#include "store/table.h"
#include "survey/reference_field.h"
#include "survey/six_axis.h"

namespace surveymc::studies::estimate {

/// "single_station", "axial_correction".
const std::vector<std::string>& station_estimators();

struct StationEstimation {
  single_station::StationMethod method = single_station::StationMethod::basic;
  single_station::StationSigmas sigmas;
};

/// `[estimator] name`, `method` ("basic" or "optimising" of single_station; "extended", "simple" or "extended_bh" of
/// axial_correction; the first is the default) and `[sigma]`.
StationEstimation read_station_estimation(config::ConfigReader& config);

/// Tables `stations`, `tests`, `warnings`. Stations without a solution have NaN.
std::vector<store::Table> station_estimate_tables(const survey::SixAxisReadings& readings,
                                                  const survey::ReferenceField& field, const StationEstimation& how,
                                                  const analysis::TestLevels& levels);

}  // namespace surveymc::studies::estimate
