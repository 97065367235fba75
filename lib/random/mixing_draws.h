#pragma once
/// Draws of V (mixing_law.h) by their address: one standard normal each, of channels of their own, so that all other
/// draws of a trial are what they are without a law.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "random/mixing_law.h"
#include "random/stream.h"

namespace surveymc::random {

// Numbers follow those of stream.h and disturbance/process.h, and are kept as long.
inline constexpr Channel kMixingRun{100};      ///< index: ReferenceElement, or 3 of all; of errors that last
inline constexpr Channel kMixingTerm{101};     ///< index of a lasting draw of Channel::error_source
inline constexpr Channel kMixingStation{102};  ///< index of the first draw of a station in Channel::station_error that
                                               ///< has this V; of studies of readings: 4 station + the same

/// One V of a trial.
struct MixingSlot {
  std::shared_ptr<const MixingLaw> law;
  Channel channel{};
  std::uint32_t index = 0;
};

/// Row 2 i of slot i is the factor, row 2 i + 1 the shift of H = factor N + shift. Rows are kGroup doubles apart,
/// groups of trials `stride`. Trials first_trial .. first_trial + 8 groups - 1, a multiple of kGroup. Antithetic trials
/// 2 j and 2 j + 1 have one V.
void draw_mixing(const Stream& stream, const std::vector<MixingSlot>& slots, std::uint64_t first_trial, bool antithetic,
                 int groups, double* rows, std::size_t stride);

}  // namespace surveymc::random
