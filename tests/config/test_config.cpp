#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include <catch2/catch.hpp>

#include "config/config.h"
#include "message_of.h"
#include "temporary_folder.h"

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using surveymc::message_of;
using surveymc::config::Config;
using surveymc::config::ConfigReader;
using surveymc::config::format_number;
using surveymc::config::InputTable;
using surveymc::config::Range;
using surveymc::config::SweepValue;

namespace fs = std::filesystem;

namespace {

class Folder : public surveymc::TemporaryFolder {
 public:
  fs::path write(const std::string& name, const std::string& text) const {
    const fs::path file = path / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
};

/// Two lines that every config needs; a text after them starts at line 3.
const std::string kHead = "experiment = \"test\"\nseed = 1\n";

Config config_of(const std::string& body, const std::vector<InputTable>& files = {}) {
  return Config::from_text(kHead + body, "t.toml", files);
}

std::string fault(const std::string& body) {
  return message_of([&] { config_of(body); });
}

/// What `read` throws at point 0 of a config.
template <class F>
std::string fault(const std::string& body, F&& read) {
  return message_of([&] {
    auto config = config_of(body);
    auto reader = config.reader(0);
    read(reader);
  });
}

/// A config on disk, because only that can have --set arguments.
struct Overridden {
  Folder folder;
  std::string file;
  explicit Overridden(const std::string& body) : file(folder.write("t.toml", kHead + body).string()) {}
  Config load(const std::vector<std::string>& overrides) const { return Config::load(file, overrides); }
  std::string fault(const std::vector<std::string>& overrides) const {
    return message_of([&] { load(overrides); });
  }
};

std::string sweep_text(const Config& config, std::size_t point) {
  std::string out;
  for (const auto& [key, value] : config.sweep_values(point)) {
    out += (out.empty() ? "" : " ") + key + "=";
    out +=
        std::holds_alternative<double>(value) ? format_number(std::get<double>(value)) : std::get<std::string>(value);
  }
  return out;
}

const Range kAny{};

}  // namespace

// ------------------------------------------------------------------------------------------------------ whole files

TEST_CASE("Config: experiment, seed and title belong to the file") {
  const auto config =
      Config::from_text("experiment = 'e'\nseed = 9223372036854775807\ntitle = 'A title'\n", "t.toml", {});
  CHECK(config.experiment() == "e");
  CHECK(config.seed() == 9223372036854775807ULL);
  CHECK(config.title() == "A title");
  CHECK(config.point_count() == 1);
  CHECK(config.sweep_values(0).empty());
  CHECK(config_of("").title().empty());

  const auto of = [](const std::string& text) {
    return message_of([&] { Config::from_text(text, "t.toml", {}).seed(); });
  };
  CHECK(of("") == "t.toml: experiment: missing");
  CHECK(config.has_seed());
  CHECK_FALSE(Config::from_text("experiment = 'e'\n", "t.toml", {}).has_seed());  // right where nothing is drawn
  CHECK(of("experiment = 'e'\n") == "t.toml: seed: missing");
  CHECK(of("experiment = 'e'\n[field]\nseed = 4\n") ==
        "t.toml:3: seed: missing (found field.seed: write it above the first [table])");
  CHECK(of("experiment = 3\nseed = 1\n") == "t.toml:1: experiment = 3: must be a string");
  CHECK(of("experiment = ''\nseed = 1\n") == "t.toml:1: experiment = \"\": must not be empty");
  CHECK(of("experiment = 'e'\nseed = -1\n") == "t.toml:2: seed = -1: must be in [0, 9223372036854775807]");
  CHECK(of("experiment = 'e'\nseed = 1.0\n") == "t.toml:2: seed = 1.0: must be an integer");
  CHECK(of("experiment = 'e'\nseed = '1'\n") == "t.toml:2: seed = \"1\": must be an integer");
  CHECK(of(kHead + "title = 3\n") == "t.toml:3: title = 3: must be a string");
  CHECK(of("experiment = 'e'\nsed = 1\n") == "t.toml:2: seed: missing (found sed)");
}

TEST_CASE("Config: rules for keys of the file name place and value") {
  const Overridden file("t.name = 'n'\n[sweep]\nx = [1, 2]\n");
  const auto of = [&](const std::vector<std::string>& overrides, const std::string& key) {
    return message_of([&] { file.load(overrides).fail(key, "must be \"other\""); });
  };
  CHECK(of({}, "experiment") == file.file + ":1: experiment = \"test\": must be \"other\"");
  CHECK(of({"experiment=foo"}, "experiment") == "--set experiment=foo: experiment = \"foo\": must be \"other\"");
  CHECK(of({}, "t") == file.file + ":3: t.name = \"n\": must be \"other\"");
  CHECK(of({}, "title") == file.file + ": title: must be \"other\"");
}

TEST_CASE("Config: syntax errors have a line") {
  CHECK(fault("x = \n") == "t.toml:3: Error while parsing key-value pair: expected value, saw '\\n'");
  CHECK(fault("x = 1\nx = 2\n").substr(0, 9) == "t.toml:4:");
  CHECK(fault("x = 1e400\n").substr(0, 9) == "t.toml:3:");
  CHECK(fault("x = 99999999999999999999\n").substr(0, 9) == "t.toml:3:");
  CHECK_THAT(fault("x = 12,5\n"), StartsWith("t.toml:3: ") && EndsWith("; the decimal mark is a point: 12.5"));
  CHECK_THAT(fault("x = own_well.csv  # mine\n"),
             StartsWith("t.toml:3: ") && EndsWith("; a text stands in quotes: \"own_well.csv\""));
  CHECK_THAT(fault("x = \"C:\\data\\w.csv\"\n"),
             StartsWith("t.toml:3: ") && EndsWith("a \\ begins an escape: write a path with /, or in '...'"));
  CHECK_THAT(fault("x = \xE2\x80\x9C"
                   "a\xE2\x80\x9D\n"),
             EndsWith("; a text stands in straight quotes: \"...\""));
  for (const char* other : {"x = [1, 2\n", "x = {\n", "x = \"a\n", "x\n"})
    CHECK_THAT(fault(other), StartsWith("t.toml:") && !Contains("quotes:") && !Contains("decimal mark"));
  CHECK(fault("x = '\xFF'\n").substr(0, 9) == "t.toml:3:");
  // toml++ 3.3 aborts on these if it is compiled with its assertions; the library of the system is not.
  CHECK(fault("[.a]\n").substr(0, 9) == "t.toml:3:");
  CHECK(fault("\xC3\xA9 = 1\n").substr(0, 9) == "t.toml:3:");
}

TEST_CASE("Config: a file that cannot be read") {
  const Folder folder;
  const std::string absent = (folder.path / "x.toml").string(), itself = folder.path.string();
  CHECK(message_of([&] { Config::load(absent, {}); }) == absent + ": cannot be read: No such file or directory");
  CHECK(message_of([&] { Config::load(itself, {}); }) == itself + ": cannot be read: it is a folder");
  const auto binary = folder.write("b.toml", std::string("\x89HDF\r\n\x1a\n\0\0", 10)).string();
  CHECK(message_of([&] { Config::load(binary, {}); }).substr(0, binary.size() + 3) == binary + ":1:");
}

TEST_CASE("Config: NaN and infinity are refused wherever they stand, read or not") {
  CHECK(fault("x = nan\n") == "t.toml:3: x = nan: must be a finite number");
  CHECK(fault("[field]\ndip_deg = -inf\n") == "t.toml:4: field.dip_deg = -inf: must be a finite number");
  CHECK(fault("x = [1, 2,\n +inf]\n") == "t.toml:4: x[2] = inf: must be a finite number");
  CHECK(fault("x = { a = 1, b = nan }\n") == "t.toml:3: x.b = nan: must be a finite number");
  CHECK(fault("[[p]]\n[[p]]\nv = nan\n") == "t.toml:5: p[1].v = nan: must be a finite number");
  CHECK(fault("[sweep]\n\"noise.scale\" = [1, nan]\n") ==
        "t.toml:4: sweep.\"noise.scale\"[1] = nan: must be a finite number");
  CHECK(Overridden("").fault({"field.dip_deg=nan"}) ==
        "--set field.dip_deg=nan: field.dip_deg = nan: must be a finite number");
  CHECK(Overridden("").fault({"x=[1, inf]"}) == "--set x=[1, inf]: x[1] = inf: must be a finite number");
}

// ---------------------------------------------------------------------------------------------------------- getters

TEST_CASE("Config: a number out of range says place, value, rule") {
  const std::string body = "trials = 3\n[field]\n# comment\ntotal_nT = 50000\ndip_deg = 95\n";
  CHECK(fault(body, [](ConfigReader& r) { r.number("field.dip_deg", Range::closed(-90, 90), ""); }) ==
        "t.toml:7: field.dip_deg = 95: must be in [-90, 90]");
  const auto rule = [&](const Range& range) {
    return fault("x = -1.5\n", [&](ConfigReader& r) { r.number("x", range, ""); });
  };
  CHECK(rule(Range::positive()) == "t.toml:3: x = -1.5: must be > 0");
  CHECK(rule(Range::non_negative()) == "t.toml:3: x = -1.5: must be >= 0");
  CHECK(rule(Range::open(0, 1)) == "t.toml:3: x = -1.5: must be in (0, 1)");
  CHECK(rule({0, 1, false, true}) == "t.toml:3: x = -1.5: must be in [0, 1)");
  CHECK(rule({.hi = -2}) == "t.toml:3: x = -1.5: must be <= -2");
  CHECK(rule({.hi = -1.5, .hi_open = true}) == "t.toml:3: x = -1.5: must be < -1.5");
  CHECK(rule(Range::closed(-1.5, -1.5)).empty());
  CHECK(rule(kAny).empty());
}

TEST_CASE("Config: values have the kind that was asked for") {
  const std::string body = "i = 3\nx = 3.0\ns = 'abc'\nb = true\na = [1]\nd = 2020-01-01\n[t]\nk = 1\nh = 3.5\n";
  auto config = config_of(body);
  auto r = config.reader(0);
  CHECK(r.number("i", kAny, "") == 3);  // an integer is a number
  CHECK(r.number("x", kAny, "") == 3);
  CHECK(r.integer("i", 0, 3, "") == 3);
  CHECK(r.integer("x", 0, 3, "") == 3);  // as one writes 1e6 trials
  CHECK(r.text("s", "") == "abc");
  CHECK(r.boolean("b", "", false));
  CHECK(r.choice("s", {"x", "abc"}, "") == "abc");

  const auto of = [&](auto read) { return fault(body, read); };
  CHECK(of([](ConfigReader& q) { q.number("s", kAny, ""); }) == "t.toml:5: s = \"abc\": must be a number");
  CHECK(of([](ConfigReader& q) { q.number("b", kAny, ""); }) == "t.toml:6: b = true: must be a number");
  CHECK(of([](ConfigReader& q) { q.number("a", kAny, ""); }) == "t.toml:7: a = [1]: must be a number");
  CHECK(of([](ConfigReader& q) { q.number("d", kAny, ""); }) == "t.toml:8: d = 2020-01-01: must be a number");
  CHECK(of([](ConfigReader& q) { q.number("t", kAny, ""); }) == "t.toml:9: t: must be a number");
  CHECK(of([](ConfigReader& q) { q.number("s", kAny, "", 1); }) == "t.toml:5: s = \"abc\": must be a number");
  CHECK(of([](ConfigReader& q) { q.integer("x", 4, 9, ""); }) == "t.toml:4: x = 3: must be in [4, 9]");
  CHECK(of([](ConfigReader& q) { q.integer("t.h", 0, 9, ""); }) == "t.toml:11: t.h = 3.5: must be an integer");
  CHECK(of([](ConfigReader& q) { q.integer("t.h", 0, 9, "", 1); }) == "t.toml:11: t.h = 3.5: must be an integer");
  CHECK(of([](ConfigReader& q) { q.integer("s", 0, 9, ""); }) == "t.toml:5: s = \"abc\": must be an integer");
  CHECK(of([](ConfigReader& q) { q.integer("i", 4, 9, ""); }) == "t.toml:3: i = 3: must be in [4, 9]");
  CHECK(of([](ConfigReader& q) { q.integer("i", 4, INT64_MAX, ""); }) == "t.toml:3: i = 3: must be >= 4");
  CHECK(of([](ConfigReader& q) { q.boolean("i", "", true); }) == "t.toml:3: i = 3: must be true or false");
  CHECK(of([](ConfigReader& q) { q.text("i", ""); }) == "t.toml:3: i = 3: must be a string");
  CHECK(of([](ConfigReader& q) { q.text("i", "", "x"); }) == "t.toml:3: i = 3: must be a string");
  CHECK(of([](ConfigReader& q) { q.text("t", ""); }) == "t.toml:9: t: must be a string");
  CHECK(of([](ConfigReader& q) {
          q.choice("s", {"x", "y"}, "");
        }) == "t.toml:5: s = \"abc\": must be one of \"x\", \"y\"");
  CHECK(of([](ConfigReader& q) { q.choice("b", {"x", "y"}, ""); }).ends_with("must be one of \"x\", \"y\""));
  CHECK(of([](ConfigReader& q) {
          q.choice("i", {"x", "y"}, "", "x");
        }) == "t.toml:3: i = 3: must be one of \"x\", \"y\"");
  CHECK(of([](ConfigReader& q) { q.number("i.k", kAny, ""); }) == "t.toml:3: i = 3: must be a table: write [i]");
  CHECK(of([](ConfigReader& q) { q.number("i.k", kAny, "", 1); }) == "t.toml:3: i = 3: must be a table: write [i]");
}

TEST_CASE("Config: true without quotes is the word of a choice that has it") {
  auto config = config_of("north = true\n");
  auto r = config.reader(0);
  CHECK(r.is_text("north"));
  CHECK(r.choice("north", {"true", "grid"}, "") == "true");
  CHECK(r.choice("north", {"true", "grid"}, "", "grid") == "true");
}

TEST_CASE("Config: fallbacks are used only for what is absent") {
  auto config = config_of("[noise]\nscale = 2.0\n");
  auto r = config.reader(0);
  CHECK(r.has("noise.scale"));
  CHECK(r.has("noise"));
  CHECK_FALSE(r.has("noise.law"));
  CHECK_FALSE(r.has("noise.scale.x"));
  CHECK_FALSE(r.has("field.total_nT"));
  CHECK(r.number("noise.scale", kAny, "", 1) == 2);
  CHECK(r.number("noise.x", kAny, "", 1) == 1);
  CHECK(r.integer("noise.n", 0, 9, "", 5) == 5);
  CHECK(r.boolean("noise.b", "", true));
  CHECK(r.text("noise.t", "", "u") == "u");
  CHECK(r.choice("noise.law", {"normal", "laplace"}, "", "normal") == "normal");
  CHECK(r.numbers("noise.v", kAny, "", 2, std::vector<double>{1, 2}) == std::vector<double>{1, 2});
  CHECK(r.number("noise.x", kAny, "", 7) == 7);  // asking again does not make it present
  CHECK_FALSE(r.has("noise.x"));
  r.finish();
}

TEST_CASE("Config: lists of numbers") {
  const std::string body = "v = [1, 2.5, -3]\nempty = []\nmixed = [1, 'a']\nx = 1\n";
  auto config = config_of(body);
  auto r = config.reader(0);
  CHECK(r.numbers("v", kAny, "") == std::vector<double>{1, 2.5, -3});
  CHECK(r.numbers("v", kAny, "", 3, std::vector<double>{0}) == std::vector<double>{1, 2.5, -3});
  const auto of = [&](auto read) { return fault(body, read); };
  CHECK(of([](ConfigReader& q) { q.numbers("v", kAny, "", 2); }) == "t.toml:3: v = [1, 2.5, -3]: must have 2 numbers");
  CHECK(of([](ConfigReader& q) { q.numbers("empty", kAny, "", 3); }) == "t.toml:4: empty = []: must have 3 numbers");
  CHECK(of([](ConfigReader& q) { q.numbers("empty", kAny, ""); }) == "t.toml:4: empty = []: must not be empty");
  CHECK(of([](ConfigReader& q) { q.numbers("v", Range::positive(), ""); }) == "t.toml:3: v[2] = -3: must be > 0");
  CHECK(of([](ConfigReader& q) { q.numbers("mixed", kAny, ""); }) == "t.toml:5: mixed[1] = \"a\": must be a number");
  CHECK(of([](ConfigReader& q) { q.numbers("x", kAny, "", 3); }) == "t.toml:6: x = 1: must be a list of 3 numbers");
  CHECK(of([](ConfigReader& q) { q.numbers("x", kAny, "", 1); }) == "t.toml:6: x = 1: must be a list of 1 number");
  CHECK(of([](ConfigReader& q) { q.numbers("v", kAny, "", 1); }) == "t.toml:3: v = [1, 2.5, -3]: must have 1 number");
  CHECK(of([](ConfigReader& q) { q.numbers("x", kAny, ""); }) == "t.toml:6: x = 1: must be a list of numbers");
  CHECK(of([](ConfigReader& q) { q.numbers("none", kAny, ""); }) == "t.toml: none: missing");
}

TEST_CASE("Config: grids from a number, a list or steps") {
  const auto grid = [](const std::string& value, const Range& range = {}) {
    auto config = config_of("g = " + value + "\n");
    auto r = config.reader(0);
    auto x = r.grid("g", range, "");
    r.finish();
    return x;
  };
  using V = std::vector<double>;
  CHECK(grid("3") == V{3});
  CHECK(grid("[1, 2, 4.5]") == V{1, 2, 4.5});
  CHECK(grid("[3, 2, -1]") == V{3, 2, -1});
  CHECK(grid("{ from = 0.0, to = 180.0, step = 90.0 }") == V{0, 90, 180});
  CHECK(grid("{ from = 0, to = 100, step = 30 }") == V{0, 30, 60, 90});  // `to` is no step
  CHECK(grid("{ from = 2, to = -2, step = -2 }") == V{2, 0, -2});
  CHECK(grid("{ from = 5, to = 5, step = 1 }") == V{5});
  // Decimals come out as the decimals one would write, without the sum of rounding errors.
  CHECK(grid("{ from = -0.2, to = 0.7, step = 0.1 }") == V{-0.2, -0.1, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7});
  // 1/3 in 16 digits: three steps miss 1 by less than 1e-9 of a step, so 1 is the last value, exactly.
  CHECK(grid("{ from = 0, to = 1, step = 0.3333333333333333 }").size() == 4);
  CHECK(grid("{ from = 0, to = 1, step = 0.3333333333333333 }").back() == 1);
  CHECK(grid("{ from = 0, to = 1, step = 0.33333333 }").size() == 4);
  CHECK(grid("{ from = 0, to = 1, step = 0.33333333 }").back() < 1);
  CHECK(grid("{ from = 0, to = 0.9999, step = 0.33333333 }").size() == 3);
  CHECK(grid("{ from = 0, to = 9999998, step = 1 }").size() == 9999999);

  const auto of = [&](const std::string& value, const Range& range = {}) {
    return message_of([&] { grid(value, range); });
  };
  CHECK(of("[]") == "t.toml:3: g = []: must not be empty");
  CHECK(of("'a'") == "t.toml:3: g = \"a\": must be a number, a list of numbers or { from, to, step }");
  CHECK(of("[1, 2, 2]") == "t.toml:3: g[2] = 2: is in the list twice");
  CHECK(of("[1, 1]") == "t.toml:3: g[1] = 1: is in the list twice");
  CHECK(of("[1, 3, 2]") == "t.toml:3: g[2] = 2: the list must rise or fall throughout");
  CHECK(of("[3, 1, 2]") == "t.toml:3: g[2] = 2: the list must rise or fall throughout");
  CHECK(of("[1,\n 200]", Range::closed(0, 180)) == "t.toml:4: g[1] = 200: must be in [0, 180]");
  CHECK(of("-1", Range::positive()) == "t.toml:3: g = -1: must be > 0");
  CHECK(of("{ from = 0, to = 200, step = 10 }", Range::closed(0, 180)) == "t.toml:3: g.to = 200: must be in [0, 180]");
  CHECK(of("{ from = 0, to = 1, step = 0 }") == "t.toml:3: g.step = 0: must not be 0");
  CHECK(of("{ from = 0, to = 1, step = -0.1 }") == "t.toml:3: g.step = -0.1: must lead from 0 to 1");
  CHECK(of("{ from = 0, to = 1, step = 1e-8 }") == "t.toml:3: g.step = 1e-08: gives more than 1e7 values");
  CHECK(of("{ from = 1e16, to = 10000000000000010, step = 0.5 }") ==
        "t.toml:3: g.step = 0.5: is too small to change 1e+16");
  CHECK(of("{ from = 0, to = 1 }") == "t.toml:3: g.step: missing");
  CHECK(of("{ from = 0, to = 1, step = 'a' }") == "t.toml:3: g.step = \"a\": must be a number");
  CHECK(of("{ from = 0, to = 1, stp = 1 }") == "t.toml:3: g.stp: unknown key: did you mean g.step?");
  CHECK(of("{ from = 0, to = 1, step = 1, n = 3 }") == "t.toml:3: g.n: unknown key");
}

TEST_CASE("Config: strings, lists of strings and tables of numbers") {
  const std::string body =
      "one = 'a'\nmany = ['a', 'b']\nnone = []\nbad = ['a', 1]\nt = { y = 2, x = 1.5 }\nt2 = { x = 'a' }\n";
  auto config = config_of(body);
  auto r = config.reader(0);
  CHECK(r.texts("one", "") == std::vector<std::string>{"a"});
  CHECK(r.texts("many", "") == std::vector<std::string>{"a", "b"});
  CHECK(r.number_table("t", kAny, "") == std::vector<std::pair<std::string, double>>{{"x", 1.5}, {"y", 2}});
  const auto of = [&](auto read) { return fault(body, read); };
  CHECK(of([](ConfigReader& q) { q.texts("none", ""); }) == "t.toml:5: none = []: must not be empty");
  CHECK(of([](ConfigReader& q) { q.texts("bad", ""); }) == "t.toml:6: bad[1] = 1: must be a string");
  CHECK(of([](ConfigReader& q) { q.number_table("t", {.hi = 1}, ""); }) == "t.toml:7: t.x = 1.5: must be <= 1");
  CHECK(of([](ConfigReader& q) { q.number_table("t2", kAny, ""); }) == "t.toml:8: t2.x = \"a\": must be a number");
  CHECK(of([](ConfigReader& q) { q.number_table("one", kAny, ""); }) ==
        "t.toml:3: one = \"a\": must be a table of numbers");
  CHECK(of([](ConfigReader& q) { q.texts("t", ""); }) == "t.toml:7: t: must be a string or a list of strings");
}

TEST_CASE("Config: rules of the caller name place and value") {
  const std::string body =
      "x = 3\nestimator = 'msa'\nlong = [1000, 1001, 1002, 1003, 1004, 1005, 1006, 1007, 1008, 1009, 1010]\n";
  const auto of = [&](auto read) { return fault(body, read); };
  CHECK(of([](ConfigReader& r) { r.fail("x", "must be odd and even"); }) == "t.toml:3: x = 3: must be odd and even");
  CHECK(of([](ConfigReader& r) { r.require(false, "estimator.name", "is not allowed"); }) ==
        "t.toml:4: estimator = \"msa\": is not allowed");
  CHECK(of([](ConfigReader& r) { r.require(true, "x", "is not allowed"); }).empty());
  CHECK(of([](ConfigReader& r) { r.fail("y", "is needed with x"); }) == "t.toml: y: is needed with x");
  CHECK(of([](ConfigReader& r) {
          r.number("y", kAny, "", 2);
          r.fail("y", "must be below x");
        }) == "t.toml: y = 2 (the default): must be below x");
  CHECK(of([](ConfigReader& r) { r.fail("long", "is long"); }) ==
        "t.toml:5: long = [1000, 1001, 1002, 1003, 1004, 1005, 1006, 1007, 1008, 1009,...: is long");
}

TEST_CASE("Config: a string where a table is expected is the table's name") {
  for (const std::string body :
       {"estimator = 'msa'\n", "[estimator]\nname = 'msa'\n", "estimator = { name = 'msa' }\n"}) {
    CAPTURE(body);
    auto config = config_of(body);
    auto r = config.reader(0);
    CHECK(r.has("estimator.name"));
    CHECK(r.text("estimator.name", "") == "msa");
    CHECK(r.text("estimator.solver", "", "newton") == "newton");
    CHECK_NOTHROW(r.finish());
    auto other = config_of(body);
    auto q = other.reader(0);
    CHECK(q.text("estimator", "") == "msa");
    CHECK(q.texts("estimator", "") == std::vector<std::string>{"msa"});
    CHECK_NOTHROW(q.finish());
  }
  // Getters and the caller's rules name the same key.
  const std::string written_out = "[estimator]\nname = 'msa'\n", key = "t.toml:4: estimator.name = \"msa\": ";
  CHECK(fault(written_out, [](ConfigReader& r) { r.choice("estimator", {"x"}, ""); }) == key + "must be \"x\"");
  CHECK(fault(written_out, [](ConfigReader& r) { r.fail("estimator", "is odd"); }) == key + "is odd");
  CHECK(fault(written_out, [](ConfigReader& r) { r.fail("estimator.name", "is odd"); }) == key + "is odd");
  CHECK(fault("[estimator]\nk = 1\n", [](ConfigReader& r) { r.fail("estimator", "is odd"); }) ==
        "t.toml:3: estimator: is odd");

  const auto read = [](ConfigReader& r) { r.choice("estimator.name", {"msa", "wls"}, ""); };
  CHECK(fault("estimator = 'mas'\n", read) ==
        "t.toml:3: estimator = \"mas\": must be one of \"msa\", \"wls\"; did you mean \"msa\"?");
  CHECK(fault("[estimator]\nname = 'mas'\n", read) ==
        "t.toml:4: estimator.name = \"mas\": must be one of \"msa\", \"wls\"; did you mean \"msa\"?");
  CHECK(fault("estimator = 3\n", read) == "t.toml:3: estimator = 3: must be a table: write [estimator]");
  CHECK(fault("field = 'x'\n", [](ConfigReader& r) { r.number("field.total_nT", kAny, ""); }) ==
        "t.toml:3: field.total_nT: missing (field is only a name)");
  CHECK(fault("field = 'x'\n", [](ConfigReader& r) {
          r.number("field.total_nT", kAny, "", 1);
          r.finish();
        }) == "t.toml:3: field = \"x\": must be a table: write [field]");
}

// ----------------------------------------------------------------------------------------------- unknown and missing

namespace {

/// An experiment with a handful of keys, as in the examples of the manual.
void read_all(ConfigReader& r) {
  r.integer("trials", 1, INT64_MAX, "", 100);
  r.number("field.total_nT", Range::positive(), "", 50000);
  r.number("field.dip_deg", Range::closed(-90, 90), "", 60);
  r.number("noise.scale", Range::positive(), "", 1);
  r.choice("noise.reference.per", {"none", "run"}, "", "none");
  r.text("estimator.name", "", "msa");
  for (auto& p : r.tables("published", "")) {
    p.number("value", kAny, "");
    p.number_table("tolerance", kAny, "");
  }
  r.finish();
}

std::string unknown(const std::string& body) { return fault(body, read_all); }

}  // namespace

TEST_CASE("Config: unknown keys are errors at any depth, with the nearest known key") {
  CHECK(unknown("trials = 5\nestimator = 'x'\n[field]\ntotal_nT = 1\n[noise.reference]\nper = 'run'\n").empty());
  CHECK(unknown("foo = 1\n") == "t.toml:3: foo: unknown key");
  CHECK(unknown("trails = 1\n") == "t.toml:3: trails: unknown key: did you mean trials?");
  CHECK(unknown("[field]\n\ndip_dge = 1\n") == "t.toml:5: field.dip_dge: unknown key: did you mean field.dip_deg?");
  CHECK(unknown("field.dip_dge = 1\n") == "t.toml:3: field.dip_dge: unknown key: did you mean field.dip_deg?");
  CHECK(unknown("field = { dip_dge = 1 }\n") == "t.toml:3: field.dip_dge: unknown key: did you mean field.dip_deg?");
  CHECK(unknown("[feild]\ndip_deg = 1\n") == "t.toml:3: feild: unknown key: did you mean field?");
  CHECK(unknown("[field.x]\n") == "t.toml:3: field.x: unknown key");
  CHECK(unknown("[other]\nfield = 1\n") == "t.toml:3: other: unknown key");
  CHECK(unknown("[noise]\nreference = { prr = 'run' }\n") ==
        "t.toml:4: noise.reference.prr: unknown key: did you mean noise.reference.per?");
  CHECK(unknown("dip_deg = 1\n") == "t.toml:3: dip_deg: unknown key: did you mean field.dip_deg?");
  CHECK(unknown("[field]\ntrials = 5\n") == "t.toml:4: field.trials: unknown key: did you mean trials?");
  CHECK(unknown("'field.dip_deg' = 5\n") ==
        "t.toml:3: \"field.dip_deg\": unknown key: write field.dip_deg without quotes");
  CHECK(unknown("'a b' = 5\n") == "t.toml:3: \"a b\": unknown key");
  CHECK(unknown("estimator.nam = 'msa'\n") == "t.toml:3: estimator.nam: unknown key: did you mean estimator.name?");
  CHECK(unknown("[[published]]\nvalue = 1\ntolerance = {}\n[[published]]\nvalue = 2\ntolerance = {}\nvalu = 3\n") ==
        "t.toml:9: published[1].valu: unknown key: did you mean published[1].value?");
  CHECK(unknown(
            "published = [ { value = 1, tolerance = { any = 1 } }, { value = 2, tolerance = {}, x = { y = 1 } } ]\n") ==
        "t.toml:3: published[1].x: unknown key");
  CHECK(unknown("z = 1\na = 2\n") == "t.toml:3: z: unknown key");  // the first of the file
}

TEST_CASE("Config: keys that any file may have are suggested though no reader asks for them") {
  const auto of = [](const std::string& body) { return fault(body, [](ConfigReader& r) { r.finish(); }); };
  CHECK(of("titel = 'x'\n") == "t.toml:3: titel: unknown key: did you mean title?");
  CHECK(of("sed = 1\n") == "t.toml:3: sed: unknown key: did you mean seed?");
  CHECK(of("experimant = 'x'\n") == "t.toml:3: experimant: unknown key: did you mean experiment?");
  CHECK(of("trails = 1\n") == "t.toml:3: trails: unknown key: did you mean trials?");
  CHECK(of("[swep]\nx = [1]\n") == "t.toml:3: swep: unknown key: did you mean sweep?");
  CHECK(of("total = 1\n") == "t.toml:3: total: unknown key");
}

TEST_CASE("Config: units are part of the key") {
  CHECK(unknown("field.total = 1\n") == "t.toml:3: field.total: the unit is missing: write field.total_nT");
  CHECK(unknown("[field]\ntotal_uT = 1\n") == "t.toml:4: field.total_uT: unknown unit: write field.total_nT");
  CHECK(unknown("field = { total_nt = 1 }\n") == "t.toml:3: field.total_nt: unknown unit: write field.total_nT");
  CHECK(unknown("field.dip_rad = 1\n") == "t.toml:3: field.dip_rad: unknown unit: write field.dip_deg");
  CHECK(unknown("field.dip_foo = 1\n") == "t.toml:3: field.dip_foo: unknown unit: write field.dip_deg");
  CHECK(unknown("noise.scale_nT = 1\n") == "t.toml:3: noise.scale_nT: this key has no unit: write noise.scale");
  CHECK(fault("md = 1\n", [](ConfigReader& r) {
          r.has("md_m");
          r.has("md_ft");
          r.finish();
        }) == "t.toml:3: md: the unit is missing: write md_ft or md_m");
}

TEST_CASE("Config: keys given by --set or the sweep must be known too") {
  const Overridden file("[field]\ndip_dge = 3\n");
  CHECK(message_of([&] {
          auto config = file.load({"field.total=5"});
          auto r = config.reader(0);
          read_all(r);
        }) == "--set field.total=5: field.total: the unit is missing: write field.total_nT");
  CHECK(unknown("[sweep]\n\"noise.scal\" = [1, 2]\n") ==
        "t.toml:4: noise.scal: unknown key: did you mean noise.scale?");
  CHECK(unknown("[[sweep.case]]\nname = 'a'\n\"field.dip\" = 3\n") ==
        "t.toml:5: field.dip: the unit is missing: write field.dip_deg");
  CHECK(unknown("[[sweep.case]]\nname = 'a'\nnoise.reference.pe = 'run'\n") ==
        "t.toml:5: noise.reference.pe: unknown key: did you mean noise.reference.per?");
}

TEST_CASE("Config: a missing key mentions what may have been meant") {
  const auto total = [](ConfigReader& r) { r.number("field.total_nT", kAny, ""); };
  CHECK(fault("", total) == "t.toml: field.total_nT: missing");
  CHECK(fault("[field]\ndip_deg = 3\n", total) == "t.toml: field.total_nT: missing");
  CHECK(fault("[field]\ntotal = 3\n", total) ==
        "t.toml:4: field.total_nT: missing (found field.total: the unit is missing)");
  CHECK(fault("[field]\ntotal_uT = 3\n", total) ==
        "t.toml:4: field.total_nT: missing (found field.total_uT: unknown unit)");
  CHECK(fault("[field]\ntotla_nT = 3\n", total) == "t.toml:4: field.total_nT: missing (found field.totla_nT)");
  CHECK(fault("[feild]\ntotal_nT = 3\n", total) == "t.toml:3: field.total_nT: missing (found feild)");
  CHECK(fault("[field]\ntotal_uT = 3\n", [&](ConfigReader& r) {  // a key of its own is no typing error
          r.has("field.total_uT");
          total(r);
        }) == "t.toml: field.total_nT: missing");
  CHECK(fault("[[published]]\nvalu = 3\n", [](ConfigReader& r) {
          r.tables("published", "").at(0).number("value", kAny, "");
        }) == "t.toml:4: published[0].value: missing (found published[0].valu)");
}

TEST_CASE("Config: has() makes a key known, but not the keys inside it") {
  CHECK(fault("x = 1\n", [](ConfigReader& r) {
          r.has("x");
          r.finish();
        }).empty());
  CHECK(fault("[t]\ny = 1\n", [](ConfigReader& r) {
          r.has("t");
          r.finish();
        }) == "t.toml:4: t.y: unknown key");
  CHECK(fault("[t]\n", [](ConfigReader& r) {
          r.has("t");
          r.finish();
        }).empty());
}

// ------------------------------------------------------------------------------------------------------------ sweeps

TEST_CASE("Sweep: the product of the lists, the last key fastest") {
  auto config = config_of(
      "x = 7\n[noise]\nscale = 9\n[sweep]\nx = [1, 2]\n\"noise.scale\" = [0.1, 1.0]\nestimator = ['msa', 'wls']\n");
  REQUIRE(config.point_count() == 8);
  CHECK(sweep_text(config, 0) == "estimator=msa noise.scale=0.1 x=1");
  CHECK(sweep_text(config, 1) == "estimator=msa noise.scale=0.1 x=2");
  CHECK(sweep_text(config, 2) == "estimator=msa noise.scale=1 x=1");
  CHECK(sweep_text(config, 7) == "estimator=wls noise.scale=1 x=2");
  auto r = config.reader(6);
  CHECK(r.text("estimator.name", "") == "wls");
  CHECK(r.number("noise.scale", kAny, "") == 1);
  CHECK(r.integer("x", 0, 9, "") == 1);  // integers of a sweep stay integers
  CHECK_NOTHROW(r.finish());
  CHECK(message_of([&] { config.reader(8); }) == "t.toml: point 8: must be in [0, 7]");
  CHECK(message_of([&] { config.sweep_values(8); }) == "t.toml: point 8: must be in [0, 7]");
}

TEST_CASE("Sweep: values may be steps, lists and truth values; keys may be written with dots") {
  auto config = config_of(
      "[sweep]\nnoise.scale = { from = 0.1, to = 0.3, step = 0.1 }\ngain = [[1, 1, 1], [1.1, 0.95, 1.25]]\nflag = "
      "[true, "
      "false]\nn = { from = 1, to = 3, step = 2 }\n");
  REQUIRE(config.point_count() == 2 * 2 * 2 * 3);
  CHECK(sweep_text(config, 0) == "flag=true gain=[1, 1, 1] n=1 noise.scale=0.1");
  CHECK(sweep_text(config, 23) == "flag=false gain=[1.1, 0.95, 1.25] n=3 noise.scale=0.3");
  auto r = config.reader(23);
  CHECK(r.numbers("gain", kAny, "", 3) == std::vector<double>{1.1, 0.95, 1.25});
  CHECK(r.number("noise.scale", kAny, "") == 0.3);
  CHECK(r.integer("n", 1, 3, "") == 3);
  CHECK_FALSE(r.boolean("flag", "", true));
  CHECK_NOTHROW(r.finish());
}

TEST_CASE("Sweep: cases vary slowest and set any keys") {
  const std::string body = R"([survey]
file = "traj0.csv"
toolface_zero = "x"
[sweep]
"noise.scale" = [1, 2]
[[sweep.case]]
name = "one"
"survey.file" = "traj1.csv"
[[sweep.case]]
name = "two"
survey.file = "traj2.csv"
[sweep.case.field]
total_nT = 51000.0
reference = { per = "run" }
[[sweep.case]]
name = "three"
estimator = "wls"
incidence = { from = 0, to = 2, step = 1 }
)";
  auto config = config_of(body);
  REQUIRE(config.point_count() == 6);
  CHECK(sweep_text(config, 0) == "case=one noise.scale=1");
  CHECK(sweep_text(config, 1) == "case=one noise.scale=2");
  CHECK(sweep_text(config, 5) == "case=three noise.scale=2");
  auto one = config.reader(1), two = config.reader(2), three = config.reader(4);
  CHECK(one.text("survey.file", "") == "traj1.csv");
  CHECK(one.text("survey.toolface_zero", "") == "x");
  CHECK_FALSE(one.has("field.total_nT"));
  CHECK(two.text("survey.file", "") == "traj2.csv");
  CHECK(two.number("field.total_nT", kAny, "") == 51000);
  CHECK(two.text("field.reference.per", "") == "run");
  CHECK(three.text("survey.file", "") == "traj0.csv");
  CHECK(three.text("estimator.name", "") == "wls");
  CHECK(three.grid("incidence", kAny, "") == std::vector<double>{0, 1, 2});

  // A table in braces replaces the whole table; one with dots sets single keys.
  auto braces =
      config_of("[t]\na = 1\nb = 2\n[[sweep.case]]\nname = 'x'\nt = { a = 5 }\n[[sweep.case]]\nname = 'y'\nt.a = 5\n");
  CHECK_FALSE(braces.reader(0).has("t.b"));
  CHECK(braces.reader(1).has("t.b"));
  auto in_line = config_of("[t]\nb = 2\n[sweep]\ncase = [{ name = 'x', t.a = 5 }, { name = 'y', 't.a' = 6 }]\n");
  CHECK(in_line.reader(0).number("t.a", kAny, "") == 5);
  CHECK(in_line.reader(1).number("t.a", kAny, "") == 6);
  CHECK(in_line.reader(1).has("t.b"));
}

TEST_CASE("Sweep: values of a sweep or a case have their own line in messages") {
  auto config = config_of("[noise]\nscale = 1\n[sweep]\n\"noise.scale\" = [1, -1]\n");
  auto r = config.reader(1);
  CHECK(message_of([&] { r.number("noise.scale", Range::positive(), ""); }) ==
        "t.toml:6: noise.scale = -1: must be > 0");
  auto cases = config_of("dip_deg = 3\n[[sweep.case]]\nname = 'a'\n[[sweep.case]]\nname = 'b'\ndip_deg = 95\n");
  CHECK_NOTHROW(cases.reader(0).number("dip_deg", Range::closed(-90, 90), ""));
  CHECK(message_of([&] { cases.reader(1).number("dip_deg", Range::closed(-90, 90), ""); }) ==
        "t.toml:8: dip_deg = 95: must be in [-90, 90]");
  auto steps = config_of("[sweep]\nx = { from = 0, to = 4, step = 2 }\n");
  CHECK(message_of([&] { steps.reader(2).number("x", {.hi = 3}, ""); }) == "t.toml:4: x = 4: must be <= 3");
}

TEST_CASE("Sweep: what cannot be a sweep") {
  CHECK(fault("sweep = 3\n") == "t.toml:3: sweep = 3: must be a table: write [sweep]");
  CHECK(fault("[sweep]\n") == "t.toml:3: sweep: is empty");
  CHECK(fault("[sweep]\n[sweep.noise]\n") == "t.toml:4: sweep.noise: is empty");
  CHECK(fault("[sweep]\nx = []\n") == "t.toml:4: sweep.x = []: must not be empty");
  CHECK(fault("[sweep]\nx = 3\n") == "t.toml:4: sweep.x = 3: must be a list or { from, to, step }");
  CHECK(fault("[sweep]\n\"a.b\" = [1,\n 2,\n 1.0]\n") == "t.toml:6: sweep.a.b = 1: is in the list twice");
  CHECK(fault("[sweep]\nx = [0.0, -0.0]\n") == "t.toml:4: sweep.x = -0: is in the list twice");
  CHECK(fault("[sweep]\nx = ['a', 'a']\n") == "t.toml:4: sweep.x = \"a\": is in the list twice");
  CHECK(fault("[sweep]\nx = [[1, 2], [1, 2]]\n") == "t.toml:4: sweep.x = [1, 2]: is in the list twice");
  CHECK(fault("[sweep]\nx = [1, 'a']\n") == "t.toml:4: sweep.x = \"a\": the values of a list must be of one kind");
  CHECK(fault("[sweep]\nx = ['a', [1]]\n") == "t.toml:4: sweep.x = [1]: the values of a list must be of one kind");
  CHECK(fault("[sweep]\nx = [true, false,\n 'a']\n") ==
        "t.toml:5: sweep.x = \"a\": the values of a list must be of one kind");
  CHECK(fault("[sweep]\nx = [1, 2.5]\n").empty());
  CHECK(fault("[sweep]\nx = [{ a = 1 }]\n") ==
        "t.toml:4: sweep.x: every value must be a number, a string or a list: use [[sweep.case]] for tables");
  CHECK(fault("[sweep]\nx = { from = 0, to = 1, step = 0 }\n") == "t.toml:4: sweep.x.step = 0: must not be 0");
  CHECK(fault("[sweep]\nx = { from = 0, to = 1 }\n") ==
        "t.toml:4: sweep.x.step: missing (or count; only latin_hypercube and sobol draw from an interval)");
  CHECK(fault("[sweep]\nx = { from = 0, to = 1, step = 1, by = 1 }\n") == "t.toml:4: sweep.x.by: unknown key");
  CHECK(fault("[sweep]\nseed = [1, 2]\n") == "t.toml:4: sweep.seed: cannot be swept");
  CHECK(fault("[sweep]\nexperiment = ['a']\n") == "t.toml:4: sweep.experiment: cannot be swept");
  CHECK(fault("[sweep]\ntrials = [10, 20]\n") ==
        "t.toml:4: sweep.trials: cannot be swept: a result has one number of trials");
  const std::string one_family = "sets verdict.family, which cannot be swept: a result has one family of verdicts";
  CHECK(fault("[sweep]\nverdict.family = ['holm', 'none']\n") == "t.toml:4: sweep.\"verdict.family\": " + one_family);
  CHECK(fault("[sweep]\nverdict = [{ family = 'none', margin = 0.1 }, { margin = 0.2 }]\n") ==
        "t.toml:4: sweep.verdict: " + one_family);
  CHECK(fault("[[sweep.case]]\nname = 'a'\nverdict = { family = 'none' }\n") ==
        "t.toml:5: sweep.case[0].verdict: " + one_family);
  CHECK(fault("[sweep]\n\"a..b\" = [1]\n") == "t.toml:4: sweep.\"a..b\": \"a..b\" is not a key");
  CHECK(fault("[sweep]\n\"a.b\" = [1]\na.b = [2]\n") == "t.toml:4: sweep.a.b = [1]: is given twice");
  CHECK(fault("[sweep]\nestimator = ['a']\n\"estimator.name\" = ['b']\n") ==
        "t.toml:5: sweep.estimator.name = [\"b\"]: is the same as sweep.estimator");
  CHECK(fault("[sweep]\nx = { from = 1, to = 2e6, step = 1 }\ny = { from = 1, to = 2e6, step = 1 }\n") ==
        "t.toml:5: sweep: has more than 2^40 points");
  CHECK(message_of([] { config_of("x = 3\n[sweep]\n\"x.y\" = [1]\n").reader(0); }) ==
        "t.toml:5: x.y = 1: x is not a table");
}

TEST_CASE("Sweep: what cannot be a case") {
  CHECK(fault("[sweep]\ncase = [1, 2]\n") ==
        "t.toml:4: sweep.case = [1, 2]: must be an array of tables: write [[sweep.case]]");
  CHECK(fault("[sweep]\ncase = []\n") == "t.toml:4: sweep.case = []: must be an array of tables: write [[sweep.case]]");
  CHECK(fault("[sweep.case]\nname = 'a'\n") ==
        "t.toml:3: sweep.case: must be an array of tables: write [[sweep.case]]");
  CHECK(fault("[[sweep.case]]\nx = 3\n") == "t.toml:3: sweep.case[0].name: missing");
  CHECK(fault("[[sweep.case]]\nname = 3\n") == "t.toml:4: sweep.case[0].name = 3: must be a string");
  CHECK(fault("[[sweep.case]]\nname = ''\n") == "t.toml:4: sweep.case[0].name = \"\": must not be empty");
  CHECK(fault("[[sweep.case]]\nname = 'a'\n[[sweep.case]]\nname = 'a'\n") ==
        "t.toml:6: sweep.case[1].name = \"a\": two cases have this name");
  CHECK(fault("[[sweep.case]]\nname = 'a'\nseed = 3\n") == "t.toml:5: sweep.case[0].seed: cannot be swept");
  CHECK(fault("[[sweep.case]]\nname = 'a'\ntrials = 3\n") ==
        "t.toml:5: sweep.case[0].trials: cannot be swept: a result has one number of trials");
  CHECK(fault("[[sweep.case]]\nname = 'a'\n\"x.y\" = 3\nx.y = 4\n") == "t.toml:5: sweep.case[0].x.y = 3: is set twice");
  CHECK(fault("[[sweep.case]]\nname = 'a'\nx = 3\n[sweep]\nx = [1]\n") ==
        "t.toml:5: x = 3: is also in [sweep]: a key can vary with the case or by itself");
}

TEST_CASE("Sweep: a case and a list, or a case twice, cannot set the same key in two ways") {
  const auto of = [](const std::string& in_case, const std::string& lists) {
    return fault("[[sweep.case]]\nname = 'a'\n" + in_case + "\n[sweep]\n" + lists + "\n");
  };
  const std::string rule = " is also in [sweep]: a key can vary with the case or by itself";
  CHECK(of("estimator = 'msa'", "'estimator.name' = ['a', 'b']") ==
        "t.toml:5: estimator = \"msa\": estimator.name" + rule);
  CHECK(of("'estimator.name' = 'msa'", "estimator = ['a', 'b']") ==
        "t.toml:5: estimator.name = \"msa\": estimator" + rule);
  CHECK(of("t = { k = 1 }", "'t.k' = [1, 2]") == "t.toml:5: t: t.k" + rule);
  CHECK(of("t = { u = { name = 'n' } }", "'t.u' = ['a', 'b']") == "t.toml:5: t: t.u" + rule);
  CHECK(of("t = { u = 'n' }", "'t.u.name' = ['a', 'b']") == "t.toml:5: t: t.u.name" + rule);
  CHECK(of("t.k = 1", "t = [[1], [2]]") == "t.toml:5: t.k = 1: t" + rule);
  // Different keys of one table.
  CHECK(of("t = { k = 1 }", "'t.l' = [1, 2]").empty());
  CHECK(of("'estimator.solver' = 'lm'", "estimator = ['a', 'b']").empty());
  CHECK(of("estimator = 'msa'", "'estimator.solver' = ['a', 'b']").empty());

  CHECK(of("estimator = 'msa'\n'estimator.name' = 'wls'", "x = [1]") ==
        "t.toml:6: sweep.case[0].estimator.name = \"wls\": is set twice: estimator sets it too");
  CHECK(of("t = { k = 1 }\n't.k' = 2", "x = [1]") == "t.toml:6: sweep.case[0].t.k = 2: is set twice: t sets it too");
  CHECK(of("estimator = 'msa'\n'estimator.solver' = 'lm'\nt = { k = 1 }\n't.l' = 2", "x = [1]").empty());
}

// --------------------------------------------------------------------------------------------------------- overrides

TEST_CASE("Overrides: values in TOML or a bare word, later ones win") {
  const Overridden file("trials = 5\n[field]\ntotal_nT = 50000.0\n");
  auto config = file.load({"trials=7", "trials = 8", "field.dip_deg=-1.5", "survey.file=traj 1.csv", "a.b.c=[1, 2]",
                           "t={ x = 1 }", "flag=true", "quoted=\"1\"", "\"noise.scale\"=2", "equals=a=b",
                           "date=2020-01-01", "seed=77"});
  CHECK(config.seed() == 77);
  auto r = config.reader(0);
  CHECK(r.integer("trials", 0, 9, "") == 8);
  CHECK(r.number("field.dip_deg", kAny, "") == -1.5);
  CHECK(r.number("field.total_nT", kAny, "") == 50000);
  CHECK(r.text("survey.file", "") == "traj 1.csv");
  CHECK(r.numbers("a.b.c", kAny, "") == std::vector<double>{1, 2});
  CHECK(r.number("t.x", kAny, "") == 1);
  CHECK(r.boolean("flag", "", false));
  CHECK(r.text("quoted", "") == "1");
  CHECK(r.number("noise.scale", kAny, "") == 2);
  CHECK(r.text("equals", "") == "a=b");
  CHECK(r.text("date", "") == "2020-01-01");
  CHECK_NOTHROW(r.finish());
}

TEST_CASE("Overrides: values are checked like those of the file, and the argument is the place") {
  const Overridden file("[field]\ndip_deg = 3\n");
  const auto of = [&](const std::string& argument, auto read) {
    return message_of([&] {
      auto config = file.load({argument});
      auto r = config.reader(0);
      read(r);
    });
  };
  CHECK(of("field.dip_deg=95", [](ConfigReader& r) { r.number("field.dip_deg", Range::closed(-90, 90), ""); }) ==
        "--set field.dip_deg=95: field.dip_deg = 95: must be in [-90, 90]");
  CHECK(of("field.dip_deg=12,5", [](ConfigReader& r) { r.number("field.dip_deg", kAny, ""); }) ==
        "--set field.dip_deg=12,5: field.dip_deg = \"12,5\": must be a number");
  CHECK(of("trials=1.5e0", [](ConfigReader& r) { r.integer("trials", 1, INT64_MAX, ""); }) ==
        "--set trials=1.5e0: trials = 1.5: must be an integer");
  CHECK(of("trials=10k", [](ConfigReader& r) { r.integer("trials", 1, INT64_MAX, ""); }) ==
        "--set trials=10k: trials = \"10k\": must be an integer: write 10000 without quotes");
  CHECK(of("seed=-4", [](ConfigReader&) {}) == "--set seed=-4: seed = -4: must be in [0, 9223372036854775807]");
}

TEST_CASE("Overrides: arguments that are not KEY=VALUE") {
  const Overridden file("[field]\ndip_deg = 3\n");
  CHECK(file.fault({"trials"}) == "--set trials: must be KEY=VALUE");
  CHECK(file.fault({"=3"}) == "--set =3: the key is missing: must be KEY=VALUE");
  CHECK(file.fault({""}) == "--set : must be KEY=VALUE");
  CHECK(file.fault({"trials="}) == "--set trials=: trials: the value is missing");
  CHECK(file.fault({"a..b=3"}) == "--set a..b=3: \"a..b\" is not a key");
  CHECK(file.fault({"a b=3"}) == "--set a b=3: \"a b\" is not a key");
  CHECK(file.fault({"published[0].value=3"}) == "--set published[0].value=3: \"published[0].value\" is not a key");
  CHECK(file.fault({"x=[1, 2"}).substr(0, 18) == "--set x=[1, 2: x: ");
  CHECK(file.fault({"x='a"}).substr(0, 15) == "--set x='a: x: ");
  CHECK(file.fault({"x=1\ny=2"}) == "--set x=1\ny=2: x: the value must be one line of text");
  CHECK(file.fault({"field.dip_deg.x=3"}) ==
        "--set field.dip_deg.x=3: field.dip_deg.x = 3: field.dip_deg is not a table");
}

TEST_CASE("Overrides: a string names a table, and a named table can get keys") {
  const Overridden plain("estimator = 'msa'\n"), table("[estimator]\nname = 'msa'\nsolver = 'lm'\n");
  auto a = plain.load({"estimator.solver=newton"});
  CHECK(a.reader(0).text("estimator.name", "") == "msa");
  CHECK(a.reader(0).text("estimator.solver", "") == "newton");
  auto b = table.load({"estimator=wls"});
  CHECK(b.reader(0).text("estimator.name", "") == "wls");
  CHECK(b.reader(0).text("estimator.solver", "") == "lm");
  auto c = table.load({"estimator={ name = 'wls' }"});
  CHECK(c.reader(0).text("estimator.name", "") == "wls");
  CHECK_FALSE(c.reader(0).has("estimator.solver"));
}

TEST_CASE("Overrides: a key that the user fixes is not swept any more") {
  const Overridden file(
      "[sweep]\n\"noise.scale\" = [1, 2]\nestimator = ['msa', 'wls']\n\"estimator.solver\" = ['lm', 'newton']\n"
      "[[sweep.case]]\nname = 'a'\nsurvey.file = 'a.csv'\nx = 1\nt = { k = 1, l = 2 }\n"
      "[[sweep.case]]\nname = 'b'\nsurvey.file = 'b.csv'\n");
  CHECK(file.load({}).point_count() == 16);

  auto scale = file.load({"noise.scale=3"});
  REQUIRE(scale.point_count() == 8);
  CHECK(sweep_text(scale, 0) == "case=a estimator=msa estimator.solver=lm");
  CHECK(scale.reader(7).number("noise.scale", kAny, "") == 3);

  for (const std::string argument : {"estimator=wls", "estimator.name=wls"}) {
    auto name = file.load({argument});
    REQUIRE(name.point_count() == 8);
    CHECK(sweep_text(name, 1) == "case=a estimator.solver=lm noise.scale=2");
    CHECK(name.reader(1).text("estimator.name", "") == "wls");
    CHECK(name.reader(1).text("estimator.solver", "") == "lm");
  }
  CHECK(file.load({"estimator={ name = 'wls' }"}).point_count() == 4);

  auto survey = file.load({"survey.file=c.csv"});
  CHECK(survey.point_count() == 16);
  CHECK(survey.reader(0).text("survey.file", "") == "c.csv");
  CHECK(survey.reader(15).text("survey.file", "") == "c.csv");
  CHECK(survey.reader(0).has("x"));

  auto inside = file.load({"t.k=5"});  // also where a case sets the whole table
  CHECK(inside.reader(0).number("t.k", kAny, "") == 5);
  CHECK(inside.reader(0).number("t.l", kAny, "") == 2);
  CHECK(inside.reader(15).number("t.k", kAny, "") == 5);

  CHECK(file.fault({"noise.scale.x=5"}) == "--set noise.scale.x=5: noise.scale.x = 5: noise.scale is swept as a whole");
  CHECK(file.fault({"x.y=5"}) == "--set x.y=5: x.y = 5: sweep.case sets x as a whole");
  auto none = Overridden("[sweep]\nx = [1, 2]\n").load({"x=1"});
  CHECK(none.point_count() == 1);
  CHECK(none.sweep_values(0).empty());
  CHECK(none.resolved_text().find("sweep") == std::string::npos);
}

TEST_CASE("Overrides: a list for a swept key") {
  const Overridden file("[sweep]\n\"noise.scale\" = [1, 2]\n");
  auto config = file.load({"sweep.noise.scale=[5, 6, 7]", "sweep.x=['a', 'b']"});
  REQUIRE(config.point_count() == 6);
  CHECK(sweep_text(config, 5) == "noise.scale=7 x=b");
  CHECK(file.fault({"sweep.noise.scale=[]"}) ==
        "--set sweep.noise.scale=[]: sweep.noise.scale = []: must not be empty");
  CHECK(file.fault({"sweep.trials=[10, 20]"}) ==
        "--set sweep.trials=[10, 20]: sweep.trials: cannot be swept: a result has one number of trials");
  CHECK(file.fault({"sweep=3"}) == "--set sweep=3: sweep: cannot be set here: set sweep.KEY=[...] for one key");
  CHECK(file.fault({"sweep.case=3"}) ==
        "--set sweep.case=3: sweep.case: cannot be set here: set sweep.KEY=[...] for one key");
}

// ------------------------------------------------------------------------------------------------ published, at, csv

TEST_CASE("tables(): one reader per element") {
  auto config = config_of("[[published]]\nvalue = 1\n[[published]]\nvalue = -2\nnote = 'n'\nin = { deg = 3 }\n");
  auto r = config.reader(0);
  auto p = r.tables("published", "");
  REQUIRE(p.size() == 2);
  CHECK(p[0].number("value", kAny, "") == 1);
  CHECK(p[0].text("note", "", "none") == "none");
  CHECK(p[1].text("note", "") == "n");
  CHECK(p[1].number("in.deg", kAny, "") == 3);
  CHECK(message_of([&] { p[1].number("value", Range::positive(), ""); }) ==
        "t.toml:6: published[1].value = -2: must be > 0");
  CHECK(message_of([&] { p[0].number("sd", kAny, ""); }) == "t.toml:3: published[0].sd: missing");
  CHECK(message_of([&] { p[1].text("source", ""); }) == "t.toml:5: published[1].source: missing");
  CHECK(message_of([&] { p[1].fail("source", "is needed"); }) == "t.toml:5: published[1].source: is needed");
  CHECK(message_of([&] { p[1].fail("value", "is odd"); }) == "t.toml:6: published[1].value = -2: is odd");
  CHECK_NOTHROW(p[0].finish());
  CHECK_NOTHROW(r.finish());
  CHECK(r.tables("absent", "").empty());
  CHECK(fault("p = 3\n", [](ConfigReader& q) { q.tables("p", ""); }) ==
        "t.toml:3: p = 3: must be an array of tables: write [[p]]");
  CHECK(fault("[p]\nx = 1\n", [](ConfigReader& q) { q.tables("p", ""); }) ==
        "t.toml:3: p: must be an array of tables: write [[p]]");
  CHECK(fault("[[p]]\nx = 1\n", [](ConfigReader& q) { q.finish(); }) == "t.toml:3: p: unknown key");
  CHECK(fault("[[p]]\nx = 1\n", [](ConfigReader& q) { q.number("p.x", kAny, "", 3); }) ==
        "t.toml:3: p: must be a table: write [p]");
}

TEST_CASE("matches_point(): entries are compared with the point") {
  const std::string body = R"(estimator = "msa"
[noise]
scale = 2
[sweep]
"field.dip_deg" = [60, 70.0]
gain = [[1, 1], [1.5, 1]]
[[sweep.case]]
name = "one"
[[sweep.case]]
name = "two"
extra = 1
)";
  const auto matches = [&](const std::string& at, std::size_t point) {
    auto config = config_of(body + "[[published]]\nvalue = 1\nat = " + at + "\n");
    auto r = config.reader(point);
    r.text("estimator.name", "");
    r.text("method", "", "chi");
    auto p = r.tables("published", "");
    return p.at(0).matches_point("at");
  };
  // Points: case slowest, then field.dip_deg, then gain.
  CHECK(matches("{ 'field.dip_deg' = 60.0 }", 0));
  CHECK_FALSE(matches("{ 'field.dip_deg' = 60 }", 2));
  CHECK(matches("{ 'field.dip_deg' = 70 }", 2));
  CHECK(matches("{ field.dip_deg = 70 }", 2));
  CHECK(matches("{ 'noise.scale' = 2.0, case = 'one', estimator = 'msa', 'estimator.name' = 'msa' }", 3));
  CHECK_FALSE(matches("{ 'noise.scale' = 2.0, case = 'two' }", 3));
  CHECK(matches("{ case = 'two' }", 4));
  CHECK(matches("{ gain = [1.5, 1.0] }", 1));
  CHECK_FALSE(matches("{ gain = [1.5, 1.0] }", 0));
  CHECK_FALSE(matches("{ estimator = 'wls' }", 0));
  CHECK_FALSE(matches("{ 'noise.scale' = '2' }", 0));
  CHECK(matches("{ method = 'chi' }", 0));  // a default that was read
  CHECK(matches("{ extra = 1 }", 4));
  CHECK_FALSE(matches("{ extra = 1 }", 0));  // only the other case has it
  CHECK(matches("{}", 0));
  const auto of = [&](const std::string& at) { return message_of([&] { matches(at, 0); }); };
  CHECK(of("{ 'noise.scal' = 1 }") == "t.toml:16: published[0].at: noise.scal: unknown key");
  CHECK(of("{ methd = 'a' }") == "t.toml:16: published[0].at: methd: unknown key: did you mean method?");
  CHECK(of("{ case = 'two', cas = 1 }") == "t.toml:16: published[0].at: cas: unknown key: did you mean case?");
  CHECK(of("{ case = 1 }") == "t.toml:16: published[0].at.case = 1: must be a string");
  CHECK(of("3") == "t.toml:16: published[0].at = 3: must be a table of keys and their values");

  auto plain = config_of("x = 1\n[[published]]\nv = 1\n[[published]]\nat = { case = 'a' }\n");
  auto r = plain.reader(0);
  auto p = r.tables("published", "");
  CHECK(p.at(0).matches_point("at"));  // no `at`: for every point
  CHECK(message_of([&] { p.at(1).matches_point("at"); }) == "t.toml:7: published[1].at: case: unknown key");
}

TEST_CASE("matches_point(): the default of a name is a value") {
  for (const std::string body : {"", "[estimator]\nsolver = 'lm'\n"}) {
    CAPTURE(body);
    const auto matches = [&](const std::string& at) {
      auto config = config_of(body + "[[published]]\nat = " + at + "\n");
      auto r = config.reader(0);
      r.text("estimator.name", "", "msa");
      return r.tables("published", "").at(0).matches_point("at");
    };
    CHECK(matches("{ estimator = 'msa' }"));
    CHECK(matches("{ 'estimator.name' = 'msa' }"));
    CHECK_FALSE(matches("{ estimator = 'wls' }"));
  }
}

TEST_CASE("matches_point(): elements for other points are not checked, unless they were read") {
  const std::string body = "[sweep]\nx = [1, 2]\n[[published]]\nat = { x = 2 }\nvalue = 3\nvalu = 4\n";
  const auto of = [&](std::size_t point, bool first) {
    return message_of([&] {
      auto config = config_of(body);
      auto r = config.reader(point);
      r.number("x", kAny, "");
      for (auto& p : r.tables("published", "")) {
        if (first) p.number("value", kAny, "");
        if (p.matches_point("at")) p.number("value", kAny, "");
      }
      r.finish();
    });
  };
  const std::string rule = "t.toml:8: published[0].valu: unknown key: did you mean published[0].value?";
  CHECK(of(0, false).empty());
  CHECK(of(1, false) == rule);
  CHECK(of(0, true) == rule);
}

TEST_CASE("csv(): files are found beside the config, read once and kept") {
  const Folder folder;
  folder.write("configs/traj.csv", "md_m,inclination_deg\n0,0\n30,1.5\n");
  folder.write("data/b.csv", "x\n1\n");
  folder.write("configs/bad.csv", "md_m\nabc\n");
  const std::string absolute = (folder.path / "data/b.csv").string();
  const auto file = folder.write("configs/t.toml",
                                 kHead + "b = '../data/b.csv'\nc = '" + absolute +
                                     "'\n[survey]\nfile = 'traj.csv'\nnone = 'traj9.csv'\nbad = "
                                     "'bad.csv'\nempty = ''\nnumber = 3\nfolder = '../data'\n[sweep]\nx = [1, 2]\n");
  auto config = Config::load(file, {});
  auto r = config.reader(0);
  const InputTable t = r.csv("survey.file", "");
  CHECK(t.path == "traj.csv");
  CHECK(t.names == std::vector<std::string>{"md_m", "inclination_deg"});
  CHECK(t.columns[1] == std::vector<double>{0, 1.5});
  CHECK(r.csv("b", "").path == "../data/b.csv");
  CHECK(r.csv("c", "").path == absolute);

  fs::remove(folder.path / "configs/traj.csv");  // the second point must not need it
  CHECK(config.reader(1).csv("survey.file", "").rows() == 2);
  const auto inputs = config.inputs();
  REQUIRE(inputs.size() == 3);
  CHECK(inputs[0].path == "../data/b.csv");
  CHECK(inputs[2].path == "traj.csv");
  CHECK(inputs[2].rows() == 2);

  const std::string place = file.string(), looked = (folder.path / "configs/traj9.csv").string();
  CHECK(message_of([&] { r.csv("survey.none", ""); }) ==
        place + ":7: survey.none = \"traj9.csv\": cannot be read: No such file or directory (looked for " + looked +
            ")");
  CHECK(message_of([&] { r.csv("survey.bad", ""); }) == "bad.csv:2: md_m = \"abc\": must be a number");
  CHECK(message_of([&] { r.csv("survey.empty", ""); }) == place + ":9: survey.empty = \"\": must name a file");
  CHECK(message_of([&] { r.csv("survey.number", ""); }) ==
        place + ":10: survey.number = 3: must be a string: the name of a file");
  CHECK(message_of([&] { r.csv("survey.folder", ""); }) ==
        place + ":11: survey.folder = \"../data\": cannot be read: it is a folder (looked for " +
            (folder.path / "configs/../data").string() + ")");
  CHECK(message_of([&] { r.csv("survey.absent", ""); }) == place + ": survey.absent: missing");
  CHECK(config.inputs().size() == 3);
}

TEST_CASE("csv(): a config beside the working folder is named as given") {
  const Folder folder;
  folder.write("configs/thesis.toml", kHead + "\n[survey]\nfile = 'traj9.csv'\n");
  const auto before = fs::current_path();
  fs::current_path(folder.path);
  auto config = Config::load("configs/thesis.toml", {});
  const auto message = message_of([&] { config.reader(0).csv("survey.file", ""); });
  fs::current_path(before);
  CHECK(message ==
        "configs/thesis.toml:5: survey.file = \"traj9.csv\": cannot be read: No such file or directory (looked for "
        "configs/traj9.csv)");
}

TEST_CASE("csv(): a stored config has its files with it") {
  auto config = config_of("a = 'traj.csv'\nb = 'other.csv'\n", {{"traj.csv", {"x"}, {{1, 2}}, {2, 3}}});
  CHECK(config.inputs().empty());
  CHECK(config.reader(0).csv("a", "").columns == std::vector<std::vector<double>>{{1, 2}});
  CHECK(config.inputs().size() == 1);
  CHECK(message_of([&] { config.reader(0).csv("b", ""); }) ==
        "t.toml:4: b = \"other.csv\": is not among the files stored with this config");
}

// ---------------------------------------------------------------------------------------------------- resolved, hash

TEST_CASE("format_number: shortest text that reads back") {
  CHECK(format_number(51000) == "51000");
  CHECK(format_number(0.1) == "0.1");
  CHECK(format_number(-0.0) == "-0");
  CHECK(format_number(0) == "0");
  CHECK(format_number(100000) == "100000");
  CHECK(format_number(1e22) == "1e+22");
  CHECK(format_number(1e-300) == "1e-300");
  CHECK(format_number(0.1 + 0.2) == "0.30000000000000004");
  CHECK(format_number(-12.5) == "-12.5");
  CHECK(format_number(0.00001) == "0.00001");
  for (const double x : {1.0 / 3, 2.2250738585072014e-308, 5e-324, 1.7976931348623157e308, 999999999999999.9, 1e15,
                         123456789012345680.0}) {
    CHECK(std::strtod(format_number(x).c_str(), nullptr) == x);
  }
}

TEST_CASE("Resolved config: sorted, with the defaults, exact") {
  auto config = config_of(R"(zeta = 51000.0
alpha = [0.1, 1e-300, 1e22, 3, -0.0, 100000.0]
"odd key" = "tab\t quote\" back\\ line\n é \u0001"
estimator = "msa"
[field]
total_nT = 51000
[empty]
[[published]]
value = 1.0
at = { "noise.scale" = 1.0 }
[sweep]
"noise.scale" = [1.0, 0.1]
x = { from = 0, to = 1, step = 0.5 }
[[sweep.case]]
name = "a"
"survey.file" = "traj1.csv"
[[sweep.case]]
name = "b"
[sweep.case.survey]
file = "traj2.csv"
grid = { from = 0, to = 1.0, step = 1 }
)");
  for (std::size_t i = 0; i < config.point_count(); ++i) {
    auto r = config.reader(i);
    r.text("estimator.name", "");
    r.text("estimator.solver", "", "lm");
    r.number("field.dip_deg", kAny, "", 60);
    r.integer("trials", 1, 1000, "", 10);
    r.number("survey.step_m", kAny, "", static_cast<double>(i));  // differs between points: not resolved
    if (i == 2) r.number("field.rare", kAny, "", 1);              // only one point asks: not resolved
    r.text("note", "", "");                                       // absent
    r.number("limit", Range::positive(), "", -1);                 // absent
    for (auto& p : r.tables("published", "")) p.number("sd", kAny, "", 0.5);
  }
  CHECK(config.resolved_text() == R"(alpha = [0.1, 1e-300, 1e+22, 3, -0.0, 100000.0]
experiment = "test"
"odd key" = "tab\t quote\" back\\ line\n é \u0001"
seed = 1
trials = 10
zeta = 51000.0

[empty]

[estimator]
name = "msa"
solver = "lm"

[field]
dip_deg = 60.0
total_nT = 51000

[[published]]
at = { "noise.scale" = 1.0 }
sd = 0.5
value = 1.0

[sweep]
"noise.scale" = [1.0, 0.1]
x = { from = 0, step = 0.5, to = 1 }

[[sweep.case]]
name = "a"
"survey.file" = "traj1.csv"

[[sweep.case]]
name = "b"
"survey.file" = "traj2.csv"
"survey.grid" = { from = 0, step = 1, to = 1.0 }
)");
}

TEST_CASE("Resolved config: defaults that are swept, or that has() would see, are left out") {
  auto config = config_of("[[sweep.case]]\nname = 'a'\nx = 1\n[[sweep.case]]\nname = 'b'\n");
  for (std::size_t i = 0; i < 2; ++i) {
    auto r = config.reader(i);
    r.number("x", kAny, "", 1);
    if (!r.has("reference")) r.number("reference.total_nT", kAny, "", 5);
    r.has("y");
    r.number("y", kAny, "", 2);
    r.number("z", kAny, "", 3);
  }
  CHECK(config.resolved_text() ==
        "experiment = \"test\"\nseed = 1\nz = 3.0\n\n[[sweep.case]]\nname = \"a\"\nx = 1\n\n[[sweep.case]]\nname = "
        "\"b\"\n");

  auto part = config_of("[sweep]\nx = [1, 2]\n");  // a point that was not read may not know the key
  part.reader(0).number("z", kAny, "", 3);
  CHECK(part.resolved_text().find("z = ") == std::string::npos);
}

namespace {

void read_for_round_trip(Config& config) {
  for (std::size_t i = 0; i < config.point_count(); ++i) {
    auto r = config.reader(i);
    r.text("estimator.name", "", "msa");
    r.number("noise.scale", kAny, "", 1);
    r.number("field.total_nT", kAny, "");
    r.number("field.dip_deg", kAny, "", 0.1 + 0.2);
    r.choice("noise.reference.per", {"none", "run"}, "", "none");
    r.integer("trials", 1, 100, "", 10);
    r.csv("survey.file", "");
    if (r.text("estimator.name", "", "msa") == "msa") r.number("estimator.tolerance", kAny, "", 1e-9);
    if (r.has("gain")) r.numbers("gain", kAny, "", 3);
    for (auto& p : r.tables("published", "")) {
      p.number("value", kAny, "");
      p.text("note", "", "measured");
      p.matches_point("at");
    }
    r.finish();
  }
}

}  // namespace

TEST_CASE("Resolved config: reads back to the same points, text and hash") {
  const Folder folder;
  folder.write("a.csv", "x\n0.1\n1e-300\n");
  folder.write("b.csv", "x\n3\n");
  const std::string published =
      "[[published]]\nvalue = 1e22\nat = { 'noise.scale' = 1 }\n[[published]]\nvalue = 2\nnote = 'é'\n";
  const std::vector<std::string> bodies = {
      "estimator = 'msa'\nsurvey.file = 'a.csv'\n[field]\ntotal_nT = 51000.0\n" + published,
      "survey.file = 'a.csv'\nfield.total_nT = 51000\n[sweep]\n'noise.scale' = { from = 1, to = 0.5, step = -0.25 }\n"
      "estimator = ['msa', 'wls']\ngain = [[1, 1, 1], [1.1, 0.95, 1.25]]\n" +
          published,
      "field.total_nT = 51000\nestimator = { name = 'wls' }\n[[sweep.case]]\nname = 'a'\n'survey.file' = 'a.csv'\n"
      "[[sweep.case]]\nname = 'b'\nsurvey.file = 'b.csv'\nnoise = { scale = 3 }\nestimator = 'msa'\n" +
          published};
  for (const auto& body : bodies) {
    CAPTURE(body);
    auto config = Config::load(folder.write("t.toml", kHead + body), {"field.dip_deg=72.5", "trials=7"});
    read_for_round_trip(config);
    const std::string text = config.resolved_text();
    CAPTURE(text);
    auto again = Config::from_text(text, "result.h5", config.inputs());
    REQUIRE(again.point_count() == config.point_count());
    CHECK(again.seed() == config.seed());
    for (std::size_t i = 0; i < config.point_count(); ++i) CHECK(sweep_text(again, i) == sweep_text(config, i));
    read_for_round_trip(again);
    CHECK(again.resolved_text() == text);
    CHECK(again.hash() == config.hash());
    auto a = config.reader(0), b = again.reader(0);
    CHECK(a.number("field.total_nT", kAny, "") == b.number("field.total_nT", kAny, ""));
    CHECK(b.number("field.dip_deg", kAny, "") == 72.5);
  }
}

TEST_CASE("Hash: of what a run depends on, not of how it is written") {
  const Folder folder;
  const auto hash = [&](const std::string& body, const std::string& csv = "x\n1\n", const std::string& name = "a.csv") {
    folder.write("sub/" + name, csv);
    auto config = Config::load(folder.write("sub/t.toml", kHead + "file = '" + name + "'\n" + body), {});
    auto r = config.reader(0);
    r.text("estimator.name", "", "msa");
    r.csv("file", "");
    r.number("x", kAny, "", 1);
    r.finish();
    return config.hash();
  };
  const std::string base = hash("estimator = 'msa'\nx = 1.0\n");
  CHECK(base.size() == 32);
  CHECK(base.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(hash("x = 1.0 # comment\n\n[estimator]\nname = \"msa\"\n") == base);
  CHECK(hash("") == base);  // the defaults, written out
  CHECK(hash("", "# comment\n\"x\"\n1.0\n") == base);
  CHECK(hash("x = 2.0\n") != base);
  CHECK(hash("", "x\n1.0000000000000002\n") != base);
  CHECK(hash("", "y\n1\n") != base);
  CHECK(hash("", "x\n1\n1\n") != base);
  CHECK(hash("", "x\n1\n", "b.csv") != base);
}

TEST_CASE("A reader may outlive its config") {
  std::vector<ConfigReader> readers;
  {
    auto config = config_of("x = 3\n");
    auto moved = std::move(config);
    readers.push_back(moved.reader(0));
  }
  CHECK(readers[0].number("x", kAny, "") == 3);
}
