#include "monitoring/sequential_tests.h"

#include <algorithm>
#include <cmath>

namespace surveymc::monitoring {

double sprt_lower(const SprtOptions& o) { return std::log(o.missed_alarm / (1 - o.false_alarm)); }
double sprt_upper(const SprtOptions& o) { return std::log((1 - o.missed_alarm) / o.false_alarm); }

Sprt::Sprt(const SprtOptions& o)
    : slope_(o.shift / o.variance), half_shift_(o.shift / 2), lower_(sprt_lower(o)), upper_(sprt_upper(o)) {}

int Sprt::update(double d) {
  int accepted = 0;
  for (int side = 0; side < 2; ++side) {
    sum_[side] += slope_ * ((side == 0 ? d : -d) - half_shift_);
    if (sum_[side] <= lower_) {
      decided_[side] = false;
      sum_[side] = 0;
    } else if (sum_[side] >= upper_) {
      decided_[side] = true;
      sum_[side] = 0;
      accepted = side == 0 ? 1 : -1;
    }
  }
  return accepted;
}

int Cusum::update(double d) {
  int alarm = 0;
  for (int side = 0; side < 2; ++side) {
    sum_[side] = std::max(0.0, sum_[side] + (side == 0 ? d : -d) - options_.allowance);
    if (sum_[side] >= options_.threshold) {
      sum_[side] = 0;
      alarm = side == 0 ? 1 : -1;
    }
  }
  return alarm;
}

}  // namespace surveymc::monitoring
