#pragma once
/// Block interface between sensors and single-station estimators: readings and references of unrelated stations, for
/// many trials (survey/readings.h).
#include "survey/readings.h"

namespace surveymc::survey {

/// Rows of one station; station k of a batch starts at row k kStationReadingRows.
inline constexpr int kGravityRow = 0;    ///< accelerometers, tool frame, pointing down, m/s2
inline constexpr int kFieldRow = 3;      ///< magnetometers, tool frame, nT
inline constexpr int kReferenceRow = 6;  ///< gravity (m/s2), Bh, Bd (nT)
inline constexpr int kAxialRow = 9;      ///< the true Mz, nT: estimators do not read it
inline constexpr int kStationReadingRows = 10;

}  // namespace surveymc::survey
