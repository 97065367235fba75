/// What a correction by any parameters leaves of a code's errors: trials against first order.
#include <cmath>

#include <catch2/catch.hpp>

#include "analysis/well_design.h"
#include "base/units.h"
#include "config/error_model_file.h"
#include "corrected_codes/runs.h"

using namespace surveymc;
using multistation::ParameterSet;

TEST_CASE("What sets of parameters leave of a code's errors scatters as first order says") {
  const auto model = [](const char* name) { return config::load_shipped_model(*config::find_shipped_model(name)); };
  const survey::Survey well =
      analysis::make_well({.stations = 30, .spacing = 40, .build_rate = 3 * kDegree / 30}, 75 * kDegree, 60 * kDegree);
  const survey::ReferenceField field{9.81, 50000, 70 * kDegree, -4 * kDegree, 0};
  analysis::CodeCase which;
  which.draws = propagate::map_code(*model("MWD+IFR1"), model("MWD+IFR1+AX").get()).draws;
  which.noise = 30;
  which.claimed = std::make_shared<const propagate::ClaimedCode>(*model("MWD+IFR1+MS"));
  which.correction.kind = analysis::Correction::Kind::parameters;
  multistation::FitOptions& o = which.correction.parameters;
  o.sizes = {.002, 80, 80};
  // 12 as is; with a rotation that the tool has not, and the reference; without errors that the tool has.
  struct Case {
    ParameterSet set;
    bool joint;
  };
  for (const Case& c : {Case{ParameterSet::named("12"), false}, Case{ParameterSet::named("18"), true},
                        Case{ParameterSet::of({"abz", "mbz", "msx", "rz"}), false}}) {
    CAPTURE(c.set.name());
    o.parameters = c.set;
    o.estimates_reference = c.joint;
    o.reference = {0, which.draws.run.total, which.draws.run.dip};
    const analysis::CodeComparison predicted = analysis::compare_code(well, field, which, false);
    REQUIRE(predicted.after.determined);
    const studies::corrected_codes::CorrectedRuns runs(which, well, field, predicted);
    constexpr int kTrials = 4096;
    const studies::corrected_codes::CorrectedRun run = runs.run(random::Stream(11, 1), 0, kTrials);
    const Eigen::RowVector3d right = analysis::code_direction(predicted, well, analysis::CodeQuantity::lateral);
    double lateral = 0;
    std::array<double, 3> azimuth{};
    const std::array<int, 3> stations{0, 14, runs.stations() - 1};
    for (int t = 0; t < kTrials; ++t) {
      REQUIRE(run.converged.value(t, 0) == 1);
      const survey::LaneArray& p = run.position[1];
      const double off = right * (Eigen::Vector3d(p.value(t, 0), p.value(t, 1), p.value(t, 2)) - runs.position());
      lateral += off * off / kTrials;
      for (std::size_t i = 0; i < stations.size(); ++i)
        azimuth[i] += std::pow(run.lateral[1].value(t, stations[i]), 2) / kTrials;
    }
    // A sd of 4096 trials has a standard error of 1.1 %; 4.5 of them, and 1 % for second order.
    const auto sd = [&](analysis::CodeQuantity q, int station) {
      return analysis::code_sds(predicted, well, q, analysis::CodeScope::magnetic, static_cast<std::size_t>(station))
          .after;
    };
    CHECK(std::abs(std::sqrt(lateral) / sd(analysis::CodeQuantity::lateral, 0) - 1) < .06);
    for (std::size_t i = 0; i < stations.size(); ++i) {
      CAPTURE(stations[i]);
      CHECK(std::abs(std::sqrt(azimuth[i]) / sd(analysis::CodeQuantity::azimuth, stations[i]) - 1) < .06);
    }
  }
}
