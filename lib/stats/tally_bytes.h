#pragma once
/// A tally as bytes: every bit of its state, for journals and part files.
#include <string>
#include <string_view>

#include "stats/tally.h"

namespace surveymc::stats {

/// Increase this number when a member of Tally, Moments or WeightedHits is added or changes its meaning.
inline constexpr std::uint32_t kTallyVersion = 3;

std::string tally_to_bytes(const Tally& tally);

/// The same tally, bit for bit. Throws IoError if the bytes are of another version, too few or too many, or of sizes
/// that contradict each other. Damage within a number is found by the checksum of the record, not here.
Tally tally_from_bytes(std::string_view bytes);

}  // namespace surveymc::stats
