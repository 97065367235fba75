#pragma once
/// The separation of two wells whose reference field is not normal: what k sd stand for.
#include <vector>

#include "proximity/pair_errors.h"
#include "proximity/pair_scan.h"
#include "random/reference_laws.h"
#include "stats/heavy_tail.h"

namespace surveymc::proximity {

/// Heavy parts of the relative error of two points along the line between them, relative to `sd` (m). Both wells have
/// the V of an element in common, whether they share its errors or not. Errors of modes W and G alone: those of single
/// stations (R) are taken as normal, because a sum over many of them nearly is.
std::vector<stats::HeavyPart> heavy_parts(const PairErrors& errors, const random::ReferenceLaws& laws,
                                          const PairPoints& points, double sd);

}  // namespace surveymc::proximity
