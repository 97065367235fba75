#include "store/ruled_values.h"

#include <algorithm>
#include <numeric>

namespace surveymc::store {

Values RowNumbers::read(std::size_t first, std::size_t count) const {
  std::vector<std::int64_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), static_cast<std::int64_t>(first));
  return numbers;
}

Values RepeatedNumbers::read(std::size_t first, std::size_t count) const {
  std::vector<double> out;
  out.reserve(count);
  while (out.size() < count) {
    const std::size_t i = first + out.size();
    out.insert(out.end(), std::min(count - out.size(), times_ - i % times_), numbers_[i / times_]);
  }
  return out;
}

Values CycledWords::read(std::size_t first, std::size_t count) const {
  std::vector<std::string> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = words_[(first + i) % words_.size()];
  return out;
}

}  // namespace surveymc::store
