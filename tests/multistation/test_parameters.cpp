#include "multistation/parameters.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "survey/sensor_terms.h"

using namespace surveymc;
using namespace surveymc::multistation;

TEST_CASE("Each set has the parameters of its name") {
  for (const std::string& name : set_names()) {
    const ParameterSet s = ParameterSet::named(name);
    CHECK(s.size() == std::stoi(name));
    CHECK(s.name() == name);
  }
  CHECK(ParameterSet::named("6").names() == std::vector<std::string_view>{"mbx", "mby", "mbz", "msx", "msy", "msz"});
  CHECK(ParameterSet::named("9").contains_kind(kRotation));
  CHECK_FALSE(ParameterSet::named("9").corrects_accelerometers());
  CHECK(ParameterSet::named("12").corrects_accelerometers());
  CHECK_FALSE(ParameterSet::named("18").contains_kind(kAccelerometerSkew));
}

TEST_CASE("A list of parameters is in the order of the table") {
  const ParameterSet s = ParameterSet::of({"rz", "mbx", "abz"});
  CHECK(s.names() == std::vector<std::string_view>{"abz", "mbx", "rz"});
  CHECK(s.name() == "abz, mbx, rz");
  CHECK(s.index(2) == kRotation + 2);
}

TEST_CASE("Unknown sets and parameters are refused by name") {
  CHECK_THROWS_WITH(ParameterSet::named("7"), Catch::Contains("\"7\": must be one of 6, 9, 12, 15, 18, 21"));
  CHECK_THROWS_WITH(ParameterSet::of({"mbx", "mbq"}), Catch::Contains("\"mbq\": must be one of abx, aby"));
  CHECK_THROWS_WITH(ParameterSet::of({"mbx", "mbx"}), Catch::Contains("\"mbx\" is there twice"));
  CHECK_THROWS_AS(ParameterSet::of({}), InputError);
}

TEST_CASE("The first twelve parameters are the sensor terms of the error models") {
  for (std::size_t i = 0; i < survey::kSensorTerms; ++i) {
    std::string code = survey::kSensorTermCodes[i];
    for (char& c : code) c = static_cast<char>(std::tolower(c));
    CHECK(kTable[i].name == code);
  }
}
