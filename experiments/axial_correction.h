#pragma once
/// Parts of the study `axial_correction`: azimuth errors of single-station solutions, with and without axial
/// correction.
#include <string>
#include <vector>

#include "config/config.h"
#include "estimate/single_station.h"
#include "field/reference_field.h"
#include "montecarlo/run_blocks.h"
#include "random/study_id.h"
#include "sensor/station_draws.h"
#include "stats/layout.h"
#include "stats/tally.h"
#include "store/table.h"
#include "study/annotations.h"

namespace surveymc {

/// `[error]`: constant errors of the error maps, and of a Monte Carlo with a given magnetisation.
struct ConstantErrors {
  Vec3<double> magnetometer_bias{0, 0, 0};  ///< nT
  double axial = 0;                         ///< Mz, nT
  double horizontal = 0, vertical = 0;      ///< reference less truth, nT
};

/// `[[expect_attitude]]`: verdict that rows of the table `verification` should have.
struct ExpectedVerdict {
  std::vector<std::string> methods, quantities;
  std::vector<double> inclination_deg, azimuth_deg;  ///< empty: all
  std::string verdict;
};

struct AxialScenario {
  StudySeed seed;
  std::uint64_t trials = 0;
  ReferenceField field;
  StationSigmas sigmas;
  ConstantErrors errors;
  double toolface = 0;  ///< rad, from y
  std::vector<StationMethod> methods;
  std::vector<double> inclination_deg, azimuth_deg;                  ///< of the maps
  double tolerance = 0;                                              ///< of the azimuth, rad
  std::vector<Attitude> stations;                                    ///< of the Monte Carlo
  std::vector<double> station_inclination_deg, station_azimuth_deg;  ///< the same as given, for tables
  bool axial_is_drawn = true;                                        ///< as against given by `errors`
  VerdictRule verdict;
  std::vector<ExpectedVerdict> expected;
  Annotations annotations;

  std::string name_of(std::size_t method) const {
    return station_method_names()[static_cast<std::size_t>(methods[method])];
  }
};

/// Reads and checks a config; calls finish().
AxialScenario read_axial_scenario(ConfigReader& config, StudySeed seed);

/// What a station reads and is told without noise. In a vertical hole the toolface is taken as 0: only its sum with the
/// azimuth is there to be read.
StationTruth station_truth(const AxialScenario& scenario, const Attitude& at, const ConstantErrors& errors);

/// A method at an attitude, without Monte Carlo.
struct AxialPrediction {
  double azimuth_error = 0;      ///< by the constant errors, exact, rad in [-pi, pi]; inf: no solution
  double axial_error = 0;        ///< of the estimated Mz, nT
  StationSolution solution;      ///< with these errors
  StationCovariance covariance;  ///< to first order, about `solution`
  double sd(StationQuantity q) const {
    const auto i = static_cast<Eigen::Index>(q);
    return std::sqrt(covariance(i, i));
  }
};

/// `actual`: standard deviations of what is drawn. Infinite where there is no solution.
AxialPrediction predict_axial(const AxialScenario& scenario, const Attitude& at, StationMethod method,
                              const ConstantErrors& errors, const StationSigmas& actual);

/// Quantities of the table `profile`: names, units, and how many of the unit are one in SI.
struct ProfileQuantity {
  const char *name, *unit;
  double per_si;
};
inline constexpr std::size_t kProfileQuantities = 7;
const std::array<ProfileQuantity, kProfileQuantities>& profile_quantities();

/// Where a tally of the study has what: its groups of moments, and its counts, of every method and station.
struct AxialGroups : Layout {
  AxialGroups(std::size_t methods, std::size_t stations) : station(slots(methods, stations)), profile(slots(methods)) {}
  Slots station;  ///< azimuth, Mz errors
  Slots profile;  ///< mean squares over the stations
};
struct AxialCounts : Layout {
  AxialCounts(std::size_t methods, std::size_t stations)
      : failed(slots(methods, stations)), over_tolerance(slots(methods, stations)) {}
  Slots failed, over_tolerance;
};

std::vector<Axis> axial_axes(const AxialScenario& scenario);
/// Maps `azimuth_error_deg`, `azimuth_sd_deg`, `axial_magnetisation_error_nT` and the table `failures`.
void add_axial_maps(const AxialScenario& scenario, std::vector<Map>& maps, std::vector<Table>& tables);
/// Table `verification`: every station and method of the Monte Carlo against its prediction.
Table axial_verification(const AxialScenario& scenario, const Tally& tally);
/// Table `profile`: RMS over all stations of the Monte Carlo.
Table axial_profile(const AxialScenario& scenario, const Tally& tally);

}  // namespace surveymc
