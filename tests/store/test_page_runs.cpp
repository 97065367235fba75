#include "store/page_runs.h"

#include <algorithm>
#include <csignal>
#include <string>
#include <system_error>
#include <vector>

#include <sys/resource.h>
#include <catch2/catch.hpp>

#include "temporary_folder.h"

namespace surveymc::store {
namespace {

/// Other bytes for every page and every version of it.
std::string pages(std::uint64_t first, std::size_t count, unsigned version) {
  std::string out(count * kSealedPage, '\0');
  for (std::size_t i = 0; i < out.size(); i += 8) {
    const std::uint64_t word = ((first * kSealedPage + i) * 0x9E3779B97F4A7C15u) ^ version;
    std::copy_n(reinterpret_cast<const char*>(&word), 8, out.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return out;
}

struct Write {
  std::uint64_t first;
  std::string bytes;
};

/// The bytes are made before: runs come faster than the disk takes them.
void add(PageRuns& runs, const std::vector<Write>& writes) {
  for (const Write& w : writes) runs.add(w.first * kSealedPage, w.bytes.data(), w.bytes.size());
}

/// The file, by other means.
void add(std::string& file, const std::vector<Write>& writes) {
  for (const Write& w : writes) {
    const std::size_t at = w.first * kSealedPage;
    if (file.size() < at + w.bytes.size()) file.resize(at + w.bytes.size());
    std::copy(w.bytes.begin(), w.bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

TEST_CASE("Page runs: a file gets every page where it belongs, the last version of each, and its hash") {
  const bool past_cache = GENERATE(false, true);
  const TemporaryFolder folder;
  AtomicFile file(folder / "x");
  PageRuns runs(file, past_cache);
  std::vector<Write> writes;
  // Five places in turn, as maps of one stream, 100 MiB in all: alone first, then by the thread. 33 pages are two runs
  // that follow each other, and one page of a third.
  for (std::size_t turn = 0; turn < 10; ++turn)
    for (std::size_t map = 0; map < 5; ++map)
      writes.push_back({map * 330 + turn * 33, pages(map * 330 + turn * 33, 33, 1)});
  // Pages that are still on their way get other bytes, whole runs and single pages
  for (const std::size_t count : {16, 1, 40, 3})
    for (unsigned version = 2; version < 5; ++version) writes.push_back({700, pages(700, count, version * 10)});
  std::string expected;
  add(expected, writes);
  add(runs, writes);
  runs.finish();
  const auto check = [&] {
    std::string found(expected.size(), '\1');
    file.read_at(0, found);
    CHECK(found == expected);
    REQUIRE(runs.hashes().size() * kSealedPage == found.size());
    for (std::size_t k = 0; k < runs.hashes().size(); ++k)
      if (runs.hashes()[k] != page_hash(found.data() + k * kSealedPage, kSealedPage)) FAIL("hash of page " << k);
  };
  check();
  const std::vector<Write> more{{3, pages(3, 2, 99)}, {1650, pages(1650, 70, 99)}};
  add(expected, more);
  add(runs, more);  // behind finish()
  runs.finish();
  check();
}

TEST_CASE("Page runs: what the disk refuses is told by every call that follows, whoever writes") {
  const std::size_t before = GENERATE(8, 1000);  // pages: the caller writes, or the thread
  const TemporaryFolder folder;
  AtomicFile file(folder / "x");
  struct LeastFiles {
    rlimit old{};
    explicit LeastFiles(std::uint64_t size) {
      std::signal(SIGXFSZ, SIG_IGN);
      getrlimit(RLIMIT_FSIZE, &old);
      const rlimit less{size, old.rlim_max};
      setrlimit(RLIMIT_FSIZE, &less);
    }
    ~LeastFiles() {
      setrlimit(RLIMIT_FSIZE, &old);
      std::signal(SIGXFSZ, SIG_DFL);
    }
  };
  PageRuns runs(file, true);
  runs.add(0, pages(0, before, 1).data(), before * kSealedPage);
  const LeastFiles limit(before * kSealedPage);
  const std::string more = pages(before, 400, 1);
  const auto go_on = [&] { runs.add(before * kSealedPage, more.data(), more.size()); };
  CHECK_THROWS_AS(go_on(), std::system_error);
  CHECK_THROWS_AS(runs.finish(), std::system_error);
  CHECK_THROWS_AS(go_on(), std::system_error);
  CHECK_THROWS_AS(runs.finish(), std::system_error);
}

TEST_CASE("Page runs: what is not finished may be left") {
  const TemporaryFolder folder;
  AtomicFile file(folder / "x");
  PageRuns runs(file, false);
  const std::string bytes = pages(0, 1000, 1);
  runs.add(0, bytes.data(), bytes.size());
}

}  // namespace
}  // namespace surveymc::store
