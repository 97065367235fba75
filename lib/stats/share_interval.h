#pragma once
#include "stats/intervals.h"

namespace surveymc::stats {

/// Mean of shares in [0, 1] from their sample variance, inside [0, 1]: Clopper and Pearson's interval for the number of
/// independent events that would have this variance (Korn and Graubard 1998), at least `count` of them. `confidence` in
/// (0, 1), two-sided with equal tails.
Interval share_interval(double mean, double variance, std::uint64_t count, double confidence);

}  // namespace surveymc::stats
