/// What points of a task prepare alike is prepared once: counted in the study that has such parts.
#include <algorithm>

#include <catch2/catch.hpp>

#include "montecarlo/ordered_merge.h"
#include "registry.h"
#include "study/parts.h"

using namespace surveymc;
using namespace surveymc::study;

namespace {

RunPlan run_of(const std::string& config, std::vector<std::string> set, const std::vector<std::string>& more) {
  const std::vector<Experiment> studies = studies::all_experiments();
  const auto of = std::find_if(studies.begin(), studies.end(),
                               [](const Experiment& e) { return e.id == random::StudyId::drift_monitoring; });
  set.insert(set.end(), more.begin(), more.end());
  return read_run(*of, config::Config::load(std::string(SURVEYMC_SOURCE_DIR) + "/configs/" + config, set));
}

/// The smoke config with one key swept, and all else fixed.
RunPlan drifting(const std::vector<std::string>& sweep) {
  return run_of("smoke/drift_monitoring.toml",
                {"trials=2", "sprt.shift_z=3.0", "baselines.calibration_trials=2", "series_every=0"}, sweep);
}

std::vector<std::string> tallies(const checkpoint::Part& part) {
  std::vector<std::string> out;
  for (const checkpoint::PartPiece& p : part.pieces) out.push_back(montecarlo::subtree_to_bytes(p.subtrees.at(0)));
  return out;
}

}  // namespace

TEST_CASE("Points of drift_monitoring share simulation, bandwidth search and calibration as far as they are equal") {
  struct Swept {
    std::vector<std::string> keys;
    std::size_t points, made;
  };
  // simulations + searches + calibrations
  const std::vector<Swept> all = {
      {{"sweep.drift.amplitude_z=[2.0, 4.0, 6.0]"}, 3, 1 + 1 + 1},
      {{"sweep.filter.gate=[3.0, 4.0]", "sweep.sprt.missed_alarm=[0.1, 0.2]"}, 4, 1 + 1 + 2},
      {{"sweep.baselines.cusum_allowance_z=[0.5, 0.25, 0.1]"}, 3, 1 + 1 + 3},
      {{"sweep.model.memory_vectors=[20, 25, 30]"}, 3, 1 + 3 + 3},
      {{"sweep.source.noise_to_signal=[0.1, 0.2, 0.3]"}, 3, 1 + 3 + 3},
      {{"sweep.source.sample_s=[120.0, 180.0, 240.0]"}, 3, 3 + 3 + 3}};
  for (const Swept& s : all) {
    INFO(s.keys.front());
    const RunPlan run = drifting(s.keys);
    REQUIRE(run.point_count() == s.points);
    const std::vector<std::string> together = tallies(run_part(run, {checkpoint::PointRange{0, s.points, 1}}, {}, {}));
    CHECK(run.shared().made() == s.made);
    if (s.points == 3 && s.made > 3) continue;
    for (std::uint64_t i = 0; i < s.points; ++i) {  // the same bits from tasks that share nothing
      const RunPlan alone = drifting(s.keys);
      CHECK(tallies(run_part(alone, PartChoice::of_point(i), {}, {})).at(0) == together.at(i));
      CHECK(alone.shared().made() == 3);
    }
  }
}

TEST_CASE("Points of drift_monitoring that share predictions have the tallies of points that compute their own") {
  const auto run = [](const std::string& key) {
    return run_of("monitoring/table1.toml",
                  {"trials=2", "source.sample_s=300.0", "model.memory_vectors=25", "baselines.calibration_trials=2",
                   "series_every=0"},
                  {key});
  };
  for (const auto& [key, values] :
       std::vector<std::pair<std::string, std::vector<std::string>>>{{"sprt.shift_z", {"2.0", "3.0"}},
                                                                     {"drift.amplitude_z", {"2.0", "4.0"}},
                                                                     {"drift.start_h", {"4.0", "8.0"}},
                                                                     {"filter.gate", {"3.0", "4.0"}},
                                                                     {"filter.process_variance_z2", {"1e-4", "4e-4"}},
                                                                     {"model.bandwidth", {"0.2", "0.3"}},
                                                                     {"model.memory_vectors", {"25", "30"}},
                                                                     {"source.noise_to_signal", {"0.2", "0.3"}},
                                                                     {"source.train_h", {"60.0", "90.0"}},
                                                                     {"source.step_h", {"6.0", "7.5"}},
                                                                     {"source.sample_s", {"300.0", "360.0"}}}) {
    INFO(key);
    std::vector<std::string> alone;  // before there is anything to share
    for (const std::string& value : values)
      alone.push_back(tallies(run_part(run(key + "=" + value), PartChoice::of_point(0), {}, {})).at(0));
    const RunPlan both = run("sweep." + key + "=[" + values[0] + ", " + values[1] + "]");
    CHECK(tallies(run_part(both, {checkpoint::PointRange{0, 2, 1}}, {}, {})) == alone);
  }
}
