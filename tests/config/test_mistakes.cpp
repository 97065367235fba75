#include <catch2/catch.hpp>

#include "config/config.h"

using namespace surveymc::config;
using Catch::Matchers::Contains;

namespace {

const KeyTypes kKeysOfStudy{{"a.x_m", "number"},        {"a.kind", "text"},
                            {"b.y_m", "number"},        {"b.z_m", "number"},
                            {"leg", "array of tables"}, {"leg[].from_m", "number"},
                            {"leg[].name", "text"},     {"grid", "number, list or { from, to, step }"}};

void read_small_study(ConfigReader& c) {
  const double x = c.number("a.x_m", Range::closed(0, 10), "");
  const bool is_small = c.choice("a.kind", {"small", "large"}, "") == "small";
  c.number("b.y_m", Range::closed(0, 10), "");
  if (is_small) c.number("b.z_m", Range::closed(0, 10), "");
  for (ConfigReader& leg : c.tables("leg", "")) {
    leg.number("from_m", Range::non_negative(), "");
    leg.text("name", "", "");
  }
  c.require(x != 5, "a.x_m", "must not be 5");
  if (c.has("grid")) c.grid("grid", {}, "");
  c.finish();
}

std::vector<std::string> mistakes_in(const std::string& body) {
  Config config = Config::from_text("experiment = 'e'\n" + body, "t.toml", {});
  return ConfigReader::mistakes_of(
      config, 0, [](KeysOf) { return kKeysOfStudy; }, read_small_study);
}

using Told = std::vector<std::string>;

}  // namespace

TEST_CASE("All mistakes are found: unknown keys first, then what getters refuse") {
  CHECK(mistakes_in("[a]\nx_m = 1\nkind = 'large'\n[b]\ny_m = 2\n").empty());
  CHECK(mistakes_in(
            "[a]\nx_m = 11\nkind = 'large'\nkin = 3\n[b]\ny_m = 'w'\n[[leg]]\nfrom_m = -1\n[[leg]]\nfom_m = 3\n") ==
        Told{"t.toml:5: a.kin: unknown key: did you mean a.kind?",
             "t.toml:11: leg[1].fom_m: unknown key: did you mean leg[1].from_m?",
             "t.toml:3: a.x_m = 11: must be in [0, 10]", "t.toml:7: b.y_m = \"w\": must be a number",
             "t.toml:9: leg[0].from_m = -1: must be >= 0"});
}

TEST_CASE("Keys that are missing are told together") {
  CHECK(mistakes_in("[a]\nkind = 'small'\n") ==
        Told{"t.toml: a.x_m: missing", "t.toml: b.y_m: missing", "t.toml: b.z_m: missing"});
}

TEST_CASE("What a stand-in may be to blame for is left out") {
  // The wrong word decides whether z is needed; y is wrong whatever it decides.
  CHECK(mistakes_in("[a]\nx_m = 1\nkind = 'tiny'\n[b]\ny_m = 12\n") ==
        Told{"t.toml:4: a.kind = \"tiny\": must be one of \"small\", \"large\"",
             "t.toml:6: b.y_m = 12: must be in [0, 10]"});
  // Whether z is known depends on the word, too.
  CHECK(mistakes_in("[a]\nx_m = 1\nkind = 3\n[b]\ny_m = 1\nz_m = 2\n").size() == 1);
  // A key that no branch knows is unknown whatever the word is.
  CHECK(mistakes_in("[a]\nx_m = 1\nkind = 3\n[b]\ny_m = 1\nzz_m = 2\n").size() == 2);
  // A rule between keys, after a stand-in.
  CHECK(mistakes_in("[a]\nx_m = 5\nkind = 'large'\n[b]\ny_m = 1\n") == Told{"t.toml:3: a.x_m = 5: must not be 5"});
  CHECK(mistakes_in("[a]\nx_m = 5\nkind = 'large'\n[b]\ny_m = 11\n").size() == 1);
}

TEST_CASE("Keys that no shipped config has are looked for in all branches, and only if one is left") {
  std::vector<KeysOf> asked;
  const auto mistakes = [&](const std::string& body) {
    asked.clear();
    Config config = Config::from_text("experiment = 'e'\n" + body, "t.toml", {});
    return ConfigReader::mistakes_of(
        config, 0,
        [&](KeysOf which) {
          asked.push_back(which);
          KeyTypes known = kKeysOfStudy;
          if (which == KeysOf::shipped_configs) known.erase("grid");
          return known;
        },
        read_small_study);
  };
  using Asked = std::vector<KeysOf>;
  // The rule ends the reading before `grid` is asked for.
  const std::string rule = "[a]\nx_m = 5\nkind = 'large'\n[b]\ny_m = 1\n", grid = "grid = [1.0]\n";
  CHECK(mistakes(rule + "z_m = 1\n") == Told{"t.toml:3: a.x_m = 5: must not be 5"});
  CHECK(asked == Asked{KeysOf::shipped_configs});
  CHECK(mistakes(grid + rule) == Told{"t.toml:4: a.x_m = 5: must not be 5"});
  CHECK(asked == Asked{KeysOf::shipped_configs, KeysOf::all_branches});
  CHECK(mistakes(grid + "home = 1\n" + rule) ==
        Told{"t.toml:3: home: unknown key", "t.toml:5: a.x_m = 5: must not be 5"});
  CHECK(asked == Asked{KeysOf::shipped_configs, KeysOf::all_branches});
}

TEST_CASE("Keys behind the one that ends the reading are known") {
  // `grid` was not asked for: the rule ended the reading before.
  CHECK(mistakes_in("grid = { from = 0, to = 1, step = 1 }\nhome = 1\n[a]\nx_m = 5\nkind = 'large'\n[b]\ny_m = 1\n") ==
        Told{"t.toml:3: home: unknown key", "t.toml:5: a.x_m = 5: must not be 5"});
}
