#pragma once
/// Two wells of the study, ready to be compared in every formulation.
#include "clearance/scenario.h"

namespace surveymc::studies::clearance {

using Reference = study::PairReference;
using Pair = study::WellPair;

}  // namespace surveymc::studies::clearance
