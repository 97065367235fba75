#include "multistation/subsets.h"

#include "random/choice.h"

namespace surveymc::multistation {

std::vector<int> draw_subsets(const random::Stream& stream, std::uint64_t group, int stations, int size) {
  std::vector<int> all;
  for (int s = 0; s < kSubsets; ++s) {
    const std::vector<int> one = random::choose(stream, group, random::Channel::robust_subset,
                                                static_cast<std::uint32_t>(s * size), stations, size);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

}  // namespace surveymc::multistation
