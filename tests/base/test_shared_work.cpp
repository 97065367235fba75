/// Work that points share: made once for equal inputs, the latest results kept, never more than there is memory for.
#include <catch2/catch.hpp>

#include "base/shared_work.h"

using surveymc::shared_work;
using surveymc::SharedWork;

namespace {

struct Input {
  int number = 0;
  bool operator==(const Input&) const = default;
};
struct Other {
  int number = 0;
  bool operator==(const Other&) const = default;
};

int doubled(const Input& in, const std::atomic<bool>*) { return 2 * in.number; }
int tripled(const Input& in, const std::atomic<bool>*) { return 3 * in.number; }
double halved(const Other& in, const std::atomic<bool>*) { return in.number / 2.0; }
int failing(const Input&, const std::atomic<bool>*) { throw 1; }

}  // namespace

TEST_CASE("Equal inputs of the same work share its result") {
  SharedWork work;
  const auto first = work.get(Input{4}, doubled, 8, nullptr);
  CHECK(*first == 8);
  CHECK(work.get(Input{4}, doubled, 8, nullptr) == first);
  CHECK(work.made() == 1);
  CHECK(*work.get(Input{5}, doubled, 8, nullptr) == 10);
  CHECK(*work.get(Input{4}, tripled, 8, nullptr) == 12);  // other work on the same input
  CHECK(*work.get(Other{4}, halved, 8, nullptr) == 2.0);
  CHECK(work.made() == 4);
  CHECK(work.bytes() == 32);
  CHECK_THROWS(work.get(Input{4}, failing, 8, nullptr));
  CHECK(work.made() == 4);
}

TEST_CASE("Shared work is bounded in memory: what was asked for longest ago is made again") {
  SharedWork work(30);
  for (const int i : {1, 2, 3}) work.get(Input{i}, doubled, 10, nullptr);
  work.get(Input{1}, doubled, 10, nullptr);
  CHECK(work.made() == 3);
  work.get(Input{4}, doubled, 10, nullptr);  // in the place of 2
  work.get(Input{1}, doubled, 10, nullptr);
  work.get(Input{3}, doubled, 10, nullptr);
  CHECK(work.made() == 4);
  work.get(Input{2}, doubled, 10, nullptr);
  CHECK(work.made() == 5);
  CHECK(work.bytes() == 30);
  CHECK(*work.get(Input{9}, doubled, 31, nullptr) == 18);  // too large for all of it
  CHECK(work.bytes() == 30);
  work.get(Input{9}, doubled, 31, nullptr);
  CHECK(work.made() == 7);
}

TEST_CASE("Where nothing may be shared, work is done each time") {
  CHECK(*shared_work(nullptr, Input{4}, doubled, 8, nullptr) == 8);
  SharedWork work;
  CHECK(*shared_work(&work, Input{4}, doubled, 8, nullptr) == 8);
  CHECK(work.made() == 1);
}
