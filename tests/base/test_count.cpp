#include <catch2/catch.hpp>

#include "base/count.h"

using surveymc::count_of;

TEST_CASE("Counts are read as people write them") {
  CHECK(count_of("0") == 0);
  CHECK(count_of("20000") == 20000);
  CHECK(count_of("1e3") == 1000);
  CHECK(count_of("1E6") == 1000000);
  CHECK(count_of("2.5e1") == 25);
  CHECK(count_of("10k") == 10000);
  CHECK(count_of("10K") == 10000);
  CHECK(count_of("2.5M") == 2500000);
  CHECK(count_of("1e2k") == 100000);
  // No multiple of a thousandth is lost to rounding.
  for (std::uint64_t n = 1; n < 100'000; ++n) {
    const std::string text = std::to_string(n / 1000) + "." + std::to_string(1000 + n % 1000).substr(1) + "k";
    if (count_of(text) != n) FAIL(text);
  }
  CHECK(count_of("9007199254740991") == 9007199254740991);  // 2^53 - 1: beyond, doubles leave out counts
}

TEST_CASE("What is no count is refused") {
  for (const char* text :
       {"",      "k",     "M",    "-1", "-1k", "+1", "1.5",  "1.0005k", "1e-3", "1 000", " 1",    "1 ",
        "1,000", "1_000", "0x10", "1e", "1kk", "1m", "10kM", "ten",     "nan",  "inf",   "1e400", "9007199254740992",
        "1e16"})
    if (count_of(text)) FAIL(text);
}
