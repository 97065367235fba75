#pragma once
/// Alarm times of many settings of the tests of sequential_tests.h on one signal.
#include <vector>

#include "monitoring/alarm_lanes.h"
#include "monitoring/sequential_tests.h"

namespace surveymc::monitoring {

/// Hours; NaN: none.
struct AlarmTimes {
  double first, first_after_start;
  double count;  ///< of samples with an alarm, of either side
};

/// Tests of one kind on the signal of one sensor, eight at a time. The bits of Sprt, Cusum or Threshold, one by one.
class AlarmTests {
 public:
  explicit AlarmTests(const std::vector<SprtOptions>& tests);
  explicit AlarmTests(const std::vector<CusumOptions>& tests);
  /// Thresholds: settings of Threshold.
  explicit AlarmTests(const std::vector<double>& thresholds);

  /// Samples that follow those of the call before.
  void update(const AlarmSignal& signal);
  AlarmTimes times(std::size_t test) const;

 private:
  AlarmLanes& place(AlarmLanes::Kind kind, std::size_t test);

  std::vector<AlarmLanes> groups_;
};

}  // namespace surveymc::monitoring
