#pragma once
/// Random subsets of stations, for the start lmeds (robust_kernel.h).
#include <cstdint>
#include <vector>

#include "random/stream.h"

namespace surveymc::multistation {

inline constexpr int kSubsets = 60;  // a multiple of robust_kernel.h: kTogether
/// Stations of a subset for p parameters: ceil(p / 2) + 1, at most all; each has at least two components.
constexpr int subset_size(int parameters, int stations) {
  const int size = (parameters + 1) / 2 + 1;
  return size < stations ? size : stations;
}

/// kSubsets subsets, one after the other. All trials of a group of lanes have the same: `group` is trial / kGroup.
std::vector<int> draw_subsets(const random::Stream& stream, std::uint64_t group, int stations, int size);

}  // namespace surveymc::multistation
