#pragma once
/// Wells of drift_run.h side by side, for both instruction sets (simd/lanes.h): lanes are trials.
#include <array>
#include <cstddef>
#include <cstdint>

#include "random/stream.h"
#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::analysis {

/// First index of the steps of biases that walk, beyond the indices of the noise of 10^8 stations.
inline constexpr std::uint32_t kFirstDriftStep = std::uint32_t{1} << 30;

/// What a trial of three wells yields. Stations and sensor are -1 where there is no alarm.
struct DriftResult {
  enum Value {
    sprt,            ///< station of the first alarm from the drift's begin on, with the ramp
    filter,          ///< the same
    named,           ///< sensor named at that alarm
    sprt_without,    ///< without drift
    filter_without,  ///< the same
    nis_mean,        ///< with biases that walk
    nis_inside,      ///< the same
    nees_mean,       ///< the same
    kValues
  };
};

/// Eight trials. SI: m/s2, nT, rad.
struct DriftBatch {
  random::Stream stream;
  std::uint64_t first_trial;
  int stations, from_station;
  // Of each station: true down in the tool frame is (-si sin tau, -si cos tau, ci), the field (across sin tau + east
  // cos tau, across cos tau - east sin tau, along); and the share of the drift.
  const double *gravity_across, *gravity_along, *field_across, *field_along, *ramp;
  double field_east;
  double gravity, total, sin_dip, cos_dip;  ///< the reference's mean
  std::array<double, 6> noise, drift, walk;
  std::array<double, 3> scatter;
  double sprt_slope, sprt_half_shift, sprt_lower, sprt_upper;
  double alarm_sd, nis_quantile;
  double values[DriftResult::kValues][simd::kGroup];  ///< results
  /// 0: the trial left the range of this kernel: a channel 30 degrees beside its reference, or a variance of which
  /// an update leaves less than 1e-9. Its values have no meaning.
  double in_range[simd::kGroup];
};

SURVEYMC_KERNEL(void drift_trials(DriftBatch& batch));

}  // namespace surveymc::analysis
