#pragma once
/// Part files: the tallies of some sweep points, or of a shard of the trials, with the config that they belong to,
/// until all parts are merged. Written whole or not at all (docs/results-format.md).
///
/// A file is a head of 128 bytes, a record with the config and its files, a record that says where each piece is, and
/// the pieces, a record each (record.h). So a folder of parts is listed from their heads, and a merge holds one piece
/// of a part at a time.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "checkpoint/record.h"
#include "config/input_file.h"
#include "config/input_table.h"
#include "montecarlo/run_blocks.h"
#include "store/atomic_file.h"
#include "store/result_file.h"

namespace surveymc::checkpoint {

/// Blocks of one sweep point.
struct PartPiece {
  std::uint64_t point = 0;
  montecarlo::BlockRange blocks = {};  ///< first .. end - 1
  std::uint64_t blocks_in_all = 0;     ///< of the point, at most; 0: a point without trials
  bool whole = false;                  ///< all of the point, even if a stopping rule ended it before blocks_in_all
  std::vector<montecarlo::Subtree> subtrees = {};
  std::string result = {};   ///< of a point without trials: its tables and maps (study/point_result_bytes.h)
  std::string failure = {};  ///< why the point cannot be run; "" if it can
  std::string file = {};     ///< that it was read from, for messages
};

/// Sweep points first, first + stride, .. < end.
struct PointRange {
  std::uint64_t first = 0, end = 0, stride = 1;

  std::uint64_t count() const { return end > first ? (end - first + stride - 1) / stride : 0; }
  std::uint64_t point(std::uint64_t i) const { return first + i * stride; }
  bool contains(std::uint64_t point) const { return point >= first && point < end && (point - first) % stride == 0; }
  bool operator==(const PointRange&) const = default;
};

struct Part {
  RunKey key;
  std::string title, experiment;
  std::string config;                      ///< TOML as it was given (Config::source_text())
  std::vector<config::InputTable> inputs;  ///< files that its points name
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references = {};  ///< files that are not stored in a part
  std::string folder = {};                              ///< of the config, absolute: where those files are
  std::uint64_t points = 0;                             ///< of the whole run
  PointRange range = {};                                ///< the points of `pieces`
  std::uint64_t shard = 0, shards = 1;
  std::string command;
  store::RunInfo run;
  std::vector<PartPiece> pieces;
};

/// Writes the file whole or not at all. A file that is no part is never replaced; `old` says what becomes of a part,
/// and its new names are returned. Throws IoError.
std::vector<std::filesystem::path> write_part(const std::filesystem::path& path, const Part& part,
                                              store::OldFile old = store::OldFile::replaced);

/// Throws IoError if it is missing, no part file, or damaged.
Part read_part(const std::filesystem::path& path);

/// What the first 128 bytes of a part say.
struct PartHead {
  std::string run;           ///< hash of config and program, 16 bytes: equal for parts that belong together
  std::uint64_t points = 0;  ///< of the whole run
  PointRange range;
  std::uint64_t shard = 0, shards = 1;
  double elapsed_s = 0;
  bool whole = false;   ///< every piece is all of its point
  bool failed = false;  ///< some points could not be run
  std::uint64_t about_size = 0, index_size = 0;
};

/// The head of a part whose file has the size that it should have. Reads nothing else. Throws IoError.
PartHead read_part_head(const std::filesystem::path& path);

/// PartHead::run of parts with this key: the same for builds whose numbers have the same bits.
std::string run_bytes(const RunKey& key);

/// One piece of a part, and where it is.
struct PieceEntry {
  std::uint64_t point = 0;
  montecarlo::BlockRange blocks;
  std::uint64_t blocks_in_all = 0;
  bool whole = false, failed = false;
  std::uint64_t offset = 0, size = 0;  ///< in the file, bytes of its record
};

/// A part whose pieces are read one by one. All members throw IoError where the file is missing or damaged.
class PartReader {
 public:
  explicit PartReader(std::filesystem::path path);
  ~PartReader();
  PartReader(PartReader&& other) noexcept;
  PartReader& operator=(PartReader&&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const PartHead& head() const { return head_; }
  const std::vector<PieceEntry>& pieces() const { return pieces_; }
  /// All of the part but its pieces.
  Part about();
  PartPiece piece(std::size_t i);
  /// The record of a piece, for another part.
  std::string piece_bytes(std::size_t i);
  /// Closes the file; it is opened again when it is needed.
  void close();
  bool is_open() const { return file_ >= 0; }

 private:
  std::string bytes(std::uint64_t offset, std::uint64_t size);

  std::filesystem::path path_;
  PartHead head_;
  std::vector<PieceEntry> pieces_;
  int file_ = -1;
};

/// Writes a part whose pieces are records of others, in order of `pieces` (whose offsets do not count);
/// piece_bytes(i) gives the i-th. Otherwise as write_part().
std::vector<std::filesystem::path> write_part_of(const std::filesystem::path& path, const Part& about,
                                                 std::vector<PieceEntry> pieces,
                                                 const std::function<std::string(std::size_t)>& piece_bytes,
                                                 store::OldFile old = store::OldFile::replaced);

/// True if the file begins as a part of any version does. Reads nothing else.
bool has_part_mark(const std::filesystem::path& path);

/// State of a part file.
enum class PartState { missing, whole, damaged, foreign };
PartState part_state(const std::filesystem::path& path);

/// Throws IoError if there is a file that is no part, which no part may replace.
void refuse_foreign_part(const std::filesystem::path& path);

}  // namespace surveymc::checkpoint
