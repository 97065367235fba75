#pragma once
/// Channels of rare events (lib/rare): what a trial under a proposal draws besides its own normals, and the draws of
/// the preparing, which no trial shares. Their numbers go on behind those of stream.h, and stay as long.
#include "random/stream.h"

namespace surveymc::random {

inline constexpr Channel kWellPlace{62};   ///< index 4 well + axis: place of a slot; the reference is well 0
inline constexpr Channel kRareNormal{70};  ///< index of the normal: trials of a limit state of its own
inline constexpr Channel kRareChoice{71};  ///< index 0: uniform, chooses a trial's component
inline constexpr Channel kRarePilot{72};   ///< index of the normal; trial: stage, round and sample of the preparing
inline constexpr Channel kRarePilotChoice{73};  ///< index 0, the same trials
inline constexpr Channel kRareChain{74};  ///< index of the normal; trial: replicate, level, step, sample of a subset
                                          ///< simulation

}  // namespace surveymc::random
