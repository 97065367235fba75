/// Designs of a sweep: points by their number, and what is refused.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include "base/point_set.h"
#include "config/config.h"
#include "message_of.h"
#include "temporary_folder.h"

using namespace surveymc;
using namespace surveymc::config;
namespace fs = std::filesystem;

namespace {

Config swept(const std::string& body) { return Config::from_text("experiment = 'e'\nseed = 1\n" + body, "t.toml", {}); }

std::string refused(const std::string& body) {
  return message_of([&] { swept(body); });
}

std::string point_text(const Config& c, std::size_t point) {
  std::string out;
  for (const auto& [key, value] : c.sweep_values(point))
    out +=
        (out.empty() ? "" : " ") + key + "=" +
        (std::holds_alternative<double>(value) ? format_number(std::get<double>(value)) : std::get<std::string>(value));
  return out;
}

class SweepFolder : public TemporaryFolder {
 public:
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
  Config load(const std::string& csv, const std::string& body = "") const {
    write("points.csv", csv);
    write("t.toml", "experiment = 'e'\nseed = 1\n[sweep]\ndesign = { kind = 'table', file = 'points.csv' }\n" + body);
    return Config::load(path / "t.toml", {});
  }
  std::string refused(const std::string& csv, const std::string& body = "") const {
    const std::string text = message_of([&] { load(csv, body).check_sweep([] {}); }), folder = path.string() + "/";
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }
};

}  // namespace

TEST_CASE("Sets of points merge ranges that touch") {
  PointSet s;
  s.add(5);
  s.add(7, 9);
  s.add(6);
  s.add(20, 30);
  CHECK(s.ranges() == std::map<std::uint64_t, std::uint64_t>{{5, 9}, {20, 30}});
  CHECK(s.count() == 14);
  CHECK((s.contains(8) && !s.contains(9) && s.covers(21, 30) && !s.covers(8, 21)));
  CHECK((s.meets(0, 6) && !s.meets(9, 20) && s.meets(9, 21) && !s.meets(5, 5)));
  CHECK(s.others(25).ranges() == std::map<std::uint64_t, std::uint64_t>{{0, 5}, {9, 20}});
  s.add(0, 100);
  CHECK(s.ranges() == std::map<std::uint64_t, std::uint64_t>{{0, 100}});
  CHECK(s.others(100).empty());
}

TEST_CASE("Designs: ranges by count, linear and logarithmic, and of many values") {
  const Config c =
      swept("[sweep]\na = { from = 1, to = 100, count = 5, scale = 'log' }\nb = { from = 0, to = 1, count = 11 }\n");
  REQUIRE(c.point_count() == 55);
  CHECK(point_text(c, 0) == "a=1 b=0");
  CHECK(point_text(c, 3) == "a=1 b=0.3");
  CHECK(point_text(c, 11) == "a=3.1622776601684 b=0");
  CHECK(point_text(c, 22) == "a=10 b=0");
  CHECK(point_text(c, 54) == "a=100 b=1");
  auto whole = swept("[sweep]\nn = { from = 2, to = 10, count = 3 }\n");
  CHECK(whole.reader(1).integer("n", 0, 9, "") == 6);
  // 2^40 points: no list of them is made
  const Config large =
      swept("[sweep]\na = { from = 0, to = 1048575, step = 1 }\nb = { from = 0, to = 1, count = 1048576 }\n");
  CHECK(large.point_count() == std::uint64_t{1} << 40);
  CHECK(point_text(large, (std::uint64_t{1} << 40) - 1) == "a=1048575 b=1");
  CHECK(large.sample_points().size() < 3100);
  CHECK(large.sample_points() == large.sample_points());
}

TEST_CASE("Designs: lists that go together") {
  const std::string zip =
      "[sweep]\ndesign = 'zip'\na = [1, 2, 2]\nb = ['x', 'y', 'z']\nc = { from = 0.5, to = 1.5, count = 3 }\n";
  const Config c = swept(zip);
  REQUIRE(c.point_count() == 3);
  CHECK(point_text(c, 1) == "a=2 b=y c=1");
  CHECK(point_text(c, 2) == "a=2 b=z c=1.5");
  CHECK_FALSE(c.sweep_product());
  const Config cases = swept(zip + "[[sweep.case]]\nname = 'p'\nk = 1\n[[sweep.case]]\nname = 'q'\nk = 2\n");
  REQUIRE(cases.point_count() == 6);
  CHECK(point_text(cases, 4) == "case=q a=2 b=y c=1");
  CHECK(refused("[sweep]\ndesign = 'zip'\na = [1, 2]\nb = [1, 2, 3]\n") ==
        "t.toml:6: sweep.b: has 3 values, but sweep.a has 2: with design = \"zip\" all lists have the same length");
  CHECK(refused("[sweep]\na = [1, 2, 2]\n") == "t.toml:4: sweep.a = 2: is in the list twice");
}

TEST_CASE("Designs: latin hypercubes and Sobol' points") {
  for (const std::string kind : {"latin_hypercube", "sobol"}) {
    const Config c =
        swept(fmt::format("[sweep]\ndesign = {{ kind = '{}', points = 64, seed = 3 }}\nx = {{ from = 10, to = 20 }}\n"
                          "y = {{ from = 0.01, to = 100, scale = 'log' }}\nword = ['a', 'b', 'c', 'd']\nn = {{ from = "
                          "1, to = 8, step = 1 }}\n",
                          kind));
    REQUIRE(c.point_count() == 64);
    std::set<int> x, y;
    std::map<std::string, int> words;
    std::map<double, int> numbers;
    for (std::size_t i = 0; i < 64; ++i) {
      const auto v = c.sweep_values(i);
      REQUIRE(v.size() == 4);  // n, word, x, y
      ++numbers[std::get<double>(v[0].value)];
      ++words[std::get<std::string>(v[1].value)];
      x.insert(static_cast<int>((std::get<double>(v[2].value) - 10) / 10 * 64));
      y.insert(static_cast<int>((std::log10(std::get<double>(v[3].value)) + 2) / 4 * 64));
    }
    CHECK(x.size() == 64);  // one in each stratum
    CHECK(y.size() == 64);
    for (const char* w : {"a", "b", "c", "d"}) CHECK(words[w] == 16);
    for (int n = 1; n <= 8; ++n) CHECK(numbers[n] == 8);
    // What is written reads back to the same points.
    const Config again = Config::from_text(c.source_text(), "again", {});
    CHECK(point_text(again, 17) == point_text(c, 17));
    CHECK(again.source_hash() == c.source_hash());
  }
  CHECK(refused("[sweep]\nx = { from = 1, to = 2, scale = 'log' }\n") == "t.toml:4: sweep.x.count: missing");
  CHECK(refused("[sweep]\ndesign = { kind = 'sobol', points = 4 }\nx = { from = 1, to = 2 }\n") ==
        "t.toml:4: sweep.design.seed: missing: a design of kind sobol needs it");
  CHECK(refused("[sweep]\ndesign = { kind = 'sobol', points = 4, seed = 1, sed = 2 }\nx = { from = 1, to = 2 }\n") ==
        "t.toml:4: sweep.design.sed: unknown key: did you mean sweep.design.seed?");
  CHECK(refused("[sweep]\ndesign = { kind = 'sobol', points = 0, seed = 1 }\nx = { from = 1, to = 2 }\n") ==
        "t.toml:4: sweep.design.points = 0: must be in [1, 1099511627776]");
  CHECK(refused("[sweep]\ndesign = 'grid'\n") ==
        "t.toml:4: sweep.design = \"grid\": must be product, zip, latin_hypercube, sobol or table");
  CHECK(refused("[sweep]\ndesign = 'zip'\n") ==
        "t.toml:4: sweep.design = \"zip\": needs keys to vary: give some in [sweep]");
}

TEST_CASE("Designs: ranges that are none") {
  const auto x = [](const std::string& range) { return refused("[sweep]\nx = { " + range + " }\n"); };
  CHECK(x("from = 2, to = 1, count = 3") == "t.toml:4: sweep.x.from = 2: must not be above to = 1");
  CHECK(x("from = 1, to = 2, count = 0") == "t.toml:4: sweep.x.count = 0: must be in [1, 1099511627776]");
  CHECK(x("from = 1, to = 2, count = 1") == "t.toml:4: sweep.x.count = 1: must be above 1, as from and to differ");
  CHECK(x("from = 1, to = 2, count = 2.0") == "t.toml:4: sweep.x.count = 2.0: must be an integer");
  CHECK(x("from = -1, to = 2, count = 3, scale = 'log'") ==
        "t.toml:4: sweep.x.from = -1: must be > 0 on a logarithmic axis");
  CHECK(x("from = 1, to = 2, count = 3, scale = 'ln'") == "t.toml:4: sweep.x.scale = \"ln\": must be linear or log");
  CHECK(x("from = 1, to = 2, count = 3, step = 1") == "t.toml:4: sweep.x.step = 1: count and scale go without it");
  CHECK(x("from = 1, to = 2, step = 0") == "t.toml:4: sweep.x.step = 0: must not be 0");
  CHECK(x("from = 1, to = 1.0000000000000002, count = 9") ==
        "t.toml:4: sweep.x.count = 9: is too large: neighbouring values are the same number");
  CHECK(x("to = 2, count = 3") == "t.toml:4: sweep.x.from: missing");
}

TEST_CASE("Designs: points in a table") {
  const SweepFolder folder;
  const std::string csv = "# my points\nnoise.scale,estimator, n\r\n0.5,msa,1\n\n1.5,\"wls, a\",2\n2,x,3\n";
  Config c = folder.load(csv);
  REQUIRE(c.point_count() == 3);
  CHECK(point_text(c, 0) == "estimator=msa n=1 noise.scale=0.5");
  CHECK(point_text(c, 1) == "estimator=wls, a n=2 noise.scale=1.5");
  auto r = c.reader(2);
  CHECK(r.number("noise.scale", Range::positive(), "") == 2);
  CHECK(r.integer("n", 0, 9, "") == 3);
  CHECK(r.text("estimator", "") == "x");
  CHECK_NOTHROW(r.finish());
  CHECK(c.input_texts().at(0).path == "points.csv");  // it is stored in the result
  // Its contents are part of the hash.
  const std::string before = c.source_hash();
  CHECK(folder.load(csv + "3,y,4\n").source_hash() != before);
  CHECK(folder.load(csv).source_hash() == before);

  CHECK(folder.refused("a,b\n1,2\n3\n") == "points.csv:3: b: the cell is missing");
  CHECK(folder.refused("a,b\n1,2\n,4\n") == "points.csv:3: a: the cell is missing");
  CHECK(folder.refused("a,b\n1,2\n1,2,3\n") == "points.csv:3: has 3 cells, but there are 2 columns");
  CHECK(folder.refused("a,b\n1,2\n\"3,4\n") == "points.csv:3: a quote is not closed on its line");
  CHECK(folder.refused("a\n\"1\"2\n") == "points.csv:2: text after a closing quote");
  CHECK(folder.refused("a,a\n1,2\n") == "points.csv:1: a: two columns have this name");
  for (const char* columns : {"a,a.name\nx,y\n", "a.name,a\ny,x\n"})
    CHECK(folder.refused(columns) == "points.csv: a: is the same as a.name");
  CHECK(folder.refused("a\n") == "points.csv: has no rows: each is a point");
  CHECK(folder.refused("a,b\r1,2\r") == "points.csv:1: lines end with CR alone: save the file with LF or CR LF");
  CHECK(folder.refused("a;b\n1;2\n").starts_with("points.csv:1: \"a;b\": "));
  CHECK(folder.refused("a;b\r\n1,0;2,5\r\n").starts_with("points.csv:1: \"a;b\": "));
  CHECK(folder.refused("a,trials\n1,2\n") == "points.csv: trials: cannot be swept: a result has one number of trials");
  CHECK(folder.refused("a,verdict.family\n1,none\n") ==
        "points.csv: verdict.family: sets verdict.family, which cannot be swept: a result has one family of verdicts");
  CHECK(folder.refused("a\n1\n", "b = [1, 2]\n") ==
        "t.toml:5: sweep.b: cannot be swept beside a table of points: make it a column of that table");
  CHECK(folder.refused("a\n1\n", "[[sweep.case]]\nname = 'x'\na = 3\n") ==
        "t.toml:7: a = 3: is also in [sweep]: a key can vary with the case or by itself");
  folder.load(csv);
  CHECK_THROWS_WITH(Config::load(folder.path / "t.toml", {"n=5"}),
                    "--set n=5: n = 5: n is a column of points.csv: delete that column");
}

TEST_CASE("Designs: rows of a long table are found by their number") {
  const SweepFolder folder;
  std::string csv = "x\n";
  for (int i = 0; i < 5000; ++i) csv += fmt::format("{}{}\n", i, i % 7 == 0 ? "\n# a comment" : "");
  const Config c = folder.load(csv);
  REQUIRE(c.point_count() == 5000);
  for (const std::size_t i : {4999u, 0u, 1023u, 1024u, 3000u, 2048u})
    CHECK(point_text(c, i) == "x=" + std::to_string(i));
}

TEST_CASE("Tables of points keep every row: no value of a spreadsheet is taken for a comment") {
  const SweepFolder folder;
  const std::string said = "points.csv:3: a.b = \"#N/A\": must be a number, as in the first row of points.csv";
  CHECK_THROWS_WITH(folder.load("a.b,n\n1,2\n#N/A,3\n4,5\n").sweep_values(1), said);
  CHECK(folder.load("a.b,n\n1,2\n# N/A,3\n4,5\n").point_count() == 2);
}

TEST_CASE("Tables of points may have the empty cells that spreadsheets write") {
  const SweepFolder folder;
  const Config c = folder.load("a.b,n,,\n1,2,,\n,,,\n3,true\n,\n");
  REQUIRE(c.point_count() == 2);
  CHECK(point_text(c, 0) == "a.b=1 n=2");
  Config loaded = folder.load("north\ntrue\ngrid\n");
  CHECK(loaded.reader(0).choice("north", {"true", "grid"}, "") == "true");
  CHECK(Config::load(folder.path / "t.toml", {"word=true"}).reader(0).choice("word", {"true", "grid"}, "") == "true");
  CHECK(folder.refused("a.b,n\n1,\n").find("points.csv:2: n: the cell is missing") != std::string::npos);
  CHECK(folder.refused("a.b,n\n1,2,3\n").find("has 3 cells, but there are 2 columns") != std::string::npos);
}
