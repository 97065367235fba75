#include "scenario/error_models.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "config_text.h"

using namespace surveymc;
using namespace surveymc::config;
using namespace surveymc::propagate;
using namespace surveymc::survey;
using namespace surveymc::scenario;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const char* kTool =
    "first_leg = 'once'\nterms = [{ code = 'A', function = 'AZ', magnitude = 1, unit = 'deg', mode = 'S' }]";

ToolRuns read(const std::string& body) {
  Survey s;
  for (int k = 0; k < 5; ++k) s.stations.push_back({100 * kFoot * k, 0.1 * k, 1, 0});
  return test::read_config("seed = 1\n" + body, [&](ConfigReader& c) { return read_tool_runs(c, s); }, nullptr, {},
                           {{"tool.toml", kTool}, {"<shipped>/iscwsa_mwd_rev4.toml", kTool}});
}

}  // namespace

TEST_CASE("An error model is chosen by name or by file; one model is one leg") {
  for (const char* body : {"error_model = 'iscwsa_mwd_rev4'", "[error_model]\nname = 'iscwsa_mwd_rev4'"}) {
    const ToolRuns legs = read(body);
    REQUIRE(legs.runs.size() == 1);
    CHECK(legs.runs[0].first == 1);
    CHECK(legs.model_names[0] == "iscwsa_mwd_rev4");
    CHECK(legs.from_md[0] == 0);
  }
  CHECK(read("[error_model]\nfile = 'tool.toml'").runs[0].model->terms.at(0).code == "A");
  CHECK_THROWS_WITH(
      read("error_model = 'iscwsa'"),
      StartsWith("t.toml:3: error_model = \"iscwsa\": unknown error model: did you mean \"iscwsa_mwd_rev4\" or "));
  CHECK_THROWS_WITH(read(""), Contains("error_model.name: missing"));
  CHECK_THROWS_WITH(read("[error_model]\nname = 'iscwsa_mwd_rev4'\nfile = 'tool.toml'"),
                    StartsWith("t.toml:4: error_model.name = \"iscwsa_mwd_rev4\": must be \"tool.toml\""));
  CHECK_THROWS_WITH(read("[error_model]\nfile = 'tool.toml'\nscale = 2"), Contains("error_model.scale: unknown key"));
}

TEST_CASE("A leg has the stations deeper than its from; it keeps the model of the one before") {
  const ToolRuns legs = read(
      "error_model = 'iscwsa_mwd_rev4'\n[[leg]]\nfrom_md_ft = 100\nerror_model.file = 'tool.toml'\n"
      "[[leg]]\nfrom_md_m = 60.96\n");
  REQUIRE(legs.runs.size() == 3);
  CHECK(legs.runs[1].first == 2);  // the station at 100 ft is the tie-on of the second leg: the first tool's
  CHECK(legs.runs[2].first == 3);  // 200 ft, written in metres
  CHECK(legs.model_names[1] == "tool.toml");
  CHECK(legs.model_names[2] == "tool.toml");
  CHECK(legs.from_md[2] == Approx(60.96).epsilon(1e-13));
  // A depth may be rounded to a millimetre: the station at 200 ft is still the tie-on of the leg.
  CHECK(read("error_model = 'iscwsa_mwd_rev4'\n[[leg]]\nfrom_md_m = 60.9596").runs[1].first == 3);
  CHECK(read("error_model = 'iscwsa_mwd_rev4'\n[[leg]]\nfrom_md_m = 60.9589").runs[1].first == 2);
}

TEST_CASE("Legs out of order, without stations or with two depths are refused") {
  const std::string model = "error_model = 'iscwsa_mwd_rev4'\n";
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md_m = 500\n"),
                    StartsWith("t.toml:5: leg[0].from_md_m = 500: no station is deeper"));
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md_m = 0\n"), Contains("the leg before has no station"));
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md_m = 70\n[[leg]]\nfrom_md_m = 40\n"),
                    StartsWith("t.toml:7: leg[1].from_md_m = 40: the leg before has no station"));
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md_m = 40\nfrom_md_ft = 100\n"), Contains("not together with"));
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md = 40\n"), Contains("the unit is missing"));
  CHECK_THROWS_WITH(read(model + "[[leg]]\nfrom_md_m = 40\ntool = 'x'\n"), Contains("leg[0].tool: unknown key"));
}
