#pragma once
/// Parts of the study `axial_correction`: azimuth errors of single-station solutions, with and without axial
/// correction.
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "config/config.h"
#include "montecarlo/run_blocks.h"
#include "random/study_id.h"
#include "sensor/station_draws.h"
#include "single_station/station_solution.h"
#include "stats/layout.h"
#include "stats/tally.h"
#include "store/table.h"
#include "survey/reference_field.h"

namespace surveymc::studies::axial_correction {

/// `[error]`: constant errors of the error maps, and of a Monte Carlo with a given magnetisation.
struct ConstantErrors {
  survey::Vec3<double> magnetometer_bias{0, 0, 0};  ///< nT
  double axial = 0;                                 ///< Mz, nT
  double horizontal = 0, vertical = 0;              ///< reference less truth, nT
};

/// `[[expect_attitude]]`: verdict that rows of the table `verification` should have.
struct ExpectedVerdict {
  std::vector<std::string> methods, quantities;
  std::vector<double> inclination_deg, azimuth_deg;  ///< empty: all
  std::string verdict;
};

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 0;  ///< none without [monte_carlo]
  survey::ReferenceField field;
  single_station::StationSigmas sigmas;
  ConstantErrors errors;
  double toolface = 0;  ///< rad, from y
  std::vector<single_station::StationMethod> methods;
  std::vector<double> inclination_deg, azimuth_deg;                  ///< of the maps
  double tolerance = 0;                                              ///< of the azimuth, rad
  std::vector<survey::Attitude> stations;                            ///< of the Monte Carlo
  std::vector<double> station_inclination_deg, station_azimuth_deg;  ///< the same as given, for tables
  bool axial_is_drawn = true;                                        ///< false: given by `errors`
  compare::VerdictRule verdict;
  std::vector<ExpectedVerdict> expected;
  compare::Annotations annotations;

  std::string name_of(std::size_t method) const {
    return single_station::station_method_names()[static_cast<std::size_t>(methods[method])];
  }
};

/// Reads and checks a config; calls finish().
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// Readings and references of a station without noise. In a vertical hole the toolface is taken as 0, because the
/// readings depend only on its sum with the azimuth.
sensor::StationTruth station_truth(const Scenario& scenario, const survey::Attitude& at, const ConstantErrors& errors);

/// A method at an attitude, without Monte Carlo.
struct Prediction {
  double azimuth_error = 0;                      ///< by the constant errors, exact, rad in [-pi, pi]; inf: no solution
  double axial_error = 0;                        ///< of the estimated Mz, nT
  single_station::StationSolution solution;      ///< with these errors
  single_station::StationCovariance covariance;  ///< to first order, about `solution`
  double sd(single_station::StationQuantity q) const {
    const auto i = static_cast<Eigen::Index>(q);
    return std::sqrt(covariance(i, i));
  }
};

/// `actual`: standard deviations of what is drawn. Infinite where there is no solution.
Prediction predict_azimuth_errors(const Scenario& scenario, const survey::Attitude& at,
                                  single_station::StationMethod method, const ConstantErrors& errors,
                                  const single_station::StationSigmas& actual);

/// Quantities of the table `profile`: names, units, and how many of the unit are one in SI.
struct ProfileQuantity {
  const char *name, *unit;
  double per_si;
};
inline constexpr std::size_t kProfileQuantities = 7;
const std::array<ProfileQuantity, kProfileQuantities>& profile_quantities();

/// Layout of a tally of the study: its groups of moments, and its counts, of every method and station.
struct Groups : stats::Layout {
  Groups(std::size_t methods, std::size_t stations) : station(slots(methods, stations)), profile(slots(methods)) {}
  stats::Slots station;  ///< azimuth, Mz errors
  stats::Slots profile;  ///< mean squares over the stations
};
struct Counts : stats::Layout {
  Counts(std::size_t methods, std::size_t stations)
      : failed(slots(methods, stations)), over_tolerance(slots(methods, stations)) {}
  stats::Slots failed, over_tolerance;
};

std::vector<store::Axis> map_axes_of(const Scenario& scenario);
/// Maps `azimuth_error_deg`, `azimuth_sd_deg`, `axial_magnetisation_error_nT` and the table `failures`.
void add_maps(const Scenario& scenario, std::vector<store::Map>& maps, std::vector<store::Table>& tables);
/// Table `verification`: every station and method of the Monte Carlo against its prediction.
store::Table verification_table(const Scenario& scenario, const stats::Tally& tally);
/// Table `profile`: RMS over all stations of the Monte Carlo.
store::Table profile_table(const Scenario& scenario, const stats::Tally& tally);

}  // namespace surveymc::studies::axial_correction
