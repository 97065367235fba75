#pragma once
/// A tally as bytes: every bit of its state, for journals and part files.
#include <string>
#include <string_view>

#include "stats/tally.h"

namespace surveymc::stats {

/// Grows when a member of Tally or Moments is added or changes its meaning.
inline constexpr std::uint32_t kTallyVersion = 1;

std::string tally_to_bytes(const Tally& tally);

/// The same tally, bit for bit. Throws IoError if the bytes are of another version, too few or too many, or of sizes
/// that do not go together. Bytes that changed within a number are not noticed here: records have a checksum.
Tally tally_from_bytes(std::string_view bytes);

}  // namespace surveymc::stats
