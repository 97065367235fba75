/// What a correction by any parameters leaves of a code's errors: trials against first order.
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "analysis/well_design.h"
#include "base/units.h"
#include "config/error_model_file.h"
#include "corrected_codes/runs.h"

using namespace surveymc;
using multistation::ParameterSet;

namespace {

/// A building well, the tool's errors of MWD+IFR1, those of the stations, and noise; corrected by six parameters.
/// Errors of the declination, which no loss sees, are left out.
struct CodeRun {
  survey::Survey well =
      analysis::make_well({.stations = 60, .spacing = 20, .build_rate = 3 * kDegree / 30}, 75 * kDegree, 60 * kDegree);
  survey::ReferenceField field{9.81, 50000, 70 * kDegree, -4 * kDegree, 0};
  analysis::CodeCase which;

  explicit CodeRun(multistation::Loss loss, const char* set = "6") {
    const auto model = [](const char* name) { return config::load_shipped_model(*config::find_shipped_model(name)); };
    which.draws = propagate::map_code(*model("MWD+IFR1"), model("MWD+IFR1+AX").get()).draws;
    which.draws.run = {};
    which.draws.station.declination = which.draws.station.east = 0;
    which.noise = 100;
    which.claimed = std::make_shared<const propagate::ClaimedCode>(*model("MWD+IFR1+MS"));
    which.correction.kind = analysis::Correction::Kind::parameters;
    multistation::FitOptions& o = which.correction.parameters;
    o.sizes = {.002, 120, 120};
    o.parameters = ParameterSet::named(set);
    o.gravity_is_noisy = false;
    which.correction.robust = multistation::robust_options(loss);
    which.correction.cost = multistation::loss_cost(loss, multistation::fit_plan(o));
  }
  /// Sd of the lateral position and of the azimuth of the last station to first order, and by trials.
  std::array<std::array<double, 2>, 2> sds() const {
    using analysis::CodeQuantity;
    const analysis::CodeComparison predicted = analysis::compare_code(well, field, which, false);
    REQUIRE(predicted.after.determined);
    const studies::corrected_codes::CorrectedRuns runs(which, well, field, predicted);
    constexpr int kTrials = 4096;
    const studies::corrected_codes::CorrectedRun run = runs.run(random::Stream(11, 1), 0, kTrials);
    const Eigen::RowVector3d right = analysis::code_direction(predicted, well, CodeQuantity::lateral);
    const int last = runs.stations() - 1;
    std::array<double, 2> squares{};
    for (int t = 0; t < kTrials; ++t) {
      REQUIRE(run.converged.value(t, 0) == 1);
      const survey::LaneArray& p = run.position[1];
      squares[0] +=
          std::pow(right * (Eigen::Vector3d(p.value(t, 0), p.value(t, 1), p.value(t, 2)) - runs.position()), 2);
      squares[1] += std::pow(run.lateral[1].value(t, last), 2);
    }
    const auto sd = [&](CodeQuantity q) {
      return analysis::code_sds(predicted, well, q, analysis::CodeScope::magnetic, static_cast<std::size_t>(last))
          .after;
    };
    return {{{sd(CodeQuantity::lateral), sd(CodeQuantity::azimuth)},
             {std::sqrt(squares[0] / kTrials), std::sqrt(squares[1] / kTrials)}}};
  }
};

}  // namespace

TEST_CASE("What a robust loss costs a corrected code is what first order says") {
  // Ratios of sds over the same draws: some 0.5 % of standard error, of which 4.5.
  // With twelve parameters |g| is fitted, but has no noise: a residual is as long as two components are.
  using multistation::Loss;
  for (const char* set : {"6", "12"}) {
    const auto plain = CodeRun(Loss::least_squares, set).sds();
    for (const Loss loss : {Loss::l1, Loss::tukey}) {
      const auto robust = CodeRun(loss, set).sds();
      for (std::size_t i = 0; i < 2; ++i) {
        const double predicted = robust[0][i] / plain[0][i], found = robust[1][i] / plain[1][i];
        CAPTURE(set, loss, i, predicted, found);
        CHECK(std::abs(found / predicted - 1) < 0.025);
      }
      if (loss == Loss::l1 && set == std::string("6")) CHECK(robust[0][0] / plain[0][0] > 1.03);
    }
  }
}

TEST_CASE("A robust loss of a corrected code knows what the fit leaves of shared errors") {
  CodeRun run(multistation::Loss::l1);
  const auto limits = [&] { return analysis::compare_code(run.well, run.field, run.which, false).after.limits; };
  CHECK(limits().shared < analysis::kLargeSharedResidual);
  CHECK(limits().uneven < analysis::kLargeUnevenness);
  run.which.draws.run = {300, 0.3 * kDegree, 0, 0};
  CHECK(limits().shared > analysis::kLargeSharedResidual);
  run.which.correction.parameters.estimates_reference = true;
  run.which.correction.parameters.reference = {0, 300, 0.3 * kDegree};
  CHECK(limits().shared < analysis::kLargeSharedResidual);
  run.which.turned = true;
  CHECK(limits().shared < analysis::kLargeSharedResidual);
  run.which.correction.parameters.estimates_reference = false;
  CHECK(limits().shared > analysis::kLargeSharedResidual);
}

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
