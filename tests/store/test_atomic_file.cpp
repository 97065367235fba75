#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "file_bytes.h"
#include "store/atomic_file.h"
#include "temporary_folder.h"

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

struct Replaced : TemporaryFolder {
  fs::path file = path / "r.h5", kept = path / "r.1.h5";
  Replaced() { write_bytes(file, "old"); }

  /// What commit() returns for a new file in the place of the old one.
  std::vector<fs::path> replace(OldFile old, const MayReplace& may_replace = {}) const {
    AtomicFile next(file);
    next.write(std::string("new"));
    return next.commit(old, may_replace);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(path)) all.push_back(entry.path().filename().string());
    std::sort(all.begin(), all.end());
    return all;
  }
};

}  // namespace

TEST_CASE("An old file is kept under the next free number") {
  const Replaced old;
  CHECK(old.replace(OldFile::kept) == std::vector{old.kept});
  CHECK(bytes_of(old.file) == "new");
  CHECK(bytes_of(old.kept) == "old");
  CHECK(old.replace(OldFile::kept) == std::vector{old.path / "r.2.h5"});
  CHECK(bytes_of(old.kept) == "old");
}

TEST_CASE("An old file is replaced or refused where that is asked for, and a free name needs no asking") {
  const Replaced old;
  CHECK(old.replace(OldFile::replaced).empty());
  CHECK(bytes_of(old.file) == "new");
  write_bytes(old.file, "old");
  CHECK_THROWS_AS(old.replace(OldFile::refused), std::system_error);
  CHECK(bytes_of(old.file) == "old");
  CHECK(old.names() == std::vector<std::string>{"r.h5"});
  fs::remove(old.file);
  CHECK(old.replace(OldFile::refused).empty());
  CHECK(bytes_of(old.file) == "new");
}

TEST_CASE("Nothing changes where the old file may not be replaced") {
  const Replaced old;
  for (const OldFile fate : {OldFile::kept, OldFile::replaced}) {
    CHECK_THROWS_AS(old.replace(fate, [](const fs::path&) { throw IoError("is foreign"); }), IoError);
    CHECK(bytes_of(old.file) == "old");
    CHECK(old.names() == std::vector<std::string>{"r.h5"});
  }
}

TEST_CASE("A file that appears behind the look at the old one is kept, unless it may be replaced, too") {
  const Replaced old;
  const auto look = [&](const fs::path& there) {
    if (bytes_of(there) == "foreign") throw IoError("is foreign");
    if (there != old.file) return;
    fs::remove(old.file);
    write_bytes(old.file, "foreign");
  };
  CHECK(old.replace(OldFile::replaced, look) == std::vector{old.kept});
  CHECK(bytes_of(old.file) == "new");
  CHECK(bytes_of(old.kept) == "foreign");
  CHECK(old.replace(OldFile::kept, look) == std::vector{old.path / "r.2.h5"});
  CHECK(bytes_of(old.path / "r.2.h5") == "foreign");
  CHECK(old.names() == std::vector<std::string>{"r.1.h5", "r.2.h5", "r.h5"});
}

TEST_CASE("A file that goes behind the look at it is no obstacle") {
  const Replaced old;
  for (const OldFile fate : {OldFile::kept, OldFile::replaced}) {
    CHECK(old.replace(fate, [&](const fs::path&) { fs::remove(old.file); }).empty());
    CHECK(old.names() == std::vector<std::string>{"r.h5"});
  }
}

}  // namespace surveymc::store
