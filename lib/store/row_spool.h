#pragma once
/// Tables that are too long for the memory: their first rows move to a file without a name in TMPDIR (/var/tmp without
/// it), and come back piece by piece.
#include "store/table.h"

namespace surveymc::store {

/// Rows that are read from the disk at a time.
inline constexpr std::size_t kPieceRows = std::size_t{1} << 15;
/// Bytes that the rows of a table may take in memory before hold_less() moves them.
inline constexpr std::size_t kMostHeldBytes = std::size_t{8} << 20;

/// Moves all held rows to the disk. Throws IoError, which names the folder.
void move_to_disk(Table& table);

/// move_to_disk() if the held rows take more than kMostHeldBytes.
void hold_less(Table& table);

}  // namespace surveymc::store
