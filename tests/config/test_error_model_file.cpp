#include "config/error_model_file.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

propagate::ErrorModel read(const std::string& text) {
  Config config =
      Config::from_text("experiment = 'x'\nseed = 1\nmodel = 'tool.toml'\n", "c.toml", {}, {{"tool.toml", text}});
  return read_error_model(config.reader(0).toml("model"));
}

std::string term(const std::string& code, const std::string& rest) {
  return "{ code = '" + code + "', " + rest + " },\n";
}

/// A model of good terms with a third one on line 4.
std::string with_third(const std::string& third) {
  return "first_leg = 'once'\nterms = [" + term("A", "function = 'DREF', magnitude = 0.35, unit = 'm', mode = 'R'") +
         term("B", "function = 'MBZ', magnitude = 70, unit = 'nT', mode = 'S'") + third + "]\n";
}

}  // namespace

TEST_CASE("A model file gives terms in SI units") {
  const propagate::ErrorModel m = read(
      "title = 'my tool'\nsource = 'me'\nfirst_leg = 'doubled'\n"
      "[[terms]]\ncode = 'D'\nfunction = 'DREF'\nmagnitude = 10\nunit = 'ft'\nmode = 'R'\n"
      "[[terms]]\ncode = 'X'\nfunction = 'DBH'\nmagnitude = 3000.0\nunit = 'deg.nT'\nmode = 'W'\n"
      "[[terms]]\ncode = 'Y'\nfunction = 'XYM1'\nmagnitude = 0.0\nunit = 'deg'\nmode = 'G'\n"
      "[[terms]]\ncode = 'Z'\nfunction = 'MBZ'\nmagnitude = 0.07\nunit = 'uT'\nmode = 'S'\n");
  CHECK(m.title == "my tool");
  CHECK(m.source == "me");
  CHECK(m.first_leg_doubled);
  REQUIRE(m.terms.size() == 4);
  CHECK(m.terms[0].sigma == Approx(3.048).epsilon(1e-13));
  CHECK(m.terms[0].magnitude == 10);
  CHECK(m.terms[0].unit == "ft");
  CHECK(m.terms[0].mode == propagate::PropagationMode::random);
  CHECK(m.terms[1].sigma == Approx(3000 * kDegree).epsilon(1e-13));
  CHECK(m.terms[1].mode == propagate::PropagationMode::well);
  CHECK(m.terms[2].sigma == 0);
  CHECK(m.terms[2].mode == propagate::PropagationMode::global);
  CHECK(m.terms[3].sigma == Approx(70).epsilon(1e-13));
  CHECK(m.terms[3].mode == propagate::PropagationMode::systematic);
}

TEST_CASE("A bad model file is refused with its line, key, value and rule") {
  const auto refused = [](const std::string& third, const std::string& message) {
    CAPTURE(third);
    CHECK_THROWS_WITH(read(with_third(third)), StartsWith(message));
  };
  refused(term("C", "function = 'DREFF', magnitude = 1, unit = 'm', mode = 'R'"),
          "tool.toml:4: terms[2].function = \"DREFF\": must be one of \"DREF\", ");
  refused(term("C", "function = 'DREF', magnitude = 1, unit = 'nT', mode = 'R'"),
          "tool.toml:4: terms[2].unit = \"nT\": the unit of DREF must be \"m\" or \"ft\"");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'degree', mode = 'R'"),
          "tool.toml:4: terms[2].unit = \"degree\": the unit of AZ must be \"deg\" or \"rad\"");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = '', mode = 'R'"), "tool.toml:4: terms[2].unit");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 'Q'"),
          "tool.toml:4: terms[2].mode = \"Q\": must be one of \"R\", \"S\", \"W\", \"G\"");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 's'"), "tool.toml:4: terms[2].mode = \"s\"");
  refused(term("A", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 'S'"),
          "tool.toml:4: terms[2].code = \"A\": two terms have this code");
  refused(term("C", "function = 'AZ', magnitude = -1, unit = 'deg', mode = 'S'"),
          "tool.toml:4: terms[2].magnitude = -1: must be >= 0");
  refused(term("C", "function = 'AZ', magnitude = nan, unit = 'deg', mode = 'S'"),
          "tool.toml:4: terms[2].magnitude = nan: must be a finite number");
  refused(term("C", "function = 'AZ', magnitude = inf, unit = 'deg', mode = 'S'"), "tool.toml:4: terms[2].magnitude");
  refused(term("C", "function = 'AZ', magnitude = '1', unit = 'deg', mode = 'S'"),
          "tool.toml:4: terms[2].magnitude = \"1\": must be a number");
  refused(term("C", "function = 'AZ', unit = 'deg', mode = 'S'"), "tool.toml:4: terms[2].magnitude: missing");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'deg'"), "tool.toml:4: terms[2].mode: missing");
  refused(term("", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 'S'"), "tool.toml:4: terms[2].code");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 'S', when = 1"),
          "tool.toml:4: terms[2].when: unknown key");
  CHECK_THROWS_WITH(read("terms = [" + term("A", "function = 'AZ', magnitude = 1, unit = 'deg', mode = 'S'") + "]"),
                    StartsWith("tool.toml: first_leg: missing"));
  CHECK_THROWS_WITH(read("first_leg = 'once'\n"), Equals("tool.toml: terms: a model has at least one term"));
  CHECK_THROWS_WITH(read("first_leg = 'once'\nterms = []\n"), StartsWith("tool.toml:2: terms"));
  CHECK_THROWS_WITH(read("first_leg = 'once'\nterms = 3\n"), StartsWith("tool.toml:2: terms = 3: must be"));
  CHECK_THROWS_WITH(read("first_leg = 'twice'\n"), StartsWith("tool.toml:1: first_leg = \"twice\": must be one of"));
  CHECK_THROWS_WITH(read("first_leg = 'once'\nterms = ["), StartsWith("tool.toml:2: "));
}

TEST_CASE("The models that come with the program are those of configs/error_models") {
  const auto& models = shipped_error_models();
  REQUIRE(models.size() >= 2);
  std::size_t known = 0;
  for (const InputText& m : models) {
    CHECK(m.text == test::project_file("configs/error_models/" + m.path + ".toml"));
    const propagate::ErrorModel model = read(m.text);
    if (m.path == "iscwsa_mwd_rev4") {
      CHECK(model.terms.size() == 27);
      CHECK_FALSE(model.first_leg_doubled);
      ++known;
    } else if (m.path == "iscwsa_mwd_rev5.10") {
      CHECK(model.terms.size() == 35);
      CHECK(model.first_leg_doubled);
      ++known;
    }
  }
  CHECK(known == 2);
}
