#include "compare/verdict_stop.h"

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::compare;

TEST_CASE("A row without a verdict neither ends a run nor keeps it going; none with one decides nothing") {
  TrialPlan plan;
  plan.trials = 100'000;
  plan.looks = {4096, 8192, 100'000};
  plan.decisive = {{"position", "joint", "sigma3_north"}, {"position", "joint", "sigma3_east"}};
  stats::Tally tally;
  tally.trials = 4096;
  const auto needed = [&](const std::string& north, const std::string& east) {
    const auto row = [](const std::string& quantity, const std::string& verdict) {
      return ComparisonRow{.formulation = "joint", .quantity = quantity, .unit = "m", .verdict = verdict};
    };
    const VerdictStop stop(plan, {}, [&](const stats::Tally&) {
      return RowsOfTables{{"position", {row("sigma3_north", north), row("sigma3_east", east), row("other", "agrees")}}};
    });
    REQUIRE(stop.is_on());
    return stop.trials_needed(tally);
  };
  CHECK(needed("agrees", "differs") == 4096);
  CHECK(needed("agrees", "undecided") > 4096);
  CHECK(needed("agrees", "") == 4096);  // no trials give it a verdict
  CHECK(needed("undecided", "") > 4096);
  CHECK(needed("", "") > 4096);  // by itself it ends nothing
}
