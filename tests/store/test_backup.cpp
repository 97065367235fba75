#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <unistd.h>

#include "base/error.h"
#include "store/atomic_file.h"

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

struct OldFile {
  fs::path folder = fs::temp_directory_path() / ("surveymc_backup_" + std::to_string(getpid()));
  fs::path file = folder / "r.h5", kept = folder / "r.1.h5";
  OldFile() {
    fs::create_directories(folder);
    put(file, "old");
  }
  ~OldFile() { fs::remove_all(folder); }

  static void put(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string text(const fs::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// As AtomicFile does: under another name, then renamed.
  void replace() const {
    put(folder / "new", "new");
    fs::rename(folder / "new", file);
  }
};

}  // namespace

TEST_CASE("An old file is kept under the next free number") {
  const OldFile old;
  CHECK(write_beside_old(old.file, false, [&] { old.replace(); }) == old.kept);
  CHECK(OldFile::text(old.file) == "new");
  CHECK(OldFile::text(old.kept) == "old");
  CHECK(write_beside_old(old.file, false, [&] { old.replace(); }) == old.folder / "r.2.h5");
  CHECK(OldFile::text(old.kept) == "old");
}

TEST_CASE("Nothing is kept of a file that could not be replaced") {
  const OldFile old;
  CHECK_THROWS_AS(write_beside_old(old.file, false, [] { throw IoError("the disk is full"); }), IoError);
  CHECK(OldFile::text(old.file) == "old");
  CHECK_FALSE(fs::exists(old.kept));
}

TEST_CASE("A file of which the system does not tell is not taken for none and replaced") {
  const OldFile old;
  bool is_written = false;
  const fs::path unknown =
      old.folder / std::string(300, 'r');  // no system tells of so long a name: as of a failing disk
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
  CHECK(OldFile::text(old.file) == "new");
  CHECK(OldFile::text(old.kept) == "old");
}

}  // namespace surveymc::store
