#include "monitoring/alarm_tests.h"

#include <algorithm>

#include "base/units.h"
#include "simd/instruction_set.h"

namespace surveymc::monitoring {
namespace {

constexpr std::size_t kSideBySide = simd::kGroup;

}  // namespace

AlarmLanes& AlarmTests::place(AlarmLanes::Kind kind, std::size_t test) {
  if (test % kSideBySide == 0) {
    AlarmLanes& a = groups_.emplace_back();
    a.kind = kind;
    if (kind != AlarmLanes::Kind::sprt)  // unused places raise no alarms
      std::fill(&a.settings[0][0], &a.settings[0][0] + 4 * kSideBySide, kInfinity);
    std::fill(std::begin(a.first), std::end(a.first), kInfinity);
    std::fill(std::begin(a.first_after_start), std::end(a.first_after_start), kInfinity);
  }
  return groups_.back();
}

AlarmTests::AlarmTests(const std::vector<SprtOptions>& tests) {
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const SprtOptions& o = tests[i];
    AlarmLanes& a = place(AlarmLanes::Kind::sprt, i);
    const double settings[] = {o.shift / o.variance, o.shift / 2, sprt_lower(o), sprt_upper(o)};
    for (std::size_t k = 0; k < 4; ++k) a.settings[k][i % kSideBySide] = settings[k];
  }
}

AlarmTests::AlarmTests(const std::vector<CusumOptions>& tests) {
  for (std::size_t i = 0; i < tests.size(); ++i) {
    AlarmLanes& a = place(AlarmLanes::Kind::cusum, i);
    a.settings[0][i % kSideBySide] = tests[i].allowance;
    a.settings[1][i % kSideBySide] = tests[i].threshold;
  }
}

AlarmTests::AlarmTests(const std::vector<double>& thresholds) {
  for (std::size_t i = 0; i < thresholds.size(); ++i)
    place(AlarmLanes::Kind::threshold, i).settings[0][i % kSideBySide] = thresholds[i];
}

void AlarmTests::update(const AlarmSignal& signal) {
  for (AlarmLanes& a : groups_) simd::run_kernel<isa_v3::update_alarms, isa_v4::update_alarms>(a, signal);
}

AlarmTimes AlarmTests::times(std::size_t test) const {
  const AlarmLanes& a = groups_[test / kSideBySide];
  const std::size_t at = test % kSideBySide;
  const auto or_none = [](double time_h) { return time_h < kInfinity ? time_h : kNaN; };
  return {or_none(a.first[at]), or_none(a.first_after_start[at]), a.count[at]};
}

}  // namespace surveymc::monitoring
