#include <catch2/catch.hpp>

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/units.h"
#include "file_bytes.h"
#include "message_of.h"
#include "render/csv.h"
#include "store/atomic_file.h"
#include "store/result_file.h"
#include "store/row_spool.h"
#include "store/seal.h"
#include "temporary_folder.h"

using namespace surveymc;
using namespace surveymc::store;
namespace fs = std::filesystem;
using Catch::Matchers::Contains;

namespace {

using Numbers = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

constexpr double kInf = std::numeric_limits<double>::infinity();

struct Folder : TemporaryFolder {
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(path)) out.push_back(entry.path().filename().string());
    return out;
  }
};

/// Everything that a result can hold.
Result full_result() {
  Result r;
  r.provenance = {"Reliability of σ",
                  "msa_position",
                  "# größer\nseed = 7\n[survey]\nfile = \"traj3.csv\"\n" + std::string(70000, '#'),  // beyond 64 kB
                  "0123456789abcdef",
                  std::numeric_limits<std::int64_t>::max(),
                  20000,
                  "0.1.0",
                  "abc1234",
                  "g++ 12",
                  "surveymc run thesis3.toml"};
  r.run = {"2024-05-06T07:08:09Z", "node1", 12.5, 8, 2};
  r.tables = {
      {"position",
       "position errors",
       {{"noise.scale", "1", "sweep: noise.scale", Numbers{1, 1, 0.1}},
        {"quantity", "", "what", Texts{"north_m", "", "Ω · \"x\", °"}},
        {"sd", "m", "standard deviation", Numbers{1.0 / 3, kNaN, kInf}, "sd_ci_low sd_ci_high"},
        {"sd_ci_low", "m", "lower end", Numbers{0.3, kNaN, 0}},
        {"sd_ci_high", "m", "upper end", Numbers{0.4, kNaN, kInf}},
        {"trials", "1", "trials", Integers{20000, 0, std::numeric_limits<std::int64_t>::min()}}}},
      {"a_later_table_with_an_earlier_name", "", {{"z", "1", "z", Numbers{1}}, {"a", "1", "a", Numbers{2}}}},
      {"nothing", "no rows", {{"sd", "m", "sd", Numbers{}}, {"n", "1", "n", Integers{}}, {"s", "", "s", Texts{}}}}};
  r.samples = {{"position", "first realisations", {{"north_m", "m", "north", Numbers{1, 2, 3, 4}}}}};
  const Axis inclination{"inclination", "deg", "inclination", Numbers{0, 45, 90}};
  const Axis toolface{"toolface", "deg", "toolface", Numbers{0, 180}};
  const Axis cases{"case", "", "sweep case", Texts{"größer", "b"}};
  r.maps = {{"minimal_detectable_error", "nT", "MDE", {inclination, toolface}, {1, kInf, 3, -kInf, kNaN, 6}},
            {"redundancy_number", "1", "redundancy", {cases, inclination}, {1, 2, 3, 4, 5, 6}},
            {"coarse",
             "1",
             "other values on an axis of the same name",
             {{"inclination", "deg", "inclination", Numbers{0, 90}}},
             {1, 2}},
            {"square", "1", "one axis twice", {toolface, toolface}, {1, 2, 3, 4}},
            {"condition", "1", "a single value", {}, {42}}};
  const Table survey{"traj3",
                     "survey",
                     {{"md_m", "m", "measured depth", Numbers{0, 30}},
                      {"row", "1", "", Numbers{1, 2}},
                      {"Inc/°", "deg", "", Numbers{3, 4}}}};
  r.inputs = {{"data/traj 3.csv", input_hash(survey), survey}, {"other/traj_3.csv", input_hash(survey), survey}};
  return r;
}

/// One table with one value.
Result result_of(double value) { return {.tables = {{"t", "", {{"x", "1", "", Numbers{value}}}}}}; }

/// The bytes of a number.
std::string raw(double x) {
  const auto bits = std::bit_cast<std::array<char, sizeof x>>(x);
  return {bits.begin(), bits.end()};
}

void check_equal(const Column& a, const Column& b) {
  INFO("column " << b.name);
  CHECK(a.name == b.name);
  CHECK(a.unit == b.unit);
  CHECK(a.long_name == b.long_name);
  CHECK(a.ancillary == b.ancillary);
  REQUIRE(a.values.index() == b.values.index());
  REQUIRE(a.size() == b.size());
  if (const auto* numbers = std::get_if<Numbers>(&a.values)) {
    const auto& expected = std::get<Numbers>(b.values);
    for (std::size_t i = 0; i < a.size(); ++i) {
      CHECK(std::bit_cast<std::uint64_t>((*numbers)[i]) == std::bit_cast<std::uint64_t>(expected[i]));
    }
  } else {
    CHECK(a.values == b.values);
  }
}
void check_equal(const Table& a, const Table& b, bool with_name = true) {
  INFO("table " << b.name);
  if (with_name) CHECK(a.name == b.name);
  CHECK(a.long_name == b.long_name);
  REQUIRE(a.columns.size() == b.columns.size());
  for (std::size_t i = 0; i < a.columns.size(); ++i) check_equal(a.columns[i], b.columns[i]);
}
void check_equal(const Map& a, const Map& b) {
  check_equal({a.name, a.unit, a.long_name, a.values}, Column{b.name, b.unit, b.long_name, b.values});
  REQUIRE(a.axes.size() == b.axes.size());
  for (std::size_t i = 0; i < a.axes.size(); ++i) {
    CHECK(a.axes[i].name == b.axes[i].name);
    CHECK(a.axes[i].unit == b.axes[i].unit);
    CHECK(a.axes[i].long_name == b.axes[i].long_name);
    CHECK(a.axes[i].values == b.axes[i].values);
  }
}

template <class T>
void check_equal(const std::vector<T>& a, const std::vector<T>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) check_equal(a[i], b[i]);
}

constexpr std::size_t kSealSize = 24;

/// Replaces text in the file by one of the same length. Takes the seal off, or it would be the seal that fails.
void patch(const fs::path& path, const std::string& from, const std::string& to) {
  std::string bytes = bytes_of(path);
  const auto at = bytes.find(from);
  REQUIRE(at != std::string::npos);
  REQUIRE(from.size() == to.size());
  bytes.replace(at, from.size(), to);
  write_bytes(path, bytes.substr(0, bytes.size() - kSealSize));
}

/// A whole HDF5 file of someone else: ours, with another format name.
void write_foreign_hdf5(const fs::path& path) {
  const std::string eight("\x08\0\0\0\0\0\0\0", 8);  // the length that HDF5 puts before the text
  write_result(path, full_result());
  patch(path, eight + "surveymc", eight + "otherone");
}

/// What the IoError of `call` says if no file may grow beyond `bytes`: a disk that fills up, as far as write() tells.
std::string error_on_full_disk(rlim_t bytes, const std::function<void()>& call) {
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit limit{bytes, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string message = message_of<IoError>(call);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  return message;
}

}  // namespace

TEST_CASE("What is written is read back: values to the bit, names, units and order") {
  const Folder folder;
  const Result r = full_result();
  write_result(folder / "r.h5", r);
  const Result back = read_result(folder / "r.h5");

  for (const auto text :
       {&Provenance::title, &Provenance::experiment, &Provenance::config, &Provenance::config_hash,
        &Provenance::surveymc_version, &Provenance::git_revision, &Provenance::compiler, &Provenance::command})
    CHECK(back.provenance.*text == r.provenance.*text);
  CHECK(back.provenance.seed == r.provenance.seed);
  CHECK(back.provenance.trials == r.provenance.trials);
  CHECK(back.run.created == r.run.created);
  CHECK(back.run.host == r.run.host);
  CHECK(back.run.elapsed_s == r.run.elapsed_s);
  CHECK(back.run.threads == r.run.threads);
  CHECK(back.run.ranks == r.run.ranks);
  check_equal(back.tables, r.tables);
  check_equal(back.samples, r.samples);
  check_equal(back.maps, r.maps);
  REQUIRE(back.inputs.size() == r.inputs.size());
  for (std::size_t i = 0; i < r.inputs.size(); ++i) {
    CHECK(back.inputs[i].path == r.inputs[i].path);
    CHECK(back.inputs[i].hash == r.inputs[i].hash);
    check_equal(back.inputs[i].table, r.inputs[i].table, false);
  }
  CHECK(back.inputs[0].table.name == "traj_3");
  CHECK(back.inputs[1].table.name == "traj_3_2");

  CHECK(content_hash(back) == content_hash(r));
  CHECK(stored_content_hash(folder / "r.h5") == content_hash(r));
  CHECK(folder.names() == std::vector<std::string>{"r.h5"});
}

TEST_CASE("A result without any table is a result") {
  const Folder folder;
  write_result(folder / "r.h5", {});
  const Result back = read_result(folder / "r.h5");
  CHECK(back.tables.empty());
  CHECK(back.maps.empty());
}

TEST_CASE("The same result gives the same bytes, read back and written again too") {
  const Folder folder;
  write_result(folder / "a.h5", full_result());
  sleep(1);  // a time stamp of one second would show
  write_result(folder / "b.h5", full_result());
  write_result(folder / "c.h5", read_result(folder / "a.h5"));
  CHECK(bytes_of(folder / "a.h5") == bytes_of(folder / "b.h5"));
  CHECK(bytes_of(folder / "a.h5") == bytes_of(folder / "c.h5"));
}

TEST_CASE("The content hash sees data, config and inputs, and not how or where the run went") {
  const std::string hash = content_hash(full_result());
  CHECK(hash.size() == 32);
  const auto changed = [](const std::function<void(Result&)>& change) {
    Result r = full_result();
    change(r);
    return content_hash(r);
  };
  CHECK(changed([](Result& r) { r.run = {"now", "elsewhere", 1, 64, 4}; }) == hash);
  CHECK(changed([](Result& r) { r.provenance.command = "surveymc rerun r.h5"; }) == hash);
  CHECK(changed([](Result& r) { r.provenance.surveymc_version = "9"; }) == hash);
  CHECK(changed([](Result& r) { r.provenance.git_revision = "fff"; }) == hash);
  CHECK(changed([](Result& r) { r.provenance.compiler = "clang"; }) == hash);
  CHECK(changed([](Result& r) { r.inputs[0].table.name = "renamed"; }) == hash);

  CHECK(changed([](Result& r) { r.provenance.config += " "; }) != hash);
  CHECK(changed([](Result& r) { r.provenance.seed = 8; }) != hash);
  CHECK(changed([](Result& r) { r.provenance.trials = 8; }) != hash);
  CHECK(changed([](Result& r) { r.inputs[0].hash = "0"; }) != hash);
  CHECK(changed([](Result& r) { std::swap(r.tables[0], r.tables[1]); }) != hash);
  CHECK(changed([](Result& r) { r.tables[0].columns[2].unit = "ft"; }) != hash);
  CHECK(changed([](Result& r) { std::swap(r.samples, r.tables); }) != hash);
  CHECK(changed([](Result& r) { std::get<Texts>(r.tables[0].columns[1].values)[1] = "x"; }) != hash);
  CHECK(changed([](Result& r) { std::get<Integers>(r.tables[0].columns[5].values)[1] = 1; }) != hash);
  CHECK(changed([](Result& r) { r.maps[0].values[5] = std::nextafter(6.0, 7.0); }) != hash);
  CHECK(changed([](Result& r) { std::get<Numbers>(r.maps[0].axes[0].values)[1] = 46; }) != hash);
  CHECK(changed([](Result& r) { std::get<Numbers>(r.inputs[1].table.columns[0].values)[1] = 31; }) != hash);
}

TEST_CASE("All NaNs are one missing value, in the hash and in the file") {
  const Folder folder;
  const double other_nan = std::bit_cast<double>(0xFFF8000000000123u);
  Result a = full_result(), b = full_result();
  std::get<Numbers>(b.tables[0].columns[2].values)[1] = other_nan;
  b.maps[0].values[4] = other_nan;
  CHECK(content_hash(a) == content_hash(b));
  write_result(folder / "a.h5", a);
  write_result(folder / "b.h5", b);
  CHECK(bytes_of(folder / "a.h5") == bytes_of(folder / "b.h5"));
}

TEST_CASE("The hash of an input depends on names, units and values") {
  const Table t{"t", "", {{"md_m", "m", "", Numbers{1, 2}}}};
  const auto hash = input_hash(t);
  CHECK(hash.size() == 32);
  CHECK(input_hash({"u", "long", {{"md_m", "m", "long", Numbers{1, 2}}}}) == hash);
  CHECK(input_hash({"t", "", {{"md_ft", "m", "", Numbers{1, 2}}}}) != hash);
  CHECK(input_hash({"t", "", {{"md_m", "ft", "", Numbers{1, 2}}}}) != hash);
  CHECK(input_hash({"t", "", {{"md_m", "m", "", Numbers{1, -2}}}}) != hash);
  CHECK(input_hash({"t", "", {{"md_m", "m", "", Numbers{1}}, {"md_m", "m", "", Numbers{2}}}}) != hash);
}

TEST_CASE("Bytes that are not UTF-8 are stored as replacement characters, with the hash of those") {
  const Folder folder;
  Result r;
  r.tables = {
      {"t",
       "",
       {{"s", "", "", Texts{"Inc [\xB0]", std::string("a\0b", 3), "\xED\xA0\x80", "\xC0\xAF", "\xF0\x9F\x98\x80"}}}}};
  r.inputs = {{"traj\xE9.csv", "", {"", "", {{"Inc [\xB0]", "", "", Numbers{1}}}}}};
  write_result(folder / "r.h5", r);
  const Result back = read_result(folder / "r.h5");
  const std::string bad = "\xEF\xBF\xBD";
  CHECK(std::get<Texts>(back.tables[0].columns[0].values) ==
        Texts{"Inc [" + bad + "]", "a" + bad + "b", bad + bad + bad, bad + bad, "\xF0\x9F\x98\x80"});
  CHECK(back.inputs[0].table.columns[0].name == "Inc [" + bad + "]");
}

TEST_CASE("Users' column names that HDF5 cannot hold come back as they were") {
  const Folder folder;
  const Texts names = {"", ".", "a/b", "a_b", "a/b", "row", "/", " blank ", "Inc (°)"};
  Result r{.inputs = {{"", "", {}}, {"...", "", {}}}};
  for (const std::string& name : names) r.inputs[0].table.columns.push_back({name, "", "", Numbers{1}});
  write_result(folder / "r.h5", r);
  const Result back = read_result(folder / "r.h5");
  REQUIRE(back.inputs[0].table.columns.size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) CHECK(back.inputs[0].table.columns[i].name == names[i]);
}

TEST_CASE("A malformed result is a bug, found before a file is touched") {
  const Folder folder;
  const Result ragged{.tables = {{"t", "", {{"a", "1", "", Numbers{1}}, {"b", "1", "", Numbers{1, 2}}}}}};
  const Result twice{.tables = {{"t", ""}, {"t", ""}}};
  const Result slash{.maps = {{"a/b", "1", "", {}, {1}}}};
  const Result not_a_product{.maps = {{"m", "1", "", {{"x", "1", "", Numbers{1, 2}}}, {1, 2, 3}}}};
  for (const Result& r : {ragged, twice, slash, not_a_product}) {
    CHECK_THROWS_AS(write_result(folder / "r.h5", r), std::logic_error);
  }
  CHECK(folder.names().empty());
}

TEST_CASE("A disk that fills up leaves the old file and no temporary one") {
  const Folder folder;
  write_result(folder / "r.h5", {.provenance = {.title = "old"}});
  const std::string before = bytes_of(folder / "r.h5");

  for (const rlim_t limit : {0, 1, 1000, 8192, 60000}) {  // the new file is larger than each
    CHECK_THAT(error_on_full_disk(limit, [&] { write_result(folder / "r.h5", full_result()); }),
               Contains("r.h5: cannot be written: ") && Contains("File too large"));
    CHECK(bytes_of(folder / "r.h5") == before);
    CHECK(folder.names() == std::vector<std::string>{"r.h5"});
  }
  write_result(folder / "r.h5", full_result());
  CHECK(read_result(folder / "r.h5").provenance.title == full_result().provenance.title);
}

TEST_CASE("A folder without room is refused before anything is computed") {
  const Folder folder;
  CHECK_THAT(error_on_full_disk(0, [&] { check_output_path(folder / "r.h5"); }),
             Contains("cannot write into the folder"));
  CHECK(folder.names().empty());
}

TEST_CASE("A writer killed at any moment leaves the old file or the new one, whole") {
  const Folder folder;
  Result a = full_result(), b = full_result();
  a.provenance.title = "a";
  b.provenance.title = "b";
  write_result(folder / "r.h5", a);
  for (int i = 0; i < 30; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      for (;;) {
        write_result(folder / "r.h5", b);
        write_result(folder / "r.h5", a);
      }
    }
    REQUIRE(child > 0);
    usleep(static_cast<useconds_t>(2000 + 733 * i));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string title = read_result(folder / "r.h5").provenance.title;
    CHECK((title == "a" || title == "b"));
    check_output_path(folder / "r.h5");  // the next start cleans up
    CHECK(folder.names() == std::vector<std::string>{"r.h5"});
  }
}

TEST_CASE("check_output_path accepts a new file and an old result, and creates nothing") {
  const Folder folder;
  check_output_path(folder / "new.h5");
  CHECK(folder.names().empty());
  write_result(folder / "old.h5", full_result());
  const std::string before = bytes_of(folder / "old.h5");
  check_output_path(folder / "old.h5");
  CHECK(bytes_of(folder / "old.h5") == before);
  CHECK(folder.names().size() == 1);
}

TEST_CASE("check_output_path says why a file cannot be written") {
  const Folder folder;
  const auto message = [](const fs::path& path) { return message_of<IoError>([&] { check_output_path(path); }); };
  CHECK_THAT(message(folder / "missing/r.h5"), Contains("missing does not exist"));
  CHECK_THAT(message(folder.path), Contains("is a folder"));
  CHECK_THAT(message(folder.path.string() + "/"), Contains("is a folder"));
  write_bytes(folder / "file", "x");
  CHECK_THAT(message(folder / "file/r.h5"), Contains("is not a folder"));
  CHECK_THAT(message("/proc/r.h5"), Contains("/proc"));
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  CHECK_THAT(message(folder / "pipe"), Contains("not a surveymc result"));  // and does not wait for a writer
}

TEST_CASE("A file that is not ours is never overwritten") {
  const Folder folder;
  const std::string toml = "experiment = \"msa_position\"\n";
  write_bytes(folder / "x.toml", toml);
  write_bytes(folder / "empty.h5", "");
  write_foreign_hdf5(folder / "foreign.h5");

  for (const std::string name : {"x.toml", "empty.h5", "foreign.h5"}) {
    const std::string before = bytes_of(folder / name);
    const std::string rule =
        (folder / name).string() +
        ": exists and is not a surveymc result: refusing to overwrite it; choose another name with -o";
    CHECK(message_of<IoError>([&] { check_output_path(folder / name); }) == rule);
    CHECK(message_of<IoError>([&] { write_result(folder / name, full_result()); }) == rule);
    CHECK(bytes_of(folder / name) == before);
  }
  CHECK(folder.names().size() == 3);
}

TEST_CASE("A result is written to where a symbolic link points") {
  const Folder folder;
  fs::create_directory(folder / "store");
  write_result(folder / "store/r.h5", {});
  fs::create_symlink("store/r.h5", folder / "latest.h5");
  check_output_path(folder / "latest.h5");
  write_result(folder / "latest.h5", full_result());
  CHECK(fs::is_symlink(folder / "latest.h5"));
  CHECK(stored_content_hash(folder / "store/r.h5") == content_hash(full_result()));

  fs::create_symlink("store/next.h5", folder / "next.h5");  // points to nothing yet
  check_output_path(folder / "next.h5");
  write_result(folder / "next.h5", full_result());
  CHECK(fs::is_symlink(folder / "next.h5"));
  CHECK(stored_content_hash(folder / "store/next.h5") == content_hash(full_result()));

  fs::create_symlink("nowhere/r.h5", folder / "lost.h5");
  CHECK(message_of<IoError>([&] { check_output_path(folder / "lost.h5"); }).find("does not exist") !=
        std::string::npos);
  fs::create_symlink("ring.h5", folder / "ring.h5");  // leads nowhere
  CHECK_THAT(message_of<IoError>([&] { check_output_path(folder / "ring.h5"); }), Contains("cannot be looked at"));
  CHECK_THAT(message_of<IoError>([&] { write_result(folder / "ring.h5", full_result()); }),
             Contains("cannot be looked at"));
  CHECK(fs::is_symlink(folder / "ring.h5"));
}

TEST_CASE("An axis name of any length comes back") {
  const Folder folder;
  const Result r{
      .maps = {{"m", "1", "a map", {{std::string(700, 'a'), "deg", "an axis", std::vector<double>{1, 2}}}, {3, 4}}}};
  write_result(folder / "r.h5", r);
  CHECK(read_result(folder / "r.h5").maps[0].axes[0].name == r.maps[0].axes[0].name);
}

TEST_CASE("An end without destructors removes all temporary files, and no file that has its name") {
  const Folder folder;
  AtomicFile first(folder / "a"), committed(folder / "b");
  committed.write(std::vector<char>(10));
  committed.commit(OldFile::replaced);
  { const AtomicFile gone(folder / "c"); }  // not in the list any more
  const AtomicFile last(folder / "d");
  AtomicFile::remove_all();
  CHECK_FALSE(std::filesystem::exists(first.temporary_path()));
  CHECK_FALSE(std::filesystem::exists(last.temporary_path()));
  CHECK(std::filesystem::file_size(folder / "b") == 10);
}

TEST_CASE("Temporary files of dead writers go, those of others stay") {
  const Folder folder;
  const std::string stale = ".r.h5.0123456789abcdef.tmp";
  AtomicFile living(folder / "r.h5");
  const std::vector<std::string> kept = {
      living.temporary_path().filename().string(),
      ".other.h5.0123456789abcdef.tmp",  // another result
      ".r.h5.0123456789abcdeX.tmp",      // not ours
      ".r.h5.0123456789abcde.tmp",
      ".r.h5..tmp",
      "r.h5.tmp",
  };
  write_bytes(folder / stale, "half");
  for (const std::string& name : kept) write_bytes(folder / name, "half");

  check_output_path(folder / "r.h5");
  CHECK_FALSE(fs::exists(folder / stale));
  for (const std::string& name : kept) {
    INFO(name);
    CHECK(fs::exists(folder / name));
  }
}

TEST_CASE("A result that is replaced keeps its mode") {
  const Folder folder;
  write_result(folder / "r.h5", full_result());
  for (const fs::perms mode : {fs::perms(0640), fs::perms(0664), fs::perms(0600)}) {
    fs::permissions(folder / "r.h5", mode);
    write_result(folder / "r.h5", full_result());
    CHECK(fs::status(folder / "r.h5").permissions() == mode);
  }
}

TEST_CASE("A dead writer's temporary file goes when the next result is written") {
  const Folder folder;
  const pid_t writer = fork();
  if (writer == 0) {
    AtomicFile file(folder / "r.h5");
    kill(getpid(), SIGKILL);
  }
  REQUIRE(writer > 0);
  waitpid(writer, nullptr, 0);
  REQUIRE(folder.names().size() == 1);
  check_output_path(folder / "r.h5");
  write_result(folder / "r.h5", full_result());
  CHECK(folder.names() == std::vector<std::string>{"r.h5"});
}

TEST_CASE("Many writers of one name at once leave one whole result") {
  const Folder folder;
  std::vector<pid_t> writers;
  for (int i = 0; i < 8; ++i) {
    writers.push_back(fork());
    if (writers.back() > 0) continue;
    try {
      for (int k = 0; k < 20; ++k) {
        check_output_path(folder / "r.h5");  // removes what it takes for a dead writer's
        write_result(folder / "r.h5", full_result());
      }
      _exit(0);
    } catch (...) {
      _exit(1);
    }
  }
  for (const pid_t writer : writers) {
    int status = -1;
    waitpid(writer, &status, 0);
    CHECK(status == 0);
  }
  CHECK(folder.names() == std::vector<std::string>{"r.h5"});
  CHECK_NOTHROW(read_result(folder / "r.h5"));
}

TEST_CASE("Reading what is no result says so") {
  const Folder folder;
  const auto message = [](const fs::path& path) { return message_of<IoError>([&] { read_result(path); }); };
  CHECK_THAT(message(folder / "missing.h5"), Contains("missing.h5: No such file or directory"));
  CHECK_THAT(message(folder.path), Contains("is a folder"));
  write_bytes(folder / "garbage.h5", std::string(5000, 'g'));
  CHECK_THAT(message(folder / "garbage.h5"), Contains("garbage.h5: ") && Contains("signature"));
  write_bytes(folder / "empty.h5", "");
  CHECK_THAT(message(folder / "empty.h5"), Contains("empty.h5: "));

  write_foreign_hdf5(folder / "foreign.h5");
  CHECK_THAT(message(folder / "foreign.h5"), Contains("is an HDF5 file, but not a surveymc result"));
  CHECK_THAT(message_of<IoError>([&] { stored_content_hash(folder / "foreign.h5"); }),
             Contains("not a surveymc result"));
}

TEST_CASE("A number or a text changed in the file is found out") {
  const Folder folder;
  const double value = 0.123456789;
  Result r = result_of(value);
  r.provenance.title = "a title";
  write_result(folder / "r.h5", r);
  patch(folder / "r.h5", raw(value), raw(value + 1e-9));
  CHECK_THAT(message_of<IoError>([&] { read_result(folder / "r.h5"); }), Contains("Fletcher32 checksum"));
  fs::remove(folder / "r.h5");
  write_result(folder / "r.h5", r);
  patch(folder / "r.h5", "a title", "A title");
  CHECK_THAT(message_of<IoError>([&] { read_result(folder / "r.h5"); }), Contains("do not match its content_hash"));
}

TEST_CASE("A truncated file is an IoError wherever it was cut") {
  const Folder folder;
  write_result(folder / "r.h5", full_result());
  const std::string whole = bytes_of(folder / "r.h5");
  for (std::size_t size = 0; size < whole.size() - kSealSize; size += 1 + whole.size() / 97) {
    write_bytes(folder / "cut.h5", whole.substr(0, size));
    CHECK_THROWS_AS(read_result(folder / "cut.h5"), IoError);
    CHECK_THROWS_AS(stored_content_hash(folder / "cut.h5"), IoError);
  }
  write_bytes(folder / "cut.h5", whole.substr(0, whole.size() - kSealSize - 1));
  CHECK_THROWS_AS(read_result(folder / "cut.h5"), IoError);
  for (std::size_t kept = 1; kept < kSealSize; ++kept) {  // within the seal
    write_bytes(folder / "cut.h5", whole.substr(0, whole.size() - kSealSize + kept));
    CHECK_THAT(message_of<IoError>([&] { read_result(folder / "cut.h5"); }), Contains("checksum is not whole"));
  }
}

TEST_CASE("A file without its seal is read: other programs may have rewritten it") {
  const Folder folder;
  write_result(folder / "r.h5", full_result());
  const std::string whole = bytes_of(folder / "r.h5");
  write_bytes(folder / "r.h5", whole.substr(0, whole.size() - kSealSize));
  CHECK(content_hash(read_result(folder / "r.h5")) == content_hash(full_result()));
}

TEST_CASE("A damaged byte anywhere is an IoError and no crash") {
  // HDF5 itself follows damaged addresses: without the seal, some of these bytes end in a segmentation fault.
  const Folder folder;
  write_result(folder / "r.h5", full_result());
  const std::string whole = bytes_of(folder / "r.h5");
  for (std::size_t at = 3; at < whole.size(); at += at + kSealSize + 97 < whole.size() ? 97 : 1) {  // all of the seal
    write_bytes(folder / "damaged.h5", flipped(whole, at, 0x5A));
    CHECK_THROWS_AS(read_result(folder / "damaged.h5"), IoError);
  }
}

TEST_CASE("A file that HDF5 would follow without end is refused, also with its right seal") {
  const Folder folder;
  write_result(folder / "r.h5", full_result());
  std::string bytes = bytes_of(folder / "r.h5");
  bytes.resize(bytes.size() - kSealSize);
  const std::size_t texts = bytes.find("GCOL");  // where HDF5 keeps texts: behind 16 bytes, the head of the first one
  REQUIRE(texts != std::string::npos);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(texts) + 16, 16, '\0');  // free space of no size, for ever
  write_bytes(folder / "r.h5", bytes + seal_of(bytes));
  CHECK_THAT(message_of<IoError>([&] { read_result(folder / "r.h5"); }), Contains("takes too long"));
}

TEST_CASE("A seal is of every byte, for files of any size") {
  const Folder folder;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{65535}, std::size_t{65536}, std::size_t{200'001}}) {
    CAPTURE(size);
    std::string bytes(size, 'x');
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 2654435761u >> 13);
    write_bytes(folder / "f", bytes);
    const std::string seal = seal_of(bytes), whole = bytes + seal;
    CHECK(seal_of_file(folder / "f") == seal);
    write_bytes(folder / "f", whole);
    CHECK(seal_state(folder / "f") == Seal::right);
    for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 11) {
      write_bytes(folder / "f", flipped(whole, at, 1));
      CHECK(seal_state(folder / "f") != Seal::right);
    }
  }
}

TEST_CASE("Many texts are read back, held or from the disk, and equal ones are stored once", "[store]") {
  const Folder folder;
  static constexpr std::size_t n = 3 * 65536 + 17;
  const auto texts = [](const auto& text_of) {
    Texts x;
    for (std::size_t i = 0; i < n; ++i) x.push_back(text_of(i));
    return x;
  };
  const std::string word(200, 'w');
  Result r;
  r.tables = {
      {"t",
       "",
       {// new ones in every piece, also at both sides of a border of pieces, empty and not UTF-8
        {"words", "", "", texts([&](std::size_t i) {
           if (i % 65536 == 0 || i % 65536 == 65535) return word + std::to_string(i);
           return i % 5 == 0 ? "" : i % 7 == 0 ? "\xFF" : word + std::to_string(i % 11 + i / 20000);
         })},
        {"all_different", "", "", texts([](std::size_t i) { return "no. " + std::to_string(i); })},
        // too many new ones in the second piece only
        {"mixed", "", "", texts([](std::size_t i) { return i / 65536 == 1 ? std::to_string(i) : "the same"; })}}}};
  write_result(folder / "r.h5", r);
  const auto size = fs::file_size(folder / "r.h5");
  Table back = read_unchecked_result(folder / "r.h5").tables[0];
  for (const Column& c : back.columns) {
    const auto& written = std::get<Texts>(r.tables[0].column(c.name).values);
    std::size_t at = 0;
    c.for_each_piece([&](const Values& piece) {
      for (const std::string& text : std::get<Texts>(piece)) {
        if (written[at] != "\xFF" && text != written[at]) FAIL(c.name << " " << at << " " << text);
        ++at;
      }
    });
    CHECK(at == n);
  }
  CHECK(content_hash(read_result(folder / "r.h5")) == content_hash(r));
  // 16 bytes a text, some 40 more for those that HDF5 writes: 200 letters for each would be 40 MB
  CHECK(size < 3 * 16 * n + 45 * (n + 65536) + 8 * n + 300'000);

  // The same of rows that wait on the disk
  Result spooled = r;
  move_to_disk(spooled.tables[0]);
  write_result(folder / "spooled.h5", spooled);
  CHECK(content_hash(read_result(folder / "spooled.h5")) == content_hash(r));
}

TEST_CASE("Columns that a function gives are those of its values", "[store]") {
  const Folder folder;
  const std::size_t n = 280'004;
  Numbers numbers;
  Texts words;
  for (std::size_t i = 0; i < n; ++i) {
    numbers.push_back(i % 5 == 1 ? kNaN : static_cast<double>(i / 1000));
    words.push_back(std::string(i % 3, 'w') + (i % 7 == 0 ? "\xFF" : ""));
  }
  Result held, made;
  held.tables = {{"t", "", {{"x", "1", "", numbers}, {"w", "", "", words}, {"y", "1", "", numbers}}}};
  made.tables = {{"t", "", {{"x", "1", "", Numbers{}}, {"w", "", "", Texts{}}, {"y", "1", "", numbers}}}};
  for (std::size_t c = 0; c < 2; ++c)
    made.tables[0].columns[c].on_disk =
        std::make_shared<MadeValues>(n, [from = held.tables[0].columns[c]](std::size_t first, std::size_t count) {
          return values_of(from, first, count);
        });
  CHECK_FALSE(made.tables[0].is_held());
  CHECK(made.tables[0].rows() == n);
  CHECK(content_hash(made) == content_hash(held));
  for (const int compression : {0, 1}) {
    write_result(folder / "r.h5", made, {compression});
    CHECK(stored_content_hash(folder / "r.h5") == content_hash(held));
    CHECK(content_hash(read_result(folder / "r.h5")) == content_hash(held));
  }
  CHECK(render::to_csv(rows_of(made.tables[0], 70'000, 2)) == render::to_csv(rows_of(held.tables[0], 70'000, 2)));
  append_rows(made.tables[0], rows_of(held.tables[0], 0, 3));  // behind what the function gives
  append_rows(held.tables[0], rows_of(held.tables[0], 0, 3));
  CHECK(content_hash(made) == content_hash(held));
  write_result(folder / "longer.h5", made);
  CHECK(content_hash(read_result(folder / "longer.h5")) == content_hash(held));
  move_to_disk(made.tables[0]);
  CHECK(content_hash(made) == content_hash(held));
}

TEST_CASE("Writing says how many bytes are written, rising to those of the file, and can be stopped", "[store]") {
  const Folder folder;
  const std::size_t n = 400000;
  const Result r{.tables = {{"t", "", {{"a", "1", "", Numbers(n, 1.5)}, {"b", "1", "", Numbers(n, 2.5)}}}}};
  std::vector<std::uint64_t> seen;
  std::uint64_t all = 0;
  write_result(folder / "r.h5", r, {0, [&](std::uint64_t written, std::uint64_t expected) {
                                      seen.push_back(written);
                                      all = expected;
                                    }});
  REQUIRE(seen.size() >= 3);  // two columns, and the numbers of rows
  CHECK(std::is_sorted(seen.begin(), seen.end()));
  const auto size = static_cast<double>(fs::file_size(folder / "r.h5"));
  CHECK(static_cast<double>(seen.back()) == Approx(size).epsilon(0.01));
  CHECK(static_cast<double>(all) / size == Approx(1).epsilon(0.01));

  const auto stop = [](std::uint64_t written, std::uint64_t) {
    if (written > 3000000) throw Interrupted("stop");
  };
  CHECK_THROWS_AS(write_result(folder / "stopped.h5", r, {0, stop}), Interrupted);
  CHECK(folder.names() == std::vector<std::string>{"r.h5"});
}

// For check_result_file.py: the file with everything that other programs must be able to open.
TEST_CASE("Write a sample file to $SURVEYMC_SAMPLE_FILE", "[.][sample_file]") {
  const char* path = std::getenv("SURVEYMC_SAMPLE_FILE");
  if (!path) {
    WARN("SURVEYMC_SAMPLE_FILE is not set: nothing written");
    return;
  }
  Result r = full_result();
  Texts words;  // many texts
  for (int i = 0; i < 5000; ++i) words.push_back(i % 3 == 0 ? "σ" : i < 4000 ? "word" : std::to_string(i % 7));
  r.tables.push_back({"many_texts", "a long column of words", {{"word", "", "its place decides which", words}}});
  write_result(path, r);
  CHECK(stored_content_hash(path) == content_hash(r));
}

namespace {

/// The maps of `r` as one stream each, whose values are handed out in the pieces that are asked for.
Result streamed(Result r) {
  for (Map& m : r.maps) {
    Map empty = m;
    empty.values.clear();
    r.streams.push_back({{empty}, [values = m.values](std::size_t first, std::size_t count) {
                           const auto from = values.begin() + static_cast<std::ptrdiff_t>(first);
                           return std::vector<Numbers>{Numbers(from, from + static_cast<std::ptrdiff_t>(count))};
                         }});
  }
  r.maps.clear();
  return r;
}

}  // namespace

TEST_CASE("A streamed map is the same result as a held one", "[store]") {
  const Folder folder;
  Result held = full_result();
  std::erase_if(held.maps, [](const Map& m) { return m.axes.empty(); });
  // Odd sizes, so that pieces begin and end inside of every axis
  const auto numbers = [](std::size_t n) {
    Numbers x;
    for (std::size_t i = 0; i < n; ++i) x.push_back(std::sin(static_cast<double>(i)));
    return x;
  };
  held.maps.push_back({"large",
                       "1",
                       "larger than a piece",
                       {{"a", "1", "", numbers(3)},
                        {"b", "1", "", numbers(7)},
                        {"c", "1", "", numbers(181)},
                        {"d", "1", "", numbers(211)}},
                       numbers(3 * 7 * 181 * 211)});
  REQUIRE(held.maps.back().values.size() > 3 * kStreamPiece);
  const Result stream = streamed(held);
  CHECK(content_hash(stream) == content_hash(held));
  write_result(folder / "held.h5", held);
  write_result(folder / "streamed.h5", stream);
  CHECK(stored_content_hash(folder / "streamed.h5") == stored_content_hash(folder / "held.h5"));
  const Result back = read_result(folder / "streamed.h5");
  check_equal(back.maps, held.maps);
  CHECK(folder.names().size() == 2);
}

TEST_CASE("A compressed file is smaller and the same result, held and streamed", "[store]") {
  const Folder folder;
  Result r = full_result();
  std::erase_if(r.maps, [](const Map& m) { return m.axes.empty(); });
  const auto smooth = [](std::size_t n) {
    Numbers x;
    for (std::size_t i = 0; i < n; ++i) x.push_back(static_cast<double>(i / 8));
    return x;
  };
  // Longer than a chunk, a piece of a stream, and what is compressed at all; one column of NaN, one of texts
  r.tables.push_back({"long",
                      "",
                      {{"x", "1", "", smooth(70000)},
                       {"none", "1", "", Numbers(70000, kNaN)},
                       {"label", "", "", Texts(70000, "abc")}}});
  r.maps.push_back({"large",
                    "1",
                    "",
                    {{"a", "1", "", smooth(3)}, {"b", "1", "", smooth(700)}, {"c", "1", "", smooth(211)}},
                    smooth(3 * 700 * 211)});
  REQUIRE(r.maps.back().values.size() > kStreamPiece);
  write_result(folder / "plain.h5", r);
  for (const Result& either : {r, streamed(r)}) {
    write_result(folder / "packed.h5", either, WriteOptions{4, {}});
    CHECK(stored_content_hash(folder / "packed.h5") == stored_content_hash(folder / "plain.h5"));
    check_equal(read_result(folder / "packed.h5").maps, r.maps);
    // 8 bytes a number are 5 MB of the plain file; texts stay as they are
    CHECK(fs::file_size(folder / "packed.h5") + 4000000 < fs::file_size(folder / "plain.h5"));
  }
}

TEST_CASE("Unchecked reading gives the same result, and does not look at the content hash", "[store]") {
  const Folder folder;
  Result r = result_of(0.123456789);
  r.provenance.title = "a title";
  write_result(folder / "r.h5", r);
  CHECK(content_hash(read_unchecked_result(folder / "r.h5")) == content_hash(r));
  const std::string whole = bytes_of(folder / "r.h5"), bytes = flipped(whole, whole.find("a title"), 'a' ^ 'A');
  write_bytes(folder / "r.h5", bytes);
  CHECK_THROWS_AS(read_result(folder / "r.h5"), IoError);
  CHECK(read_unchecked_result(folder / "r.h5").provenance.title == "A title");
  write_bytes(folder / "r.h5", bytes.substr(0, bytes.size() / 2));
  CHECK_THROWS_AS(read_unchecked_result(folder / "r.h5"), IoError);
  write_bytes(folder / "r.h5", flipped(whole, whole.find(raw(0.123456789)), 1));  // HDF5's own checksum
  CHECK_THROWS_AS(read_unchecked_result(folder / "r.h5"), IoError);
}

TEST_CASE("A stream that throws leaves no file, and the old one as it was", "[store]") {
  const Folder folder;
  const Result before = full_result();
  write_result(folder / "a.h5", before);
  const std::string bytes = bytes_of(folder / "a.h5");
  Result broken = streamed(full_result());
  std::erase_if(broken.streams, [](const MapStream& s) { return s.maps[0].axes.empty(); });
  broken.streams[0].values = [](std::size_t, std::size_t) -> std::vector<Numbers> { throw Interrupted("stop"); };
  CHECK_THROWS_AS(write_result(folder / "a.h5", broken), Interrupted);
  CHECK(bytes_of(folder / "a.h5") == bytes);
  CHECK(folder.names().size() == 1);
}

TEST_CASE("A streamed map that does not fit on the disk is an error of ours, and the program goes on", "[store]") {
  const Folder folder;
  Result r = full_result();
  r.maps.clear();
  const std::size_t n = 4 * kStreamPiece;
  r.streams.push_back({{{"m", "1", "", {{"x", "1", "", Numbers(n)}}, {}}},
                       [](std::size_t, std::size_t count) { return std::vector<Numbers>{Numbers(count, 1.0)}; }});
  const pid_t child = fork();
  if (child == 0) {  // a limit on the size of files, as good as a full disk
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 20, 1 << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_result(folder / "a.h5", r);
    } catch (const IoError& e) {
      std::exit(std::string(e.what()).find("File too large") != std::string::npos ? 0 : 2);  // runs exit handlers
    }
    std::exit(3);
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(folder.names().empty());
}
