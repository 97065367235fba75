#pragma once
/// Channels of rare events (lib/rare): draws of a trial under a proposal beside its own normals, and draws of the
/// preparation, which no trial shares. Their numbers follow those of stream.h and are kept as long.
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
