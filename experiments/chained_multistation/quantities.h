#pragma once
/// The numbers that are kept of a solved run: errors against the truth, and the claims of the covariances.
#include <array>

#include "chained_multistation/scenario.h"
#include "store/table.h"

namespace surveymc::studies::chained_multistation {

/// Quantities of the slides' tables, in their units: columns of every table.
inline constexpr std::size_t kRunQuantities = 6;
inline constexpr std::array<const char*, kRunQuantities> kRunQuantityNames{
    "azimuth_deg", "inclination_deg", "toolface_deg", "gravity_mg", "horizontal_nT", "down_nT"};
inline constexpr std::array<const char*, kRunQuantities> kRunQuantityUnits{"deg", "deg", "deg", "mg", "nT", "nT"};
/// The other states, tested for consistency only.
inline constexpr std::size_t kTestedStates = 12;
inline constexpr std::array<const char*, kTestedStates> kTestedStateNames{
    "z_azimuth",         "z_inclination",    "z_toolface",        "z_gravity",
    "z_horizontal",      "z_down",           "z_accelerometer_x", "z_accelerometer_y",
    "z_accelerometer_z", "z_magnetometer_x", "z_magnetometer_y",  "z_magnetometer_z"};

/// Errors of one station, estimate less truth; angles wrapped.
using QuantityArray = std::array<double, kRunQuantities>;

struct StationCheck {
  QuantityArray error{}, claimed_sd{};    ///< sd: NaN where the estimator claims none
  std::array<double, kTestedStates> z{};  ///< error over claimed sd
  double nees = 0;                        ///< of all twelve states together
};

/// A whole run by one estimator.
struct RunCheck {
  chained::Status status = chained::Status::converged;
  bool converged() const { return status == chained::Status::converged; }
  double cost = 0;
  std::vector<StationCheck> stations;
};

QuantityArray station_errors(const sensor::ChainedRun& run, const survey::ReferenceField& field, std::size_t station,
                             const Eigen::Matrix3d& frame, double gravity, double horizontal, double down);

/// The check of a run solved by base or single.
RunCheck check_alone(const Scenario& s, Solver estimator, const sensor::ChainedRun& run);
/// The check of a chained estimator's solution.
RunCheck check_chained(const Scenario& s, const sensor::ChainedRun& run, const chained::Solution& solution);

/// How the solutions of one kind ended: `first` of the tally's counts is the first of those by Status.
struct Endings {
  std::string name;
  std::size_t first = 0;
};
/// Table `failures`: one row a kind of solution and status; `kind` is its first column. A tally without trials has no
/// rows.
store::Table endings_table(const std::string& what, const char* kind, const char* meaning,
                           const std::vector<Endings>& endings, const stats::Tally& tally);

}  // namespace surveymc::studies::chained_multistation
