#include <cmath>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "compare/answer.h"

using namespace surveymc;
using namespace surveymc::compare;

namespace {

using Numbers = std::vector<double>;
using Words = std::vector<std::string>;

/// A comparison of a sweep of two points, with these verdicts and expected ones.
std::vector<store::Table> comparison(const Words& verdicts, const Words& expected) {
  return {{"position",
           "",
           {{"noise.scale", "1", store::kSweepKey, Numbers{1, 1, 0.5, 0.5}},
            {"formulation", "", "", Words{"joint", "random", "joint", "random"}},
            {"quantity", "", "", Words{"north", "north", "north", "north"}},
            {"unit", "", "", Words{"m", "m", "m", "m"}},
            {"monte_carlo", "1", "value, in the row's unit", Numbers{2.0, 2.0, 0.91234, 0.91234}},
            {"ratio", "1", "", Numbers{1.01, 0.5, 0.99, 3.0}},
            {"margin", "1", "", Numbers{0.02, 0.02, 0.05, 0.05}},
            {"verdict", "", "", verdicts},
            {"expected", "", "", expected}}}};
}

Words sentences(const Answer& answer) { return std::get<Words>(answer.table().column("sentence").values); }
Words sources(const Answer& answer) { return std::get<Words>(answer.table().column("sources").values); }

Words said(const Words& verdicts, const Words& expected) {
  const std::vector<store::Table> tables = comparison(verdicts, expected);
  Answer answer;
  answer.say_verdicts(Rows(tables, "position"), "values");
  return answer.empty() ? Words{} : sentences(answer);
}

}  // namespace

TEST_CASE("A number of a sentence has three digits, and all before the decimal point") {
  CHECK(three_digits(1.2345) == "1.23");
  CHECK(three_digits(0.091234) == "0.0912");
  CHECK(three_digits(2514.4) == "2514");
  CHECK(three_digits(-17) == "-17");
  CHECK(three_digits(3.1e-12) == "3.1e-12");
  CHECK(three_digits(2.0e10) == "2e10");
  CHECK(three_digits(0) == "0");
  CHECK(three_digits(kInfinity) == "infinite");
  CHECK(three_digits(kNaN) == "no number");
}

TEST_CASE("Rows are chosen by words and numbers, and say where a number is from") {
  const std::vector<store::Table> tables = comparison({"agrees", "differs", "agrees", ""}, {"", "", "", ""});
  const Rows all(tables, "position"), joint = all.where("formulation", "joint");
  CHECK(all.size() == 4);
  CHECK(joint.size() == 2);
  CHECK(joint.count().source == "count position where formulation = joint");
  CHECK(joint.between("ratio", 1, 2).size() == 1);
  const Rows least = joint.at_least("monte_carlo");
  CHECK(least.figure("monte_carlo").unit == "m");
  CHECK(least.figure("monte_carlo").source == "position.monte_carlo[2]");
  CHECK(least.figure("monte_carlo").times(2).value == 2 * 0.91234);
  CHECK(least.point().text == " (noise.scale = 0.5)");
  CHECK(all.where("formulation", "random").at_point_of(least).number("ratio") == 3.0);
  CHECK(all.words("formulation") == Words{"joint", "random"});
  CHECK(all.at_largest("ratio", [](double r) { return std::abs(std::log(r)); }).number("ratio") == 3.0);
  CHECK(Rows(tables, "nowhere").empty());
  CHECK(all.where("no_column", "x").empty());
  CHECK(all.without("no_column", "x").size() == 4);
}

TEST_CASE("An answer says each number with its source") {
  const std::vector<store::Table> tables = comparison({"agrees", "agrees", "agrees", "agrees"}, {"", "", "", ""});
  const Rows row = Rows(tables, "position").last();
  Answer answer;
  answer.say("It is {}{}, {} of {}.",
             {row.figure("monte_carlo"), row.point(), row.figure("margin").percent(), row.word("formulation")});
  CHECK(sentences(answer) == Words{"It is 0.912 m (noise.scale = 0.5), 5 % of random."});
  CHECK(sources(answer) == Words{"position.monte_carlo[3]; position.noise.scale[3]; position.margin[3] * 100"});
}

TEST_CASE("A sentence has as many parts as places") {
  Answer answer;
  CHECK_THROWS_AS(answer.say("{} of {}.", {"1"}), std::logic_error);
  CHECK_THROWS_AS(answer.say("{}.", {"1", "2"}), std::logic_error);
}

TEST_CASE("Failed trials are said, of the row that lost most") {
  Answer answer;
  answer.say_failures({{"a", "", {{"trials", "1", "", Numbers{10, 10}}, {"failed", "1", "", Numbers{0, 0}}}}});
  CHECK(answer.empty());
  answer.say_failures({{"a", "", {{"trials", "1", "", Numbers{10, 10}}, {"failed", "1", "", Numbers{1, 4}}}},
                       {"b", "", {{"failed", "1", "", Numbers{9}}}}});
  CHECK(sentences(answer) == Words{"4 of 10 trials failed: these numbers are of the others."});
  CHECK(sources(answer) == Words{"a.failed[1]; a.trials[1]"});
}

TEST_CASE("Verdicts in a sentence: holds, not contradicted, undecided, does not hold; findings apart") {
  CHECK(said({"", "", "", ""}, {"", "", "", ""}).empty());
  CHECK(said({"agrees", "agrees", "agrees", ""}, {"", "", "", ""}) ==
        Words{"The prediction holds: 3 of 3 values agree within 2 to 5 %."});
  CHECK(said({"agrees", "undecided", "", ""}, {"", "", "", ""}) ==
        Words{"The prediction is not contradicted: 1 of 2 values agree within 2 %, 1 undecided."});
  CHECK(said({"undecided", "", "", ""}, {"", "", "", ""}) ==
        Words{"The prediction is undecided: 0 of 1 values agree within 2 %, 1 undecided."});
  CHECK(
      said({"agrees", "differs", "agrees", "differs"}, {"", "", "", ""}) ==
      Words{"The prediction does not hold everywhere: 2 of 4 values agree within 2 to 5 %, 2 differ; worst is north of "
            "random (noise.scale = 0.5), 3 times the Monte-Carlo value."});
  CHECK(said({"agrees", "differs", "agrees", "differs"}, {"", "differs", "", "differs"}) ==
        Words{"The prediction holds: 2 of 2 values agree within 2 to 5 %.",
              "A finding: 2 values of formulations known to be wrong differ."});
}

TEST_CASE("Formulations side by side") {
  const std::vector<store::Table> tables =
      comparison({"agrees", "differs", "agrees", "agrees"}, {"", "differs", "", ""});
  Answer answer;
  answer.say_formulations(Rows(tables, "position"), "the value");
  CHECK(sentences(answer) ==
        Words{"Predictions of the value agree with Monte Carlo within 2 to 5 % by formulation: joint "
              "in 2 of 2, random in 1 of 2; 1 are known to differ."});
}

TEST_CASE("A table that waits on the disk makes no sentence, and is not taken for an empty one") {
  store::Table many{"many", "", {{"x", "1", "", Numbers{}}}};
  for (int i = 0; i < 100 && many.is_held(); ++i)
    store::append_rows(many, {"many", "", {{"x", "1", "", Numbers(100'000, 1.0)}}});
  REQUIRE(!many.is_held());
  CHECK_THROWS_AS(Rows({many}, "many"), LongTable);
  Answer answer;
  answer.say_failures({many});
  CHECK(answer.empty());
}
