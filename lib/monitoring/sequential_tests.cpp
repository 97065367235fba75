#include "monitoring/sequential_tests.h"

#include <cmath>

namespace surveymc::monitoring {

double sprt_lower(const SprtOptions& o) { return std::log(o.missed_alarm / (1 - o.false_alarm)); }
double sprt_upper(const SprtOptions& o) { return std::log((1 - o.missed_alarm) / o.false_alarm); }

Sprt::Sprt(const SprtOptions& o)
    : slope_(o.shift / o.variance), half_shift_(o.shift / 2), lower_(sprt_lower(o)), upper_(sprt_upper(o)) {}

}  // namespace surveymc::monitoring
