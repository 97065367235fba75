/// A survey of many stations, which has no trials to count and no blocks to stop between.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "registry.h"
#include "study/experiment.h"
#include "temporary_folder.h"

using namespace surveymc;
using namespace surveymc::study;

namespace {

constexpr std::uint64_t kStations = 2001;

/// A planned well with a station every 2 m.
RunPlan many_stations() {
  const std::vector<Experiment> studies = studies::all_experiments();
  const auto of = std::find_if(studies.begin(), studies.end(),
                               [](const Experiment& e) { return e.id == random::StudyId::position_covariance; });
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "long.toml";
  std::ofstream(file) << R"(experiment = "position_covariance"
[survey.plan]
spacing_m = 2.0
kickoff_m = 500.0
build_deg_per_30m = 3.0
inclination_deg = 60.0
azimuth_deg = 40.0
md_m = 4000.0
[field]
total_nT = 50000.0
dip_deg = 60.0
declination_deg = 1.0
[error_model]
name = "iscwsa_mwd_rev5.10"
)";
  return read_run(*of, config::Config::load(file, {}));
}

}  // namespace

TEST_CASE("A long survey says how many stations are done, and stops between them") {
  const RunPlan run = many_stations();
  std::vector<std::uint64_t> done;
  std::atomic<bool> stop = false;
  std::uint64_t stop_at = kStations + 1;
  montecarlo::RunOptions options{.stop = &stop};
  options.progress = [&](std::uint64_t now, std::uint64_t all) {
    CHECK(all == kStations);
    done.push_back(now);
    stop = now >= stop_at;
  };
  // By one thread the covariances and two tables that take as long. By two, the other table is made meanwhile.
  for (const auto& [threads, parts] : {std::pair<int, std::uint64_t>{1, 3}, {2, 2}}) {
    CAPTURE(threads);
    options.threads = threads;
    stop = false;
    done.clear();
    stop_at = kStations + 1;
    execute(run, options);
    REQUIRE(done.size() > 5 * parts);
    CHECK(std::is_sorted(done.begin(), done.end()));
    CHECK(done.back() == kStations);

    for (std::uint64_t part = 0; part < parts; ++part) {
      stop = false;
      done.clear();
      stop_at = (2 * part + 1) * kStations / (2 * parts);
      CHECK_THROWS_AS(execute(run, options), Interrupted);
      REQUIRE_FALSE(done.empty());
      CHECK(done.back() >= stop_at);
      CHECK(std::count_if(done.begin(), done.end(), [&](std::uint64_t d) { return d >= stop_at; }) ==
            1);  // and no later one
    }
  }
}
