#include "random/choice.h"

#include <numeric>
#include <utility>

namespace surveymc::random {

int choose_one(const Stream& stream, std::uint64_t trial, Channel channel, std::uint32_t index, int of) {
  const double u = stream.uniforms<double>(trial, channel, std::uint64_t{index / 4})[index % 4];
  return static_cast<int>(u * of);  // uniforms are below 1
}

std::vector<int> choose(const Stream& stream, std::uint64_t trial, Channel channel, std::uint32_t first, int of,
                        int count) {
  std::vector<int> all(static_cast<std::size_t>(of));
  std::iota(all.begin(), all.end(), 0);
  for (int i = 0; i < count; ++i)  // the first steps of a Fisher-Yates shuffle
    std::swap(all[static_cast<std::size_t>(i)],
              all[static_cast<std::size_t>(
                  i + choose_one(stream, trial, channel, first + static_cast<std::uint32_t>(i), of - i))]);
  all.resize(static_cast<std::size_t>(count));
  return all;
}

}  // namespace surveymc::random
