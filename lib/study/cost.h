#pragma once
/// Processor time that the rows of a result cost: `/run/cost`, which is no part of the result's identity.
#include <vector>

#include "config/config.h"
#include "store/table.h"

namespace surveymc::study {

/// Processor time that this thread has used, s.
double thread_seconds();

/// Adds to `cost` a row for each row of `tables` that has a ratio with an interval, of one point of a sweep:
/// sweep keys, `table, formulation, quantity, trials, relative_half_width` (half of the logarithm of the interval),
///   figure_of_merit    = 1 / (relative half width^2 x seconds of all trials): does not depend on their number, unless
///                        the estimate has a heavy tail; then it falls
///   seconds_to_verdict = seconds of a trial x (trials_to_decide, or the trials of a decided row)
/// `seconds`: processor time of `computed` trials; a run that went on from a checkpoint has computed fewer than
/// `trials`.
void add_cost(store::Table& cost, const std::vector<store::Table>& tables, const std::vector<config::SweepValue>& sweep,
              double seconds, std::uint64_t computed, std::uint64_t trials);

}  // namespace surveymc::study
