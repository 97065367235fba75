#include "config/error_model_file.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "project_files.h"

using namespace surveymc;
using namespace surveymc::config;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

error_model::Model read(const std::string& text) {
  Config config = Config::from_text("experiment = 'x'\nseed = 1\nmodel = 'tool.toml'\n", "c.toml", {},
                                    {{"tool.toml", text}, {"functions.toml", ""}});
  return *read_error_models(config.reader(0).toml("model", ""), "tool").back();
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
  const error_model::Model m = read(
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
  CHECK(m.terms[0].mode == error_model::PropagationMode::random);
  CHECK(m.terms[1].sigma == Approx(3000 * kDegree).epsilon(1e-13));
  CHECK(m.terms[1].mode == error_model::PropagationMode::well);
  CHECK(m.terms[2].sigma == 0);
  CHECK(m.terms[2].mode == error_model::PropagationMode::global);
  CHECK(m.terms[3].sigma == Approx(70).epsilon(1e-13));
  CHECK(m.terms[3].mode == error_model::PropagationMode::systematic);
}

TEST_CASE("A bad model file is refused with its line, key, value and rule") {
  const auto refused = [](const std::string& third, const std::string& message) {
    CAPTURE(third);
    CHECK_THROWS_WITH(read(with_third(third)), StartsWith(message));
  };
  refused(term("C", "function = 'DREFF', magnitude = 1, unit = 'm', mode = 'R'"),
          "tool.toml:4: terms[2].function = \"DREFF\": unknown function; did you mean \"DREF\"?");
  refused(term("C", "function = 'Q', magnitude = 1, unit = 'm', mode = 'R'"),
          "tool.toml:4: terms[2].function = \"Q\": must be one of \"ABIXY-TI1\", ");
  refused(term("C", "function = 'DREF', magnitude = 1, unit = 'nT', mode = 'R'"),
          "tool.toml:4: terms[2].unit = \"nT\": the unit of DREF must be \"m\" or \"ft\"");
  refused(term("C", "function = 'AZ', magnitude = 1, unit = 'degree', mode = 'R'"),
          "tool.toml:4: terms[2].unit = \"degree\": the unit of AZ must be \"-\", \"deg\" or \"rad\"");
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
  CHECK_THROWS_WITH(read("first_leg = 'once'\n"), Equals("tool.toml: terms: missing"));
  CHECK(read("first_leg = 'once'\nterms = []\n").terms.empty());  // a tool without errors
  CHECK_THROWS_WITH(read("first_leg = 'once'\nterms = 3\n"), StartsWith("tool.toml:2: terms = 3: must be"));
  CHECK_THROWS_WITH(read("first_leg = 'twice'\n"), StartsWith("tool.toml:1: first_leg = \"twice\": must be one of"));
  CHECK_THROWS_WITH(read("first_leg = 'once'\nterms = ["), StartsWith("tool.toml:2: "));
}

TEST_CASE("The models that come with the program are those of configs/error_models") {
  for (const InputText& m : shipped_error_model_files())
    CHECK(m.text == test::project_file("configs/error_models/" + m.path + ".toml"));
  const auto load = [](const char* name) { return load_shipped_model(*find_shipped_model(name)); };
  CHECK(load("iscwsa_mwd_rev4")->terms.size() == 27);
  CHECK_FALSE(load("iscwsa_mwd_rev4")->first_leg_doubled);
  CHECK(load("iscwsa_mwd_rev5.10")->terms.size() == 35);
  CHECK(load("iscwsa_mwd_rev5.10")->first_leg_doubled);
  CHECK(shipped_models().size() == 103);
}

TEST_CASE("A whole catalogue read as a file gives what its models give one by one") {
  for (const InputText& m : shipped_error_model_files()) {
    if (!m.path.starts_with("owsg")) continue;
    Config config = Config::from_text(
        "experiment = 'x'\nmodel = 'all.toml'\n", "c.toml", {},
        {{"all.toml", m.text}, {"functions.toml", test::project_file("configs/error_models/functions.toml")}});
    for (const SharedModel& model : read_error_models(config.reader(0).toml("model", ""), m.path)) {
      const ShippedModel* found = find_shipped_model(m.path + "/" + model->name);
      REQUIRE(found != nullptr);
      CHECK(model_text(*load_shipped_model(*found)) == model_text(*model));
    }
  }
}

namespace {

/// A function F on lines 1 and on.
std::string function(const std::string& rest) { return "[[function]]\nname = 'F'\n" + rest + "\n"; }
/// A model of one term of F.
std::string model(const std::string& rest, const std::string& unit = "-", const std::string& code = "T") {
  return "[[model]]\nname = 'M'\nfirst_leg = 'once'\n" + rest + "\nterms = [{ code = '" + code +
         "', function = 'F', magnitude = 1, unit = '" + unit + "', mode = 'S' }]\n";
}

}  // namespace

TEST_CASE("A bad function is refused with its line, name, formula, column and rule") {
  const auto refused = [](const std::string& rest, const std::string& message) {
    CAPTURE(rest);
    CHECK_THROWS_WITH(read(function(rest) + model("")), StartsWith("tool.toml:" + message));
  };
  refused("azimuth = 'Sin(Inc) * Cos(AzX)'",
          "3: function F: azimuth = \"Sin(Inc) * Cos(AzX)\": column 16: unknown variable \"AzX\"; did you mean \"AzM\" "
          "or \"AzT\"?");
  refused(
      "azimuth = 'Sinn(Inc)'",
      "3: function F: azimuth = \"Sinn(Inc)\": column 1: unknown function \"Sinn\"; did you mean \"Sign\" or \"Sin\"?");
  refused(
      "azimuth = 'Qwertz'",
      "3: function F: azimuth = \"Qwertz\": column 1: unknown variable \"Qwertz\"; there are MD, MDPrev, TVD, Inc, ");
  refused("azimuth = 'Sin(Inc, 2)'",
          "3: function F: azimuth = \"Sin(Inc, 2)\": column 1: Sin takes one argument, not 2");
  refused("azimuth = 'Sin(Inc'", "3: function F: azimuth = \"Sin(Inc\": column 4: this bracket is never closed");
  refused("azimuth = 'Inc Inc'", "3: function F: azimuth = \"Inc Inc\": column 5: nothing is expected here");
  refused("azimuth = 'Max(1, 10 / (MD - MDPrev))'",
          "3: function F: azimuth = \"Max(1, 10 / (MD - MDPrev))\": column 1: dimensions differ: pure number and 1/m");
  refused("azimuth = 'MD + 1'", "3: function F: azimuth = \"MD + 1\": column 4: dimensions differ: m + pure number");
  refused("azimuth = '1'\nlateral = '1'", "4: function F: lateral = \"1\": not together with azimuth");
  refused("lateral = '1'\nvertical_north = '1'", "4: function F: vertical_north = \"1\": not together with lateral");
  refused("azimuth = '1 / Sin(Inc)'", "3: function F: azimuth = \"1 / Sin(Inc)\": is singular in a vertical hole");
  refused("azimuth = '1 / Sin(Inc)'\nvertical_north = 'Sin(AzT)'\nvertical_east = 'Cos(AzT)'",
          "4: function F: vertical_north = \"Sin(AzT)\": the vertical formulas are not the limit");
  refused("azimuth = 'Previous + 1'",
          "3: function F: azimuth = \"Previous + 1\": Previous belongs to functions of kind \"continuous\"");
  refused("azimuth = 'MD / RunningSpeed'", "3: function F: azimuth = \"MD / RunningSpeed\": RunningSpeed belongs");
  refused("kind = 'moving'", "3: function[0].kind = \"moving\": must be one of");
  refused("kind = 'continuous'\naxis = 'Q'\nazimuth = 'Previous'", "4: function[0].axis = \"Q\": must be one of");
  refused("axis = 'Z'\nazimuth = '1'", "3: function[0].axis = \"Z\": only a function of kind");
  refused("azimuht = '1'", "3: function[0].azimuht: unknown key: did you mean function[0].azimuth?");
  refused("depth = '1'\ninclination = 'Sin(Inc)'",
          "3: function F: depth = \"1\": column 1: depth wants a magnitude in m");
  refused("azimuth = '1'\n[[function]]\nname = 'F'", "5: function[1].name = \"F\": two functions have this name");
}

TEST_CASE("A bad model is refused with its line and rule") {
  const std::string good = function("azimuth = '1'");
  const auto refused = [&](const std::string& text, const std::string& message) {
    CAPTURE(text);
    CHECK_THROWS_WITH(read(text), Catch::Matchers::Contains(message));
  };
  refused(good + model("", "m/s2"), "terms[0].unit = \"m/s2\": the unit of F must be \"-\", \"deg\" or \"rad\"");
  refused(function("azimuth = '1 / GField'") + model("", "nT"), "the unit of F must be \"m/s2\"");
  refused(good + model("parameters = { MinCourseLength_m = 10 }"), "no formula of this model has MinCourseLength");
  refused(good + model("parameters = { Speed = 10 }"), "parameters.Speed: unknown key");
  refused(good + model("inclination_range_deg = [20, 10]"), "must be [from, to] with from <= to");
  refused(good + model("remove = ['A']"), "only with extends");
  refused(good + model("extends = 'MWD+IFR9'"), "did you mean \"MWD+IFR1\"?");
  refused(good + model("") + model(""), "model[1].name = \"M\": two models have this name");
  refused(good + model("extends = 'N'") + "[[model]]\nname = 'N'\nextends = 'M'\n", "extend each other in a circle");
  refused(good + model("extends = 'M'"), "extend each other in a circle");
  refused(good + model("") + "[[model]]\nname = 'N'\nextends = 'M'\nremove = ['X']\n", "has no term \"X\"");
  const std::string sum = "kind = 'continuous'\naxis = 'XY'\nazimuth = 'Previous + (MD - MDPrev) / RunningSpeed'";
  refused(function(sum) + model("", "deg/hr"), "term T: F is continuous: the model must have gyro");
  const std::string zone = "gyro = { initialise_at_deg = 15, zones = [ { axis = 'Z', from_deg = 0, to_deg = 90";
  refused(function(sum) + model(zone + ", speed_m_per_h = 3600 } ] }", "deg/hr"), "needs a zone of axis \"XY\"");
  refused(function(sum) + model(zone + "} ] }", "deg/hr"), "speed_m_per_h: missing");
  refused(
      good + model(zone + ", speed_m_per_h = 1 }, { axis = 'XY', from_deg = 50, to_deg = 90, speed_m_per_h = 2 } ] }"),
      "zones that overlap must have one speed");
  refused(good + model("gyro = { initialise_at_deg = 'top', zones = [] }"), "must be \"leg start\"");
}

TEST_CASE("A model extends another: terms are replaced, added and removed, and what is not said stays") {
  const std::string text = function("azimuth = '1'") + model("east_west_exclusion_deg = 15\ntitle = 'base'") +
                           "[[model]]\nname = 'N'\nextends = 'M'\ntitle = 'changed'\nterms = [\n"
                           "{ code = 'T', function = 'F', magnitude = 3, unit = '-', mode = 'R' },\n"
                           "{ code = 'U', function = 'AZ', magnitude = 2, unit = 'deg', mode = 'R' } ]\n"
                           "[[model]]\nname = 'O'\nextends = 'N'\nremove = ['T']\n";
  const error_model::Model o = read(text);
  CHECK(o.name == "O");
  CHECK(o.title == "changed");
  CHECK(o.east_west_exclusion == Approx(15 * kDegree).epsilon(1e-13));
  REQUIRE(o.terms.size() == 1);
  CHECK(o.terms[0].code == "U");
  CHECK(o.terms[0].sigma == Approx(2 * kDegree).epsilon(1e-13));
}

TEST_CASE("Functions of a file go before the shipped ones, and a file of functions is found beside the model") {
  Config config = Config::from_text(
      "experiment = 'x'\nmodel = 'tools/mine.toml'\n", "c.toml", {},
      {{"tools/mine.toml",
        "functions = 'formulas.toml'\n[[function]]\nname = 'AZ'\nazimuth = '2'\n[[model]]\nname = 'M'\nfirst_leg = "
        "'once'\n"
        "terms = [{ code = 'A', function = 'AZ', magnitude = 1, unit = '-', mode = 'S' },\n"
        "{ code = 'B', function = 'OWN', magnitude = 1, unit = '-', mode = 'S' },\n"
        "{ code = 'C', function = 'SAG', magnitude = 1, unit = 'deg', mode = 'S' }]\n"},
       {"tools/formulas.toml",
        "[[function]]\nname = 'OWN'\ninclination = 'Cos(Inc)'\n[[function]]\nname = 'AZ'\nazimuth = '3'\n"}});
  ConfigReader reader = config.reader(0);
  const SharedModel m = read_error_models(reader.toml("model", ""), "mine").back();
  CHECK(m->terms[0].function->azimuth.text == "2");
  CHECK(m->terms[1].function->inclination.text == "Cos(Inc)");
  CHECK(m->terms[2].function == shipped_functions().at("SAG"));
  CHECK(config.input_texts().size() == 2);
}

TEST_CASE("Terms that are inherited act by the functions of the file, whether shipped or of another model") {
  const std::string own = "[[function]]\nname = 'ABXY-TI2'\nlateral = '3 * Cos(Inc) / GField'\n";
  const std::string mine = "[[model]]\nname = 'M'\nextends = 'MWD+IFR1'\n";
  const auto read_files = [](std::vector<InputText> files) {
    for (const ShippedModel* s = find_shipped_model("MWD+IFR1"); s != nullptr;
         s = s->extends.empty() ? nullptr : find_shipped_model(s->extends))
      files.push_back(shipped_document(*s));
    Config config = Config::from_text("experiment = 'x'\nmodel = 'mine.toml'\n", "c.toml", {}, files);
    return *read_error_models(config.reader(0).toml("model", ""), "mine").back();
  };
  const auto read = [&](const std::string& text) { return read_files({{"mine.toml", text}}); };
  const auto term_of = [](const error_model::Model& m, const std::string& code) {
    for (const error_model::Term& t : m.terms)
      if (t.code == code) return t;
    FAIL("no term " + code);
    return m.terms.front();
  };
  for (const std::string& text : {own + mine, own + mine + "[[model]]\nname = 'N'\nextends = 'M'\n"}) {
    const error_model::Model m = read(text);
    const error_model::Term t = term_of(m, "ABXY-TI2S");
    CHECK(t.function->lateral.text == "3 * Cos(Inc) / GField");
    CHECK(t.sigma == 0.004);
    CHECK(term_of(m, "SAGE").function == shipped_functions().at("SAGE"));
    CHECK_THAT(model_text(m), Catch::Matchers::Contains("3 * Cos(Inc) / GField"));
  }
  // In a file of functions, too.
  const error_model::Model m =
      read_files({{"mine.toml", "functions = 'formulas.toml'\n" + mine}, {"formulas.toml", own}});
  CHECK(term_of(m, "ABXY-TI2S").function->file == "formulas.toml");
  // The magnitude that is inherited must fit, but for terms that the model removes or has anew.
  const std::string other = "[[function]]\nname = 'ABXY-TI2'\nlateral = 'Cos(Inc)'\n";
  CHECK_THROWS_WITH(read(other + mine), Catch::Matchers::Contains(
                                            "extends = \"MWD+IFR1\": its term ABXY-TI2S has the unit m/s2, but that of "
                                            "\"ABXY-TI2\" in this file must be \"-\", \"deg\" or \"rad\""));
  CHECK_NOTHROW(read(other + mine + "remove = ['ABXY-TI2S']\n"));
  CHECK_NOTHROW(
      read(other + mine +
           "terms = [{ code = 'ABXY-TI2S', function = 'ABXY-TI2', magnitude = 1, unit = 'deg', mode = 'S' }]\n"));
}

TEST_CASE("Models are chosen by patterns, in the order of the catalogues") {
  CHECK(matching_shipped_models({"ZERO*"}, {}) == std::vector<std::string>{"ZERO-ERROR"});
  CHECK(matching_shipped_models({"*"}, {}).size() == 103);
  CHECK(matching_shipped_models({"*"}, {"*_Fl"}).size() == 54);
  const auto srgm = matching_shipped_models({"MWD+SRGM*"}, {"*_Fl", "*AX*"});
  REQUIRE(srgm.size() >= 2);
  CHECK(srgm[0] == "MWD+SRGM");
  CHECK(srgm[1] == "MWD+SRGM+SAG");
  CHECK(matching_shipped_models({"mwd"}, {}).empty());
  CHECK(matching_shipped_models({"MWD*SRGM*MS"}, {}) == matching_shipped_models({"MWD+SRGM*MS"}, {}));
  CHECK(matching_shipped_models({"MWD*MWD"}, {}).empty());  // two pieces do not share letters
  CHECK(matching_shipped_models({"*S*S*"}, {}).size() > matching_shipped_models({"*S*S*S*"}, {}).size());
  const std::string stars(10000, '*');  // trying all places for each star would not end
  CHECK(matching_shipped_models({"MWD" + stars + "SAG"}, {}) == matching_shipped_models({"MWD*SAG"}, {}));
  CHECK(matching_shipped_models({"MWD" + stars + "?"}, {}).empty());
}
