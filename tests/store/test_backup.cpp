#include <catch2/catch.hpp>

#include <filesystem>
#include <string>

#include "base/error.h"
#include "file_bytes.h"
#include "store/atomic_file.h"
#include "temporary_folder.h"

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

struct OldFile : TemporaryFolder {
  fs::path file = path / "r.h5", kept = path / "r.1.h5";
  OldFile() { write_bytes(file, "old"); }
  /// As AtomicFile does: under another name, then renamed.
  void replace() const {
    write_bytes(path / "new", "new");
    fs::rename(path / "new", file);
  }
};

}  // namespace

TEST_CASE("An old file is kept under the next free number") {
  const OldFile old;
  CHECK(write_beside_old(old.file, false, [&] { old.replace(); }) == old.kept);
  CHECK(bytes_of(old.file) == "new");
  CHECK(bytes_of(old.kept) == "old");
  CHECK(write_beside_old(old.file, false, [&] { old.replace(); }) == old.path / "r.2.h5");
  CHECK(bytes_of(old.kept) == "old");
}

TEST_CASE("Nothing is kept of a file that could not be replaced") {
  const OldFile old;
  CHECK_THROWS_AS(write_beside_old(old.file, false, [] { throw IoError("the disk is full"); }), IoError);
  CHECK(bytes_of(old.file) == "old");
  CHECK_FALSE(fs::exists(old.kept));
}

TEST_CASE("A file of which the system does not tell is not taken for none and replaced") {
  const OldFile old;
  bool is_written = false;
  const fs::path unknown = old.path / std::string(300, 'r');  // no system tells of so long a name: as of a failing disk
  CHECK_THROWS_WITH(write_beside_old(unknown, false, [&] { is_written = true; }),
                    Catch::Contains("cannot be looked at"));
  CHECK_FALSE(is_written);
}

TEST_CASE("An old file stays where a disk fails behind the replacement") {
  const OldFile old;
  const auto fail_late = [&] {
    old.replace();
    throw IoError("the folder cannot be synchronised");
  };
  CHECK_THROWS_AS(write_beside_old(old.file, false, fail_late), IoError);
  CHECK(bytes_of(old.file) == "new");
  CHECK(bytes_of(old.kept) == "old");
}

}  // namespace surveymc::store
