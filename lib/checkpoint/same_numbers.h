#pragma once
#include "base/numerics.h"
#include "checkpoint/record.h"

namespace surveymc::checkpoint {

/// Tallies of both may be merged: they are of one config, and of programs whose numbers have the same bits.
inline bool same_numbers(const RunKey& a, const RunKey& b) {
  return a.config_hash == b.config_hash && numerics_of(a.program) == numerics_of(b.program);
}

}  // namespace surveymc::checkpoint
