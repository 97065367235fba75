#include "propagate/tool_validity.h"

#include <catch2/catch.hpp>

#include "base/units.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::propagate;
namespace em = error_model;

namespace {

em::Term term(const std::string& code, const std::string& function, const std::string& azimuth,
              em::PropagationMode mode) {
  auto f = std::make_shared<em::Function>();
  f->name = function;
  f->azimuth = em::parse_expression(azimuth);
  return {code, f, 1, "deg", kDegree, mode};
}

/// What validity says of two runs with a term each.
std::vector<Validity> validity_of_runs(const em::Term& upper, const em::Term& lower) {
  const survey::Survey s = test::survey_of(6, [](int k) { return survey::Station{100.0 * k, 0.3, 0.1 * k, 0}; });
  std::vector<ToolRun> runs;
  for (const em::Term* t : {&upper, &lower}) {
    auto model = std::make_shared<em::Model>();
    model->name = runs.empty() ? "U" : "L";
    model->terms = {*t};
    runs.push_back({runs.empty() ? 1 : 3, model});
  }
  return tool_validity(s, runs, test::field_of(50000, 72, 0), kNaN);
}

}  // namespace

TEST_CASE("An error that two runs share must act by one formula; errors of a run or a station are not shared") {
  using Mode = em::PropagationMode;
  for (const Mode mode : {Mode::random, Mode::systematic, Mode::well, Mode::global}) {
    const bool is_shared = mode == Mode::well || mode == Mode::global;
    CAPTURE(em::mode_letter(mode));
    const auto differs = validity_of_runs(term("A", "F", "1", mode), term("A", "G", "2", mode));
    REQUIRE(differs.size() == (is_shared ? 1 : 0));
    // The same formula under another name is the same; another under the same name is not, and both are shown.
    CHECK(validity_of_runs(term("A", "F", "1", mode), term("A", "G", "1", mode)).empty());
    const auto of_one_name = validity_of_runs(term("A", "F", "1", mode), term("A", "F", "2", mode));
    REQUIRE(of_one_name.size() == (is_shared ? 1 : 0));
    if (!is_shared) continue;
    CHECK(differs[0].rule == ValidityRule::function_differs);
    CHECK(differs[0].run == 1);
    CHECK(differs[0].first == 3);
    CHECK(differs[0].detail == "A is one error with that of U, but acts by F there and by G here");
    CHECK(of_one_name[0].detail ==
          "A is one error with that of U, but acts by F (azimuth = \"1\") there and by F (azimuth = \"2\") here");
  }
  CHECK(validity_of_runs(term("A", "F", "1", Mode::well), term("A", "G", "2", Mode::global)).empty());
}
