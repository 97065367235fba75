#pragma once
/// Meanings of keys that several studies read with different rules or defaults: each is written once.
#include <string_view>

namespace surveymc::config {

namespace meaning {

inline constexpr std::string_view kTrials = "trials at every point of the sweep";
inline constexpr std::string_view kUnusedTrials = "any config may have it; nothing is drawn here";
inline constexpr std::string_view kMostTrials = "trials after which the run ends in any case";
inline constexpr std::string_view kSaveSamples = "so many trials are kept one by one, in `/samples`";
inline constexpr std::string_view kAntithetic =
    "trials 2j and 2j + 1 have opposite draws, and the pair is the unit of every interval; the number of trials must "
    "be even, and the law of the noise symmetric";

inline constexpr std::string_view kPublished = "published values, to compare with";
inline constexpr std::string_view kTableOfRow = "table of the row that is meant";
inline constexpr std::string_view kFormulationOfRow = "formulation of the row, where the table has several";
inline constexpr std::string_view kExpectedVerdict = "verdict that these rows are expected to have";

inline constexpr std::string_view kMargin = "margin of the ratio of prediction to Monte Carlo, and of shifts in sd";
inline constexpr std::string_view kNeesMargin =
    "margin of rows `nees`, a mean of squares; it does not follow `verdict.margin`";
inline constexpr std::string_view kConfidence = "confidence of every interval";

inline constexpr std::string_view kTotalField = "total field of the reference, and of the truth";
inline constexpr std::string_view kDip = "dip of the reference, and of the truth";
inline constexpr std::string_view kDeclination = "magnetic north is this far east of true north";
inline constexpr std::string_view kConvergence = "grid north is this far east of true north";
inline constexpr std::string_view kGravity = "gravity of the reference, and of the truth";
inline constexpr std::string_view kLatitude =
    "latitude of the well, WGS84, north positive; error models of gyros need it";

inline constexpr std::string_view kNorth = "north that azimuths of the file are counted from";
inline constexpr std::string_view kToolfaceZero =
    "axis at which toolfaces are 0: 'x' (thesis) or 'y' (ISCWSA); must be given where the file's toolfaces are used";
inline constexpr std::string_view kUnusual = "'allow' takes what is refused as doubtful, and warns of it";
inline constexpr std::string_view kSlidingToolface =
    "toolface of mode 'sliding', from the axis of `survey.toolface_zero`";
inline constexpr std::string_view kSequence = "number of the drawn sequence of toolfaces; the same in every run";
inline constexpr std::string_view kReportDepths =
    "depths that have rows of their own, in rising order; without it the last station";
inline constexpr std::string_view kOffsetStations = "number n of stations in the expected offset of slide 7";
inline constexpr std::string_view kAccelerometers =
    "'specific_force' if a tool that stands upright reads -z, 'gravity' if it reads +z";
inline constexpr std::string_view kConfidenceOfIntervals = "confidence of the intervals of single estimates";

inline constexpr std::string_view kOutsideRange =
    "stations outside a model's range, of all wells: 'mark' computes and lists them in the table `validity`, 'refuse' "
    "ends the run";
inline constexpr std::string_view kErrorsMultiplier = "multiplies the sizes of all error models";
inline constexpr std::string_view kErrorsVertical =
    "how errors of direction act: 'tilt'; or 'azimuth', which is wrong in holes that are nearly vertical";

}  // namespace meaning

}  // namespace surveymc::config
