#pragma once
/// Where first order of a robust loss (multistation/loss.h) holds: what the fit leaves of errors that stations share is
/// small beside the stations' own, and those are as large in every direction of a residual.
#include <vector>

#include "multistation/fit.h"
#include "multistation/model.h"

namespace surveymc::analysis {

/// What is drawn: one sd each.
struct ResidualErrors {
  multistation::PerParameter<double> tool{}, tool_sd{};  ///< constant; of a run
  multistation::ReferenceErrors run, station;            ///< of the reference: of a run; new at every station
  double accelerometer = 0, magnetometer = 0;            ///< of a reading: m/s2, nT
};

struct RobustLimits {
  double shared = 0;  ///< what the fit leaves of shared errors over the stations' own, rms of all residuals
  /// Largest over smallest sd of the stations' own errors, in any direction of the components that have noise by the
  /// options, in units of their sizes; 1 where they have none.
  double uneven = 1;
};

/// Above these sds to first order of a robust loss may be off by more than 5 % (docs/studies/msa_parameters.md).
inline constexpr double kLargeSharedResidual = 0.35, kLargeUnevenness = 1.7;

/// The larger ones of both.
RobustLimits worse_of(const RobustLimits& a, const RobustLimits& b);

/// `models`: of every station, without errors; `sensitive`: fit_sensitivity() with the weights of the loss.
RobustLimits robust_limits(const ResidualErrors& errors, const multistation::FitOptions& options,
                           const std::vector<multistation::StationModel>& models,
                           const multistation::FitSensitivity& sensitive);

}  // namespace surveymc::analysis
