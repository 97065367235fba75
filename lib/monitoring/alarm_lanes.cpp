#include "monitoring/alarm_lanes.h"

namespace surveymc::monitoring::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
constexpr double kBeyondAll = 1.7976931348623157e308;

/// A side of Page's sum or of the SPRT has reached its bound: where, as in Sprt::update() and Cusum::update().
struct Sprts {
  T slope, half_shift, lower, upper;
  Sprts(const AlarmLanes& a, int at)
      : slope(load<T>(a.settings[0] + at)),
        half_shift(load<T>(a.settings[1] + at)),
        lower(load<T>(a.settings[2] + at)),
        upper(load<T>(a.settings[3] + at)) {}
  LaneMask update(T& sum, const T& d) const {
    sum = sum + slope * (d - half_shift);
    const LaneMask none = sum <= lower, alarm = upper <= sum;
    sum = select(none | alarm, T(0.0), sum);
    return alarm & !none;
  }
};

struct Cusums {
  T allowance, threshold;
  Cusums(const AlarmLanes& a, int at)
      : allowance(load<T>(a.settings[0] + at)), threshold(load<T>(a.settings[1] + at)) {}
  LaneMask update(T& sum, const T& d) const {
    sum = sum + d - allowance;
    sum = select(sum > T(0.0), sum, T(0.0));
    const LaneMask alarm = threshold <= sum;
    sum = select(alarm, T(0.0), sum);
    return alarm;
  }
};

struct Thresholds {
  T threshold;
  Thresholds(const AlarmLanes& a, int at) : threshold(load<T>(a.settings[0] + at)) {}
  LaneMask update(T&, const T& d) const { return threshold <= d; }
};

template <class Tests>
void update_all(AlarmLanes& a, const AlarmSignal& s) {
  for (int at = 0; at < kGroup; at += lane_count<T>) {
    const Tests tests(a, at);
    T up = load<T>(a.sum[0] + at), down = load<T>(a.sum[1] + at), first = load<T>(a.first + at),
      after = load<T>(a.first_after_start + at), count = load<T>(a.count + at);
    for (std::size_t i = 0; i < s.count; ++i) {
      const T d(s.signal[i * s.stride]);
      const LaneMask of_up = tests.update(up, d), alarm = of_up | tests.update(down, -d);
      if (!any(alarm)) continue;
      const T time(s.time_h[i]);
      first = select(alarm & (kBeyondAll < first), time, first);
      if (s.time_h[i] >= s.start_h) after = select(alarm & (kBeyondAll < after), time, after);
      count = count + select(alarm, T(1.0), T(0.0));
    }
    store(a.sum[0] + at, up);
    store(a.sum[1] + at, down);
    store(a.first + at, first);
    store(a.first_after_start + at, after);
    store(a.count + at, count);
  }
}

}  // namespace

void update_alarms(AlarmLanes& tests, const AlarmSignal& signal) {
  switch (tests.kind) {
    case AlarmLanes::Kind::sprt:
      return update_all<Sprts>(tests, signal);
    case AlarmLanes::Kind::cusum:
      return update_all<Cusums>(tests, signal);
    case AlarmLanes::Kind::threshold:
      return update_all<Thresholds>(tests, signal);
  }
}

}  // namespace surveymc::monitoring::SURVEYMC_ISA
