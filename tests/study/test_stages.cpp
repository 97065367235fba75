/// A task reads and prepares the points that it runs, and no others.
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "normal_draws.h"
#include "random/study_stream.h"
#include "store/result_file.h"
#include "study/parts.h"
#include "study/sweep_columns.h"
#include "temporary_folder.h"

using namespace surveymc;
using namespace surveymc::study;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

constexpr std::size_t kPoints = 4;
std::atomic<int> g_read = 0;
std::array<std::atomic<int>, kPoints> g_prepared;

void forget() {
  g_read = 0;
  for (auto& p : g_prepared) p = 0;
}
std::array<int, kPoints> prepared() {
  std::array<int, kPoints> n{};
  for (std::size_t i = 0; i < kPoints; ++i) n[i] = g_prepared[i];
  return n;
}
using Times = std::array<int, kPoints>;

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 0;
  std::size_t number = 0;
  config::ConfigPlace place;
};

/// Mean of the trials' draws, times the point's number; a stream of three numbers.
class CountedPoint final : public StudyPoint {
 public:
  explicit CountedPoint(const Scenario& s) : s_(s), stream_(random::stream_of(s.seed)) {}
  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    return {.trials = static_cast<std::uint64_t>(block.count),
            .moments = stats::Moments::of(static_cast<double>(s_.number) *
                                          test::normal_draws(stream_, block.first, block.count, 1))};
  }
  PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    PointResult r;
    const double mean = tally.trials > 0 ? tally.moments.mean[0] : 0;
    r.tables.push_back({"t", "", {{"mean", "1", "", std::vector<double>{mean}}}});
    r.streams.push_back({{{"m", "1", "", {{"k", "1", "", std::vector<double>{0, 1, 2}}}, {}}},
                         [this](std::size_t first, std::size_t n) {
                           return std::vector<std::vector<double>>{
                               std::vector<double>(n, static_cast<double>(s_.number) + static_cast<double>(first))};
                         }});
    return r;
  }

 private:
  Scenario s_;
  random::Stream stream_;
};

class CountedPlan final : public PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  std::unique_ptr<StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    ++g_prepared.at(s_.number);
    s_.place.require(s_.trials != 13, "what only computing shows");
    return std::make_unique<CountedPoint>(s_);
  }
};

Experiment counted() {
  return {random::StudyId::none, "", "",
          [](config::ConfigReader& c, random::StudySeed seed) -> std::unique_ptr<PointPlan> {
            ++g_read;
            Scenario s{seed, 0, 0, {}};
            s.trials = static_cast<std::uint64_t>(c.integer("trials", 0, 1'000'000, ""));
            s.number = static_cast<std::size_t>(c.integer("number", 0, kPoints - 1, ""));
            s.place = c.place("number");
            c.finish();
            return std::make_unique<CountedPlan>(std::move(s));
          }};
}

config::Config config_of(int trials, const std::string& numbers = "[0, 1, 2, 3]") {
  const std::string text =
      fmt::format("experiment = 'e'\nseed = 9\ntrials = {}\n[sweep]\nnumber = {}\n", trials, numbers);
  return config::Config::from_text(text, "t.toml", {});
}

/// Of the key `other`, from..to: more points than are read whole.
config::Config large_sweep(int from, int to) {
  return config::Config::from_text(
      fmt::format("experiment = 'e'\nseed = 9\ntrials = 4\n[sweep]\nother = {{ from = {}, to = {}, step = 1 }}\n", from,
                  to),
      "t.toml", {});
}

/// Read anew, as a task does it.
RunPlan task(int trials) {
  forget();
  return read_run(counted(), config_of(trials));
}

/// Files of parts, as tasks write them.
class PartFiles {
 public:
  void add(checkpoint::Part part) {
    part.key.program = "this";
    paths_.push_back(folder_ / fmt::format("{}.part", paths_.size()));
    checkpoint::write_part(paths_.back(), part);
  }
  PartSet set() const { return PartSet(paths_, "this"); }
  const std::vector<std::filesystem::path>& paths() const { return paths_; }
  std::filesystem::path folder() const { return folder_.path; }

 private:
  TemporaryFolder folder_;
  std::vector<std::filesystem::path> paths_;
};

store::Result merged(const RunPlan& run, const PartFiles& files) {
  PartSet parts = files.set();
  return merge_parts(run, parts, {});
}

/// Reads none of the points.
RunPlan opened(int trials) {
  forget();
  return open_run(counted(), config_of(trials));
}

store::Result merged_file(const std::filesystem::path& path) {
  PartSet parts({path}, "this");
  return merge_parts(opened(2000), parts, {});
}

std::vector<double> means(const store::Result& r) {
  return std::get<std::vector<double>>(r.tables[0].column("mean").values);
}

}  // namespace

TEST_CASE("Reading, checking and planning a sweep prepare no point") {
  const RunPlan run = task(2000);
  CHECK(g_read == 4);
  CHECK(run.total_trials() == 8000);
  check_choice(run, PartChoice::of_point(2));
  CHECK(part_pieces(run, {}).size() == 4);
  CHECK(prepared() == Times{});
  CHECK(g_read == 4);
}

TEST_CASE("A part of a run reads and prepares its own points, and a whole run each of them once") {
  const store::Result whole = execute(task(2000), {});
  CHECK(prepared() == Times{1, 1, 1, 1});
  PartFiles points, shards, ranges, strides;
  for (std::uint64_t i = 0; i < kPoints; ++i) {
    points.add(run_part(opened(2000), PartChoice::of_point(i), {}, {}));
    Times only{};
    only[i] = 1;
    CHECK(g_read == 1);
    CHECK(prepared() == only);
  }
  ranges.add(run_part(opened(2000), {checkpoint::PointRange{0, 3, 1}}, {}, {}));
  CHECK(g_read == 3);
  CHECK(prepared() == Times{1, 1, 1, 0});
  ranges.add(run_part(opened(2000), {checkpoint::PointRange{3, 4, 1}}, {}, {}));
  for (std::uint64_t i = 0; i < 2; ++i)
    strides.add(run_part(opened(2000), {checkpoint::PointRange{i, kPoints, 2}}, {}, {}));
  CHECK(prepared() == Times{0, 1, 0, 1});
  // 4 blocks a point: of 6 shards some have no block of it
  for (std::uint64_t i = 0; i < 6; ++i) {
    const RunPlan run = task(2000);
    shards.add(run_part(run, {std::nullopt, i, 6}, {}, {}));
    Times those{};
    for (const checkpoint::PartPiece& p : part_pieces(run, {std::nullopt, i, 6}))
      those[p.point] = p.blocks.first < p.blocks.end;
    CHECK(prepared() == those);
  }
  CHECK(prepared() != Times{});
  for (const PartFiles* files : {&points, &shards, &ranges, &strides}) {
    CHECK(means(merged(opened(2000), *files)) == means(whole));
    CHECK(prepared() == Times{1, 1, 1, 1});  // reports need the points
  }
  // A tree of merges: parts of parts, also where they overlap
  PartFiles tree;
  for (const PartFiles* files : {&points, &shards, &strides}) {
    const std::filesystem::path larger = tree.folder() / fmt::format("larger{}.part", tree.paths().size());
    PartSet set = files->set();
    set.write_merged(larger, nullptr);
    CHECK(means(merged_file(larger)) == means(whole));
    tree.add(checkpoint::read_part(larger));
  }
  CHECK(means(merged(opened(2000), tree)) == means(whole));
}

TEST_CASE("Points without trials that an earlier attempt has kept are not prepared again") {
  PartFiles files;  // for the folder
  const std::filesystem::path output = files.folder() / "r.h5";
  const checkpoint::RunKey key{"config", "program"};
  const store::Result whole = execute(task(0), {});
  std::atomic<bool> stop = false;
  {
    checkpoint::Journal journal(output, key, std::chrono::duration<double>(0));
    const montecarlo::RunOptions options{.stop = &stop};
    const RunPlan run = task(0);
    const Checkpoint checkpoint{{}, &journal, {}};
    ComputedPoints points(run, options, checkpoint);
    points.compute(0);
    CHECK(points.compute(2).result.streams.at(0).values(1, 2) ==
          std::vector<std::vector<double>>{{2, 2}});  // from memory, else {3, 3}
    stop = true;
    CHECK_THROWS_AS(points.compute(1), Interrupted);
    CHECK(prepared() == Times{1, 0, 1, 0});
    REQUIRE(journal.sync());
  }
  stop = false;
  checkpoint::JournalContents kept = checkpoint::read_journals(output, key);
  CHECK(kept.points.size() == 2);
  const RunPlan run = task(0);
  const store::Result again = execute(run, {}, {std::move(kept.finished), nullptr, std::move(kept.points)});
  CHECK(prepared() == Times{0, 1, 0, 1});
  CHECK(means(again) == means(whole));
  CHECK(store::content_hash(again) == store::content_hash(whole));
}

TEST_CASE("Merging a study without trials prepares nothing: the parts have its tables") {
  PartFiles points;
  for (std::uint64_t i = 0; i < kPoints; ++i) points.add(run_part(opened(0), PartChoice::of_point(i), {}, {}));
  CHECK(means(merged(opened(0), points)) == std::vector<double>(4, 0.0));
  CHECK(prepared() == Times{});
}

TEST_CASE("A merge names the points and trials that no part has") {
  PartFiles files;
  files.add(run_part(opened(2000), {checkpoint::PointRange{2, 3, 1}}, {}, {}));
  files.add(run_part(task(2000), {checkpoint::PointRange{0, 1, 1}, 0, 2}, {}, {}));
  CHECK_THROWS_WITH(merged(opened(2000), files),
                    "the parts are not the whole run: missing points 1,3; of point 0 the trials 1024 to 1999");
}

TEST_CASE("In a sweep that is too large to be read whole, a point that fails is listed and the others go on") {
  static constexpr int kLarge = kMostReadWhole + 1;
  const Experiment failing = {
      random::StudyId::none, "", "", [](config::ConfigReader& c, random::StudySeed seed) -> std::unique_ptr<PointPlan> {
        ++g_read;
        c.integer("trials", 0, 1'000'000, "");
        const auto other = static_cast<std::uint64_t>(c.integer("other", 0, 1'000'000, ""));
        c.require(other != 2 && other != 5, "other", "must not be 2 or 5");
        c.finish();
        return std::make_unique<CountedPlan>(Scenario{seed, other == 4 ? 13u : 4u, other % kPoints, c.place("other")});
      }};
  forget();
  PartFiles files;
  files.add(run_part(open_run(failing, large_sweep(1, kLarge)), {checkpoint::PointRange{0, 6, 1}}, {}, {}));
  CHECK(g_read < 12);  // of its 6 points
  const checkpoint::Part part = checkpoint::read_part(files.paths()[0]);
  CHECK(checkpoint::read_part_head(files.paths()[0]).failed);
  CHECK(part.pieces[1].failure == "other = 2: must not be 2 or 5");
  CHECK_THAT(part.pieces[3].failure, EndsWith("what only computing shows (point 3 of the sweep)"));
  CHECK(part.pieces[4].failure == "other = 5: must not be 2 or 5");
  CHECK(part.pieces[5].failure.empty());
  files.add(run_part(open_run(failing, large_sweep(1, kLarge)), {checkpoint::PointRange{6, kLarge, 1}}, {}, {}));
  const store::Result r = merged(open_run(failing, large_sweep(1, kLarge)), files);
  REQUIRE(r.tables.size() == 3);
  CHECK(r.tables[2].name == "warnings");
  CHECK(r.tables[0].rows() == kLarge - 3);
  const store::Table& failed = r.tables[1];
  CHECK(failed.name == "failed_points");
  CHECK(std::get<std::vector<std::int64_t>>(failed.column("point").values) == std::vector<std::int64_t>{1, 3, 4});
  CHECK(std::get<std::vector<double>>(failed.column("other").values) == std::vector<double>{2, 4, 5});
  const std::vector<double> map = r.streams.at(0).values(0, 9).at(0);
  CHECK((std::isfinite(map[2]) && std::isnan(map[3]) && std::isnan(map[5]) && std::isfinite(map[6])));
}

TEST_CASE("A large sweep with invalid points among those that are tried runs in one go as in parts") {
  const Experiment failing = {
      random::StudyId::none, "", "", [](config::ConfigReader& c, random::StudySeed seed) -> std::unique_ptr<PointPlan> {
        c.integer("trials", 0, 1'000'000, "");
        const auto other = static_cast<std::uint64_t>(c.integer("other", 3, 1'000'000, ""));
        c.finish();
        return std::make_unique<CountedPlan>(Scenario{seed, 4, other % kPoints, c.place("other")});
      }};
  constexpr int kMost = kMostReadWhole;
  const RunPlan run = read_run(failing, large_sweep(1, 1 + kMost));
  CHECK(run.sample.points > 1000);
  CHECK(run.sample.invalid == 1);  // of the two that are invalid, which is not tried is not known before the run
  CHECK(run.sample.first_reason == "t.toml:5: other = 1: must be in [3, 1000000]");
  CHECK(run.total_trials() == 4 * (kMostReadWhole + 1));
  const store::Result whole = execute(run, {});
  CHECK(whole.provenance.trials == 4);
  CHECK(whole.tables.at(0).name == "failed_points");
  PartFiles files;
  for (const std::uint64_t first : {0, 5000})
    files.add(run_part(open_run(failing, large_sweep(1, 1 + kMost)),
                       {checkpoint::PointRange{first, first == 0 ? 5000 : kMostReadWhole + 1, 1}}, {}, {}));
  const store::Result parts = merged(open_run(failing, large_sweep(1, 1 + kMost)), files);
  CHECK(parts.provenance.trials == 4);
  CHECK(store::content_hash(parts) == store::content_hash(whole));

  CHECK(read_run(failing, large_sweep(3, 3 + kMost)).sample.invalid == 0);
  CHECK_THROWS_WITH(read_run(failing, large_sweep(-kMost, 0)), "t.toml:5: other = -10000: must be in [3, 1000000]");
}

TEST_CASE("Streams of a result outlive the plan") {
  const store::Result r = [] { return execute(task(0), {}); }();
  // points behind each other, three values each
  CHECK(r.streams.at(0).values(2, 2) == std::vector<std::vector<double>>{{2, 1}});
}

TEST_CASE("A value that only computing shows to be wrong is named with its place and point") {
  const RunPlan run = task(13);
  CHECK_NOTHROW(check_choice(run, PartChoice::of_point(2)));
  try {
    run.prepare(2, {});
    FAIL("must throw");
  } catch (const InputError& e) {
    CHECK_THAT(e.what(), StartsWith("t.toml:5: number = 2: what only computing shows"));
    CHECK_THAT(e.what(), EndsWith("(point 2 of the sweep)"));
  }
  forget();
  const RunPlan one = read_run(counted(), config_of(13, "[3]"));
  CHECK_THROWS_WITH(one.prepare(0, {}), !Contains("point"));
}

TEST_CASE("Tallies of another preparation are refused by name") {
  class Proposed final : public StudyPoint {
   public:
    std::uint64_t proposal() const override { return 5; }
    PointResult report(const stats::Tally&, const montecarlo::RunOptions&) const override { return {}; }
  };
  stats::Tally tally;
  require_proposal(Proposed(), tally, "a part");  // all of its trials have failed: no weights
  tally.proposal = 5;
  require_proposal(Proposed(), tally, "a part");
  tally.proposal = 7;
  CHECK_THROWS_AS(require_proposal(Proposed(), tally, "a part"), IoError);
  CHECK_THROWS_WITH(require_proposal(Proposed(), tally, "a part"),
                    StartsWith("a part: ") && Contains("another preparation (0000000000000007)"));
}

TEST_CASE("A part of another preparation is refused by the name of its file") {
  forget();
  const RunPlan run = read_run(counted(), config_of(1024));
  const checkpoint::PartPiece piece{
      .blocks = {0, 2}, .blocks_in_all = 2, .subtrees = {{0, 0, {.proposal = 7}}}, .file = "shard_1.part"};
  CHECK_THROWS_WITH(merged_point(run, 0, {piece}, {}),
                    StartsWith("shard_1.part: blocks 0 to 1 of point 0: ") && Contains("another preparation"));
}

TEST_CASE("Tallies of other sizes than a trial's are refused by the name of their file, before they are read") {
  forget();
  const RunPlan run = read_run(counted(), config_of(1024));
  const auto tally_of = [](int quantities, std::uint64_t trials) -> stats::Tally {
    return {.trials = trials, .moments = stats::Moments::of(Eigen::MatrixXd::Ones(2, quantities))};
  };
  const std::string says = "its tallies have other sizes";
  for (const int quantities : {0, 2}) {  // a part of one point that is whole; and one of half of its blocks
    const std::uint64_t trials = 512;
    checkpoint::PartPiece whole{0, {0, 2}, 2, true, {{0, 0, tally_of(quantities, 2 * trials)}}},
        half{0, {0, 1}, 2, false, {{0, 0, tally_of(quantities, trials)}}},
        other{0, {1, 2}, 2, false, {{0, 1, tally_of(quantities, trials)}}};
    whole.file = half.file = other.file = "a.part";
    CHECK_THROWS_WITH(merged_point(run, 0, {whole}, {}), StartsWith("a.part: ") && Contains(says));
    CHECK_THROWS_WITH(merged_point(run, 0, {half, other}, {}), StartsWith("a.part: ") && Contains(says));
  }
  checkpoint::PartPiece right{0, {0, 2}, 2, true, {{0, 0, tally_of(1, 1024)}}};
  CHECK(merged_point(run, 0, {right}, {}).tables.size() == 1);

  Checkpoint checkpoint;
  checkpoint.finished[0].push_back({0, 1, tally_of(2, 512)});
  CHECK_THROWS_WITH(point_tally(run, 0, *run.prepare(0, {}), {}, checkpoint),
                    StartsWith("a journal") && Contains(says));
}

TEST_CASE("A journal of another preparation is refused by its name, by whole runs and by shards") {
  forget();
  const RunPlan run = read_run(counted(), config_of(1024));
  Checkpoint checkpoint;
  checkpoint.finished[0].emplace_back().tally.proposal = 7;
  checkpoint.drawn_in[{0, 7}] = "out.h5.journal.host.1";
  const std::string says = "out.h5.journal.host.1: its trials were drawn from another preparation (0000000000000007)";
  CHECK_THROWS_WITH(point_tally(run, 0, *run.prepare(0, {}), {}, checkpoint), StartsWith(says));
  CHECK_THROWS_WITH(run_part(run, {{}, 0, 2}, {}, checkpoint), StartsWith(says));
}

TEST_CASE("A stop flag is looked at between points") {
  std::atomic<bool> stop = true;
  forget();
  CHECK_THROWS_AS(read_run(counted(), config_of(2000), &stop), Interrupted);
  CHECK(g_read == 0);
  const RunPlan run = task(0);
  const montecarlo::RunOptions options{.stop = &stop};
  CHECK_THROWS_AS(execute(run, options), Interrupted);
  CHECK_THROWS_AS(run_part(run, PartChoice::of_point(1), options, {}), Interrupted);
  CHECK(prepared() == Times{});
}

TEST_CASE("Units are read from names") {
  CHECK(unit_of_name("field.total_nT") == "nT");
  CHECK(unit_of_name("noise.scale") == "1");
  CHECK(unit_of_name("md_ft") == "ft");
  CHECK(unit_of_name("m") == "1");
  CHECK(unit_of_name("gain_x") == "1");
}
