#include "store/row_spool.h"

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include <unistd.h>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "base/units.h"
#include "render/csv.h"
#include "render/json.h"
#include "render/table_text.h"
#include "store/result_file.h"
#include "temporary_folder.h"

namespace surveymc::store {
namespace {

Table numbered(std::size_t first, std::size_t rows) {
  std::vector<double> x;
  std::vector<std::int64_t> n;
  std::vector<std::string> words;
  for (std::size_t i = first; i < first + rows; ++i) {
    x.push_back(i % 7 == 3 ? kNaN : 0.1 * static_cast<double>(i));
    n.push_back(static_cast<std::int64_t>(i));
    words.push_back(i % 5 == 0 ? "" : std::string(i % 11, 'w') + ", \"" + std::to_string(i) + "\"");
  }
  return {"rows", "a long table", {{"x_m", "m", "", x}, {"n", "1", "", n}, {"word", "", "", words}}};
}

/// Rows 0 .. rows - 1, of which all but the last `held` are on the disk, moved there in pieces of unequal size.
Table on_disk(std::size_t rows, std::size_t held) {
  Table t = numbered(0, 0);
  for (std::size_t at = 0, piece = 1; at < rows; at += piece, piece = piece * 3 + 1) {
    const std::size_t end = std::min(at + piece, rows - held);
    if (at < end) {
      append_rows(t, numbered(at, end - at));
      move_to_disk(t);
    }
    if (end == rows - held) break;
  }
  append_rows(t, numbered(rows - held, held));
  return t;
}

std::string csv(const Table& t) { return render::to_csv(t); }

Result result_with(const Table& t) { return {.provenance = {.title = "long", .experiment = "test"}, .tables = {t}}; }

}  // namespace

TEST_CASE("Rows come back from the disk as they were, wherever a piece begins") {
  const Table whole = numbered(0, 1000), t = on_disk(1000, 20);
  REQUIRE_FALSE(t.is_held());
  CHECK(t.rows() == 1000);
  for (const auto& [first, count] : {std::pair<std::size_t, std::size_t>{0, 1000},
                                     {0, 0},
                                     {0, 1},
                                     {3, 37},
                                     {39, 2},
                                     {970, 10},
                                     {970, 30},
                                     {985, 15},
                                     {1000, 0}}) {
    CAPTURE(first, count);
    CHECK(csv(rows_of(t, first, count)) == csv(rows_of(whole, first, count)));
    CHECK(csv(rows_of(whole, first, count)) == csv(numbered(first, count)));
  }
  CHECK(csv(t) == csv(whole));
  CHECK(render::to_json(t) == render::to_json(whole));
  CHECK(csv(render::first_and_last(t, 5)) == csv(render::first_and_last(whole, 5)));
  CHECK(render::first_and_last(t, 5).rows() == 5);
}

TEST_CASE("A table that goes to the disk by itself has all its rows, and so has one that is appended to another") {
  Table t = numbered(0, 0);
  const std::size_t piece = 1 << 16;  // 3 MB
  for (std::size_t i = 0; i < 5; ++i) append_rows(t, numbered(i * piece, piece));
  CHECK_FALSE(t.is_held());
  CHECK(t.rows() == 5 * piece);
  Table copy = t;
  append_rows(copy, t);
  move_to_disk(copy);
  move_to_disk(t);
  append_rows(t, numbered(5 * piece, 3));
  CHECK(t.rows() == 5 * piece + 3);
  CHECK(copy.rows() == 10 * piece);
  CHECK(csv(rows_of(t, 5 * piece - 2, 5)) == csv(numbered(5 * piece - 2, 5)));
  CHECK(csv(rows_of(copy, 5 * piece, 100)) == csv(numbered(0, 100)));
  CHECK(csv(rows_of(copy, 10 * piece - 9, 9)) == csv(numbered(5 * piece - 9, 9)));
}

TEST_CASE("A result is the same whether its rows were held or on the disk") {
  const TemporaryFolder folder;
  const std::size_t rows = kMostHeldRows + 1234;
  const Result held = result_with(numbered(0, rows)), spooled = result_with(on_disk(rows, 77));
  CHECK(content_hash(held) == content_hash(spooled));
  write_result(folder.path / "held.h5", held);
  write_result(folder.path / "spooled.h5", spooled);
  for (const char* name : {"held.h5", "spooled.h5"}) {
    CAPTURE(name);
    const Result read = read_result(folder.path / name);
    CHECK(content_hash(read) == content_hash(held));
    REQUIRE(read.tables.size() == 1);
    CHECK_FALSE(read.tables.front().is_held());
    CHECK(csv(read.tables.front()) == csv(held.tables.front()));
  }
  // One row more is another result.
  CHECK(content_hash(result_with(on_disk(rows + 1, 78))) != content_hash(held));
}

TEST_CASE("The first and last rows of a long table print with the number of those between") {
  CHECK_THAT(render::format_table(render::first_and_last(on_disk(1000, 20), 10), {.left_out = 990}),
             Catch::Contains("... 990 of 1000 rows left out ...") && Catch::Contains("999"));
}

TEST_CASE("A folder without room for rows is named, with the way out") {
  const char* old = std::getenv("TMPDIR");
  const std::string kept = old ? old : "";
  setenv("TMPDIR", "/nonexistent", 1);
  Table t = numbered(0, 10);
  CHECK_THROWS_WITH(move_to_disk(t), Catch::StartsWith("/nonexistent: ") && Catch::Contains("TMPDIR"));
  CHECK(csv(t) == csv(numbered(0, 10)));
  if (old)
    setenv("TMPDIR", kept.c_str(), 1);
  else
    unsetenv("TMPDIR");
}

}  // namespace surveymc::store
