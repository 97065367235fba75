#pragma once
/// Trials of a run whose tool has any of the errors that multi-station analysis can estimate
/// (multistation/parameters.h): truth -> readings, and corrected readings -> final position.
#include <cstdint>
#include <vector>

#include "multistation/fit.h"
#include "random/stream.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// A run without its draws, and one standard deviation of each draw.
struct MultistationRun {
  std::vector<double> md;                           ///< m
  std::vector<Eigen::Vector3d> gravity_T, field_T;  ///< error-free: m/s2, nT
  survey::ReferenceField field;                     ///< the true one
  multistation::PerParameter<double> tool{};        ///< nominal errors
  multistation::PerParameter<double> tool_sd{};     ///< of a run's own tool about them
  double accelerometer = 0, magnetometer = 0;       ///< noise, m/s2 and nT per axis and station
  multistation::ReferenceErrors reference;          ///< of the reference that the estimator is given, less the truth
  bool reference_per_station = false;               ///< drawn anew at every station; else once a run
};
MultistationRun multistation_run(const survey::Survey& survey, const survey::ReferenceField& field);

/// Readings without noise by the nominal tool, with the true field as reference.
std::vector<multistation::StationReadings> clean_stations(const MultistationRun& run);

/// Fills `out` with readings of the trials first_trial, first_trial + 1, ... (a multiple of kGroup), and rows of
/// `tools` with each trial's true errors, in the order of the table. Residuals are those of surveys. Channels:
/// magnetometer_noise, accelerometer_noise, tool_errors by the table's order, station_reference by 4 station +
/// {gravity, total, dip}.
void simulate_multistation(const MultistationRun& run, const random::Stream& stream, std::uint64_t first_trial,
                           multistation::SixAxisBlock& out, survey::LaneArray& tools);

/// Rows N, E, V of the last station from the first (m, true north), by corrected readings and minimum curvature.
void multistation_positions(const multistation::SixAxisBlock& corrected, const std::vector<double>& md,
                            double declination, survey::LaneArray& position);

}  // namespace surveymc::analysis
