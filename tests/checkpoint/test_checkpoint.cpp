#include <filesystem>
#include <random>

#include <unistd.h>
#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "checkpoint/journal.h"
#include "checkpoint/part_file.h"
#include "file_bytes.h"
#include "montecarlo/run_blocks.h"
#include "normal_draws.h"
#include "stats/tally_bytes.h"
#include "temporary_folder.h"

using namespace surveymc;
using namespace surveymc::checkpoint;
namespace fs = std::filesystem;

namespace {

stats::Tally kernel(montecarlo::TrialBlock block) {
  const Eigen::MatrixXd x = test::normal_draws(random::Stream(7, 0), block.first, block.count, 3);
  return {.trials = static_cast<std::uint64_t>(block.count),
          .failed = block.first % 3,
          .left_out = 2,
          .moments = stats::Moments::of(x),
          .groups = {stats::Moments::of(x.leftCols(2)), stats::Moments::of(x.rightCols(1))},
          .controlled = {stats::Moments::of(x)},
          .pairs = stats::Moments::of(x.topRows(block.count / 2)),
          .controlled_pairs = {stats::Moments(2)},
          .counts = {block.first, 1, 2},
          .failed_trials = {block.first + 1},
          .samples = {static_cast<double>(block.first), -0.0, 1e-310}};
}

/// All of a tally's state takes part in its bytes.
std::string bits(const stats::Tally& t) { return stats::tally_to_bytes(t); }

struct Folder : TemporaryFolder {
  fs::path output() const { return path / "out.h5"; }
};

const RunKey kKey{"0123456789abcdef", "this build"};

}  // namespace

TEST_CASE("A tally comes back from its bytes with all of its state", "[checkpoint]") {
  const stats::Tally tally = montecarlo::run_blocks(3000, kernel, {2});
  const stats::Tally again = stats::tally_from_bytes(stats::tally_to_bytes(tally));
  CHECK(bits(again) == bits(tally));
  CHECK(again.moments.squares == tally.moments.squares);
  CHECK(again.groups.size() == 2);
  CHECK(again.groups[1].fourths == tally.groups[1].fourths);
  CHECK(again.controlled_pairs[0].count == tally.controlled_pairs[0].count);
  CHECK(std::signbit(again.samples[1]));
  CHECK(again.left_out == tally.left_out);
  CHECK(bits(stats::tally_from_bytes(stats::tally_to_bytes(stats::Tally{}))) == bits(stats::Tally{}));
}

TEST_CASE("Bytes of a tally that are cut or have wrong lengths are refused, not believed", "[checkpoint]") {
  const std::string bytes = stats::tally_to_bytes(kernel({0, 20}));
  for (std::size_t n = 0; n < bytes.size(); ++n) CHECK_THROWS_AS(stats::tally_from_bytes(bytes.substr(0, n)), IoError);
  CHECK_THROWS_AS(stats::tally_from_bytes(bytes + "x"), IoError);
  for (std::size_t i = 0; i < bytes.size(); ++i) {  // no crash, no huge allocation; numbers may change
    try {
      stats::tally_from_bytes(flipped(bytes, i, 0x80));
    } catch (const IoError&) {
    }
  }
}

TEST_CASE("A node that no tree has is refused", "[checkpoint]") {
  const std::string good = montecarlo::subtree_to_bytes({3, 5, kernel({0, 4})});
  CHECK(montecarlo::subtree_from_bytes(good).end_block() == 48);
  for (const char level : {'\x3f', '\x7f', '\xff'}) {
    std::string bad = good;
    bad[level == '\xff' ? 3 : 0] = level;  // 63, 127, negative
    CHECK_THROWS_AS(montecarlo::subtree_from_bytes(bad), IoError);
  }
}

TEST_CASE("Every flipped byte of a record is found", "[checkpoint]") {
  const std::string bytes = sealed_record("SMCTEST1", "some body");
  REQUIRE(record_at(bytes, 0, "SMCTEST1"));
  CHECK(record_at(bytes, 0, "SMCTEST1")->body == "some body");
  for (std::size_t i = 0; i < bytes.size(); ++i) CHECK_FALSE(record_at(flipped(bytes, i, 1), 0, "SMCTEST1"));
}

TEST_CASE("Any finished subtrees and any shards give the bits of one run", "[checkpoint]") {
  constexpr std::uint64_t kTrials = 20001;
  const std::uint64_t blocks = montecarlo::all_blocks(kTrials).end;
  const std::string whole = bits(montecarlo::run_blocks(kTrials, kernel, {2}));
  std::mt19937 g(1);
  for (int rep = 0; rep < 20; ++rep) {
    std::vector<montecarlo::Subtree> kept;  // nested ones, too
    for (int k = 0; k < 4; ++k) {
      montecarlo::OrderedMerge some;
      for (std::uint64_t b = 0; b < blocks; ++b)
        if (g() % 3 > 0)
          some.add(b, kernel({b * montecarlo::kBlockTrials,
                              static_cast<int>(std::min<std::uint64_t>(montecarlo::kBlockTrials,
                                                                       kTrials - b * montecarlo::kBlockTrials))}));
      for (montecarlo::Subtree& n : some.take()) kept.push_back(std::move(n));
    }
    CHECK(bits(montecarlo::run_blocks(kTrials, kernel, {3}, {}, kept)) == whole);
    const std::uint64_t cut = g() % (blocks + 1);
    montecarlo::OrderedMerge merge;
    for (const montecarlo::BlockRange r : {montecarlo::BlockRange{cut, blocks}, montecarlo::BlockRange{0, cut}})
      for (montecarlo::Subtree& n : montecarlo::run_block_range(kTrials, r, kernel, {2}, kept))
        merge.add(std::move(n), true);
    CHECK(bits(merge.whole()) == whole);
  }
}

TEST_CASE("A run that goes on behind a look ends where the first attempt would have", "[checkpoint]") {
  const montecarlo::StoppingRule rule{{1024, 4096, 10000},
                                      [](const stats::Tally& t) { return t.trials < 4096 ? 5000u : 4096u; }};
  const std::string whole = bits(montecarlo::run_blocks(100000, kernel, {1}, rule));
  for (const std::uint64_t stop_at : {600u, 1024u, 1500u, 3000u}) {
    std::vector<montecarlo::Subtree> kept;
    std::atomic<bool> stop = false;
    montecarlo::RunOptions options{2};
    options.stop = &stop;
    options.progress = [&](std::uint64_t done, std::uint64_t) { stop = done >= stop_at; };
    options.save = [&](montecarlo::OrderedMerge& m) {
      m.take_unsaved([&](const montecarlo::Subtree& s) { kept.push_back(s); });
    };
    CHECK_THROWS_AS(montecarlo::run_blocks(100000, kernel, options, rule), Interrupted);
    CHECK_FALSE(kept.empty());
    CHECK(bits(montecarlo::run_blocks(100000, kernel, {2}, rule, kept)) == whole);
  }
}

TEST_CASE("A journal gives back all but the record that is damaged, whatever byte it is", "[checkpoint]") {
  const Folder folder;
  {
    Journal journal(folder.output(), kKey, std::chrono::seconds(0));
    CHECK(journals_of(folder.output()).empty());  // nothing was added
    for (std::uint64_t b = 0; b < 3; ++b) journal.add(b, {0, b, kernel({b * montecarlo::kBlockTrials, 4})});
    REQUIRE(journal.sync());
  }
  REQUIRE(journals_of(folder.output()).size() == 1);
  const fs::path path = journals_of(folder.output())[0];
  const std::string bytes = bytes_of(path);
  const JournalContents whole = read_journals(folder.output(), kKey);
  CHECK(whole.finished.size() == 3);
  CHECK(whole.damaged.empty());
  CHECK(bits(whole.finished.at(2)[0].tally) == bits(kernel({2 * montecarlo::kBlockTrials, 4})));

  const std::size_t record = bytes.size() / 3;  // all have one size
  for (std::size_t i = 0; i < bytes.size(); i += 7) {
    write_bytes(path, flipped(bytes, i, 4));
    const JournalContents left = read_journals(folder.output(), kKey);
    CHECK(left.finished.size() == 2);  // those before and behind
    CHECK(left.finished.count(i / record) == 0);
    CHECK(left.damaged.size() == 1);
    write_bytes(path, bytes.substr(0, i));
    CHECK(read_journals(folder.output(), kKey).finished.size() == i / record);
  }
  write_bytes(path, bytes);
  CHECK_THROWS_WITH(read_journals(folder.output(), {"ffff", "this build"}), Catch::Contains("another config"));
  CHECK_THROWS_WITH(read_journals(folder.output(), {kKey.config_hash, "other"}), Catch::Contains("another build"));
  remove_journals(folder.output(), {"ffff", "this build"});
  CHECK(fs::exists(path));
  const RunKey other{kKey.config_hash, "another build; numerics 1, probe 0"},
      alike{kKey.config_hash, "this; numerics 1, probe 0"};
  {
    Journal journal(folder.output(), other, std::chrono::seconds(0));
    journal.add(0, {0, 0, kernel({0, 4})});
    REQUIRE(journal.sync());
  }
  CHECK_THROWS_WITH(read_journals(folder.output(), kKey), Catch::Contains("another build"));
  write_bytes(path, "");
  const JournalContents used = read_journals(folder.output(), alike);
  CHECK(used.finished.size() == 1);
  REQUIRE(journal_remarks(folder.output(), alike).notes.size() == 1);
  CHECK_THAT(journal_remarks(folder.output(), alike).notes[0], Catch::Contains("another build; numerics 1"));
  remove_journals(folder.output(), alike);
  CHECK(journals_of(folder.output()).empty());
  write_bytes(path, bytes);
  write_bytes(folder.path / "out.h5.journal.mine", "a user's notes");
  CHECK(journal_remarks(folder.output(), kKey).warnings.size() == 1);
  std::string later = bytes.substr(0, record);
  later = sealed_record("SMCJRNL2", record_at(later, 0, "SMCJRNL1")->body);
  write_bytes(path, later);
  CHECK_THROWS_WITH(read_journals(folder.output(), kKey), Catch::Contains("another version"));
  write_bytes(path, std::string(40, 'x'));  // by its name it is ours
  CHECK(read_journals(folder.output(), kKey).damaged.size() == 1);
  remove_journals(folder.output(), kKey);
  CHECK_FALSE(fs::exists(path));
  CHECK(fs::exists(folder.path / "out.h5.journal.mine"));
}

TEST_CASE("A record that is sealed, but cannot be read, is damage: the others count", "[checkpoint]") {
  const Folder folder;
  Journal journal(folder.output(), kKey, std::chrono::seconds(0));
  journal.add(0, {0, 0, kernel({0, 4})});
  REQUIRE(journal.sync());
  const fs::path path = journals_of(folder.output())[0];
  const std::string bytes = bytes_of(path), head(record_at(bytes, 0, "SMCJRNL1")->body.substr(0, 50));
  for (const std::string& body : {std::string("jj"), head, std::string()}) {
    write_bytes(path, sealed_record("SMCJRNL1", body) + bytes);
    const JournalContents left = read_journals(folder.output(), kKey);
    CHECK(left.finished.size() == 1);
    CHECK(left.damaged.size() == 1);
    CHECK(journal_remarks(folder.output(), kKey).notes.empty());
  }
  remove_journals(folder.output(), kKey);
  CHECK_FALSE(fs::exists(path));
}

TEST_CASE("A journal is known by the proposals of its trials", "[checkpoint]") {
  const Folder folder;
  const auto drawn = [](std::uint64_t proposal) {
    stats::Tally t = kernel({0, 4});
    t.proposal = proposal;
    return t;
  };
  Journal first(folder.output(), kKey, std::chrono::seconds(0));
  first.add(3, {0, 0, drawn(7)});
  first.add(3, {0, 1, drawn(0)});  // trials without weights are of every preparation
  REQUIRE(first.sync());
  const fs::path path = journals_of(folder.output())[0];
  const JournalContents kept = read_journals(folder.output(), kKey);
  CHECK(kept.finished.at(3).size() == 2);
  CHECK(kept.drawn_in == JournalsOfProposals{{{3, 7}, path}});
}

TEST_CASE("A part file comes back whole, or is called damaged", "[checkpoint]") {
  const Folder folder;
  const fs::path path = folder.path / "a.part";
  Part part;
  part.key = kKey;
  part.config = "seed = 1\n";
  part.inputs = {{"a.csv", {"md_m"}, {{1.0, 2.0}}, {2, 3}}};
  part.texts = {{"m.toml", "x = 1\n"}};
  part.references = {{"large.csv", 1 << 25, "abcd", "md_m"}};
  part.folder = "/somewhere";
  part.points = 4;
  part.range = {1, 4, 2};
  part.pieces = {{1, {2, 5}, 9, false, {{1, 1, kernel({1024, 512})}}}, {3, {0, 0}, 0, true, {}, "tables"}};
  write_part(path, part);
  const Part again = read_part(path);
  CHECK(again.range == part.range);
  CHECK(again.points == 4);
  CHECK(again.key == part.key);
  CHECK(again.inputs[0].columns == part.inputs[0].columns);
  CHECK(again.texts[0].text == "x = 1\n");
  CHECK(again.references[0].path == "large.csv");
  CHECK(again.references[0].size == 1 << 25);
  CHECK(again.references[0].hash == "abcd");
  CHECK(again.references[0].header == "md_m");
  CHECK(again.folder == "/somewhere");
  CHECK(again.pieces[0].subtrees[0].end_block() == 4);
  CHECK(bits(again.pieces[0].subtrees[0].tally) == bits(part.pieces[0].subtrees[0].tally));
  CHECK(again.pieces[1].result == "tables");
  const PartHead head = read_part_head(path);
  CHECK(head.run == run_bytes(kKey));
  CHECK(head.run != run_bytes({kKey.config_hash, "another build"}));
  CHECK((head.points == 4 && head.range == part.range && head.shards == 1 && !head.whole && !head.failed));
  PartReader reader(path);
  CHECK(reader.pieces().at(0).blocks_in_all == 9);
  CHECK(reader.piece(1).result == "tables");
  reader.close();
  CHECK(reader.about().config == "seed = 1\n");
  // Pieces of another part, as they are
  write_part_of(folder.path / "b.part", part, reader.pieces(), [&](std::size_t i) { return reader.piece_bytes(i); });
  CHECK(bytes_of(folder.path / "b.part") == bytes_of(path));

  const std::string bytes = bytes_of(path);
  const auto open_files = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const auto open_before = open_files();
  for (std::size_t i = 0; i < bytes.size(); i += 5) {  // whatever byte it is
    write_bytes(path, flipped(bytes, i, 1));
    CHECK_THROWS_AS(read_part(path), surveymc::IoError);
    CHECK(open_files() == open_before);
    if (i > 7) CHECK(part_state(path) == PartState::damaged);
    write_bytes(path, bytes.substr(0, i));
    CHECK_THROWS_AS(read_part_head(path), surveymc::IoError);
  }
  write_bytes(path, bytes + "more");
  CHECK_THROWS_WITH(read_part_head(path), Catch::Contains("damaged"));
  write_bytes(path, "SMCPART2 of an older version");
  CHECK(part_state(path) == PartState::damaged);
  CHECK_THROWS_WITH(read_part(path), Catch::Contains("another version"));
  write_bytes(path, "hello");
  CHECK(part_state(path) == PartState::foreign);
}
