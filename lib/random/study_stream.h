#pragma once
/// The random numbers of a study: a stream by the config's seed and the study's id.
#include "random/stream.h"
#include "random/study_id.h"

namespace surveymc::random {

inline Stream stream_of(StudySeed s) { return {s.seed, static_cast<std::uint32_t>(s.study)}; }

}  // namespace surveymc::random
