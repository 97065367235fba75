#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "cli/print_result.h"
#include "cli/progress.h"
#include "cli/sweep_pace.h"
#include "cli/verdict_counts.h"

using namespace surveymc;
using namespace surveymc::cli;

namespace {

using Texts = std::vector<std::string>;
using Numbers = std::vector<double>;

store::Table judged(const Texts& verdicts, const Texts& expected) {
  return {"t", "", {{"verdict", "", "", verdicts}, {"expected", "", "", expected}}};
}

std::string summary(const Texts& verdicts, const Texts& expected) {
  return in_words(count_verdicts({judged(verdicts, expected)}));
}

}  // namespace

TEST_CASE("The progress line is never wider than the screen, and its bar is as long as the share says") {
  for (std::size_t width = 8; width <= 120; ++width)
    for (const double share : {0.0, 0.5, 1.0}) {
      const std::string line = progress_line(share, "3e+03 trials", "1.23e+05", "1 h 20 min", width);
      CHECK(line.size() <= width);
      CHECK(line.find(" %") != std::string::npos);
      CHECK((line.find("1 h 20 min left") != std::string::npos) == (width >= 24));  // " 50.0 %  1 h 20 min left"
    }
  const std::string wide = progress_line(0.5, "3e+03 trials", "1.23e+05", "1 h 20 min", 120);
  CHECK(wide == "[###############...............]  50.0 % of 3e+03 trials  1.23e+05/s  1 h 20 min left");
  CHECK(progress_line(0.5, "9 trials", "1", "", 40) == "[######.......]  50.0 % of 9 trials  1/s");
}

TEST_CASE("The summary tells findings from what differs, and says what is not as expected") {
  CHECK(summary({}, {}).empty());
  CHECK(summary({"", ""}, {"", ""}).empty());
  CHECK(summary({"agrees", "differs"}, {"agrees", ""}) == "1 agrees, 1 differs");
  CHECK(summary({"differs", "differs"}, {"differs", "differs"}) == "2 findings; all as expected");
  CHECK(summary({"differs", "differs"}, {"differs", ""}) == "1 finding, 1 differs");
  CHECK(summary({"undecided", "agrees", ""}, {"agrees", "differs", "agrees"}) ==
        "1 agrees, 1 undecided; 3 not as expected (1 of them undecided)");
  CHECK(summary({"differs", "undecided", "agrees"}, {"either", "either", "either"}) ==
        "1 agrees, 1 finding, 1 undecided; all as expected");
  CHECK(summary({"undecided"}, {"agrees"}) == "1 undecided; 1 not as expected (undecided)");
}

TEST_CASE("An answer in feet: the lengths that its sources name, and nothing else") {
  const std::vector<store::Table> tables{
      {"t", "", {{"md_m", "m", "", Numbers{304.8, 3.048}}, {"share", "1", "", Numbers{0.1, 0.2}}}}};
  CHECK(in_feet("At 305 m: 6.1 m of 20 %, 3.05 mm.", "t.md_m[0]; t.md_m[1] * 2; t.share[1] * 100; t.md_m[1]", tables) ==
        "At 1000 ft: 20 ft of 20 %, 3.05 mm.");
  CHECK(in_feet("3 of 4 m.", "count t; count t where x = y", tables) == "3 of 4 m.");
}

TEST_CASE("Feet: lengths and areas by column and by the row's unit, and nothing else") {
  const store::Table feet = in_feet({"t",
                                     "",
                                     {{"md_m", "m", "", Numbers{0.3048, 304.8, 0}},
                                      {"nn_m2", "m2", "", Numbers{0.3048 * 0.3048, 0, 0}},
                                      {"dip_deg", "deg", "", Numbers{1, 2, 3}},
                                      {"unit", "", "", Texts{"m", "nT", "m2"}},
                                      {"monte_carlo", "1", "in the row's unit", Numbers{0.6096, 7, 0.3048 * 0.3048}},
                                      {"monte_carlo_ci_low", "1", "", Numbers{0.3048, 6, 0}},
                                      {"ratio", "1", "", Numbers{1, 2, 3}}}});
  const auto near = [](const store::Table& t, const char* name, const Numbers& wanted) {
    const auto& found = std::get<Numbers>(t.column(name).values);
    for (std::size_t i = 0; i < wanted.size(); ++i) CHECK_THAT(found[i], Catch::WithinRel(wanted[i], 1e-15));
  };
  near(feet, "md_ft", {1, 1000, 0});
  near(feet, "nn_ft2", {1, 0, 0});
  near(feet, "dip_deg", {1, 2, 3});
  near(feet, "monte_carlo", {2, 7, 1});
  near(feet, "monte_carlo_ci_low", {1, 6, 0});
  near(feet, "ratio", {1, 2, 3});
  CHECK(std::get<Texts>(feet.column("unit").values) == Texts{"ft", "nT", "ft2"});
  CHECK(feet.column("md_ft").unit == "ft");
  CHECK(feet.column("nn_ft2").unit == "ft2");
}

TEST_CASE("The time that is left of a sweep knows what its points cost") {
  // Two noises times three estimators, of which a trial costs 1, 10 and 100 s; ten trials a point, a note each.
  const std::vector<double> costs{1, 10, 100, 1, 10, 100};
  std::vector<PacedPoint> points;
  for (const char* noise : {"0.1", "1"})
    for (const char* estimator : {"a", "b", "c"}) points.push_back({10, {noise, estimator}});
  SweepPace pace(points);
  CHECK(pace.trials() == 60);
  CHECK(std::isnan(pace.left()));
  double elapsed = 0, total = 0;
  for (const double c : costs) total += 10 * c;
  for (std::size_t p = 0; p < costs.size(); ++p)
    for (std::uint64_t k = 1; k <= 10; ++k) {
      elapsed += costs[p];
      pace.note(10 * p + k, elapsed);
      // From the first point of the second noise on, every cost is known; the plain rate would be wrong by 50 %.
      if (p >= 3) CHECK_THAT(pace.left(), Catch::WithinRel(total - elapsed, 1e-6) || Catch::WithinAbs(0, 1e-6));
    }
  CHECK(pace.left() == 0);

  SweepPace resumed(points);  // the first two points and half of the third were done before
  resumed.note(26, 0.5);
  CHECK(std::isnan(resumed.left()));  // one note times nothing
  resumed.note(27, 100.5);
  CHECK_THAT(resumed.left(), Catch::WithinRel(3 * 100 + 30 * 100.0, 1e-12));
  SweepPace none;
  none.note(5, 1);
  CHECK(none.left() == 0);
  CHECK(none.trials() == 0);
}
