#include "stats/layout.h"

#include <set>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::stats;

namespace {

struct Events : Layout {
  explicit Events(std::size_t sensors) : found(slots(sensors)) {}
  Slots found, any = slots(), outcome = slots(2, 3), pair = slots(2, 3, 4);
};

}  // namespace

TEST_CASE("The ranges of a layout fill it without gap or overlap", "[stats]") {
  const Events at(5);
  std::multiset<std::size_t> all{at.any()};
  for (std::size_t i = 0; i < 5; ++i) all.insert(at.found(i));
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      all.insert(at.outcome(i, j));
      for (std::size_t k = 0; k < 4; ++k) all.insert(at.pair(i, j, k));
    }
  CHECK(at.size() == 5 + 1 + 6 + 24);
  CHECK(all.size() == at.size());
  CHECK(std::set<std::size_t>(all.begin(), all.end()).size() == at.size());
  CHECK(*all.rbegin() == at.size() - 1);
  CHECK(at.pair(1, 2, 3) == at.size() - 1);  // the last index is the fastest
}
