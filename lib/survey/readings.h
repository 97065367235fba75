#pragma once
/// Block interface between sensors, estimators and positions: values of many trials, trials fastest.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "simd/lanes.h"

namespace surveymc::survey {

/// row(group, r)[lane]: value r of trial group * kGroup + lane. A shared array holds one group for all trials, with
/// the value repeated in every lane, so that kernels need not know.
class LaneArray {
 public:
  LaneArray() = default;
  LaneArray(int groups, int rows, bool shared = false)
      : group_stride_(shared ? 0 : static_cast<std::size_t>(rows) * simd::kGroup),
        data_(allocate(static_cast<std::size_t>(shared ? 1 : groups) * static_cast<std::size_t>(rows) * simd::kGroup)) {
  }

  double* row(int group, int r) {
    return data_.get() + static_cast<std::size_t>(group) * group_stride_ + static_cast<std::size_t>(r) * simd::kGroup;
  }
  const double* row(int group, int r) const { return const_cast<LaneArray*>(this)->row(group, r); }
  bool shared() const { return group_stride_ == 0; }
  std::size_t group_stride() const { return group_stride_; }  ///< doubles from one group to the next; 0 if shared
  /// Writes one value to all lanes of a row.
  void fill(int group, int r, double value) {
    for (int i = 0; i < simd::kGroup; ++i) row(group, r)[i] = value;
  }
  double value(int trial, int r) const { return row(trial / simd::kGroup, r)[trial % simd::kGroup]; }

 private:
  struct Free {
    void operator()(double* p) const { std::free(p); }
  };
  static std::unique_ptr<double[], Free> allocate(std::size_t count) {
    auto* p = static_cast<double*>(std::aligned_alloc(64, count * sizeof(double)));  // count is a multiple of 8
    if (!p) throw std::bad_alloc();
    std::fill(p, p + count, 0.0);
    return std::unique_ptr<double[], Free>(p);
  }

  std::size_t group_stride_ = 0;
  std::unique_ptr<double[], Free> data_;
};

/// Number of groups that hold `trials`; the last one may be partly unused (its spare lanes hold trials that are not
/// counted).
constexpr int groups_for(int trials) { return (trials + simd::kGroup - 1) / simd::kGroup; }

/// Readings of the tool and the reference, for a batch of trials; a plain value.
struct ReadingBlock {
  ReadingBlock(int trial_count, int station_count, bool noisy_down, bool reference_per_station)
      : trials(trial_count),
        stations(station_count),
        reference_stride(reference_per_station ? 2 : 0),
        magnetic(groups_for(trial_count), 3 * station_count),
        down(groups_for(trial_count), 3 * station_count, !noisy_down),
        reference(groups_for(trial_count), reference_per_station ? 2 * station_count : 2) {}

  int groups() const { return groups_for(trials); }

  /// Makes room for assumed_sd.
  void add_assumed_sd() {
    assumed_sd = LaneArray(groups(), 3 * stations);
    has_assumed_sd = true;
  }

  int trials, stations;
  int reference_stride;  ///< rows from one station's reference to the next: 2, or 0 when one holds for the whole run
  LaneArray magnetic;    ///< rows 3 k + axis: magnetometer readings of station k, tool frame, nT
  LaneArray down;        ///< rows 3 k + axis: unit vector of gravity at station k, tool frame, from the accelerometers
  LaneArray reference;   ///< rows reference_stride k + {0, 1}: horizontal and vertical reference field, nT
  bool has_assumed_sd = false;
  LaneArray assumed_sd;  ///< rows 3 k + axis: the sd (nT) that a weighted estimator assumes, where it varies
};

}  // namespace surveymc::survey
