#include "base/bytes.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "base/error.h"

using namespace surveymc;

TEST_CASE("Values come back from their bytes", "[checkpoint]") {
  ByteWriter out;
  out.put(true);
  out.put(false);
  out.put(-0.0);
  out.put("text");
  out.put(std::vector<int>{1, -2});
  const std::string bytes = out.take();
  ByteReader in(bytes);
  CHECK(in.get<bool>());
  CHECK_FALSE(in.get<bool>());
  CHECK(std::signbit(in.get<double>()));
  CHECK(in.text() == "text");
  CHECK(in.list<int>() == std::vector<int>{1, -2});
  CHECK(in.left() == 0);
  CHECK_THROWS_AS(in.get<char>(), IoError);
}

TEST_CASE("A byte that is neither true nor false is damage", "[checkpoint]") {  // found by fuzz_part
  for (int byte = 2; byte < 256; ++byte) {
    const std::string bytes(1, static_cast<char>(byte));
    CHECK_THROWS_AS(ByteReader(bytes).get<bool>(), IoError);
  }
}
