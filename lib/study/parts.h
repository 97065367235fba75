#pragma once
/// A run in parts: a range of sweep points, or one shard of the trials (a slice of whole blocks), or both. Merged they
/// give the result of the whole run, bit for bit.
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/point_set.h"
#include "checkpoint/part_file.h"
#include "study/experiment.h"

namespace surveymc::study {

struct PartChoice {
  std::optional<checkpoint::PointRange> points;  ///< all points otherwise
  std::uint64_t shard = 0, shards = 1;

  static PartChoice of_point(std::uint64_t point) { return {checkpoint::PointRange{point, point + 1, 1}}; }
  checkpoint::PointRange range(const RunPlan& run) const {
    return points.value_or(checkpoint::PointRange{0, run.point_count(), 1});
  }
};

/// "point-00003", "points-00100-00200", "points-00000-10000-by-00100", "shard-2-of-5", "point-00003-shard-2-of-5". The
/// second number is the end of the range, as given.
std::string part_name(const PartChoice& choice);

/// The run has no such part; its config is right.
class BadChoice : public InputError {
 public:
  using InputError::InputError;
};

/// Throws BadChoice if a number is out of range, or there are shards where a point has no trials or a [stop] rule,
/// which looks at all trials so far. Throws InputError for a point that cannot be read.
void check_choice(const RunPlan& run, const PartChoice& choice);

/// Reads the points of the part, the first kMostReadWhole of them if it has more, and the table of points, if there is
/// one, not whole. Throws InputError for a point that is not valid, unless the sweep is large; Interrupted.
void read_points(const RunPlan& run, const PartChoice& choice, const std::atomic<bool>* stop);

/// The piece of a point in a part, without its tally.
checkpoint::PartPiece part_piece(const RunPlan& run, const PartChoice& choice, std::uint64_t point);
/// The pieces of a part, without their tallies.
std::vector<checkpoint::PartPiece> part_pieces(const RunPlan& run, const PartChoice& choice);

/// Computes a part and fills in all members but key.program, command, run and folder.
checkpoint::Part run_part(const RunPlan& run, const PartChoice& choice, const montecarlo::RunOptions& options,
                          const Checkpoint& checkpoint);

/// The finished part of a run: whole points, and blocks of others.
class Coverage {
 public:
  /// A part whose pieces are all whole points.
  void add(const checkpoint::PointRange& range);
  void add(const checkpoint::PieceEntry& piece);
  /// Points of 0 .. count - 1 of which anything is missing.
  PointSet missing(std::uint64_t count) const;
  /// Blocks of the point that no piece has, rising; nothing if it is whole, or if no piece has any of it.
  std::vector<montecarlo::BlockRange> gaps(std::uint64_t point) const;
  /// True if some blocks of the point are there, but not all.
  bool is_partial(std::uint64_t point) const { return partial_.contains(point) && !gaps(point).empty(); }
  /// True if all blocks of the piece are there.
  bool covers(const checkpoint::PartPiece& piece) const;

 private:
  struct Blocks {
    std::vector<montecarlo::BlockRange> there;
    std::uint64_t in_all = 0;
  };
  PointSet whole_;
  std::map<std::uint64_t, Blocks> partial_;
};

/// "0-3,7", as Slurm's --array wants it.
std::string array_list(const PointSet& points);

/// "shard 1 of 2", "shards 1-3,7 of 9": those that are not among these parts, if all are shards of one division of the
/// same points; otherwise, and if none is missing, "".
std::string missing_shards(const std::vector<checkpoint::PartHead>& parts);

/// The first file of which the part has other contents than `config` has read; "" if there is none.
std::string other_file(const checkpoint::Part& part, const config::Config& config);

/// Config and files of a part, read again.
config::Config config_of(const checkpoint::Part& part, const std::string& label, const std::string& folder = {});

/// Parts of one run, of which at most 64 files are open at a time and one piece of a point is held.
class PartSet {
 public:
  /// Throws IoError; InputError if a part is of another config than the first, or of a build whose numbers may have
  /// other bits than those of `program`, or where two parts have read different files of one name.
  PartSet(const std::vector<std::filesystem::path>& paths, const std::string& program);

  /// The first part without its pieces, with the files of all parts.
  const checkpoint::Part& about() const { return about_; }
  std::size_t count() const { return readers_.size(); }
  const Coverage& coverage() const { return coverage_; }
  /// Pieces of a point, in the order of the parts.
  std::vector<checkpoint::PartPiece> pieces(std::uint64_t point);
  std::vector<checkpoint::PartHead> heads() const;
  /// Remarks for the user: which parts are of another build.
  const std::vector<std::string>& remarks() const { return remarks_; }
  /// Writes the pieces of all parts, in order of the points, as one part.
  std::vector<std::filesystem::path> write_merged(const std::filesystem::path& path, const std::atomic<bool>* stop,
                                                  store::OldFile old = store::OldFile::replaced);

 private:
  struct Place {
    std::uint64_t point = 0;
    std::uint32_t part = 0, piece = 0;
  };
  checkpoint::PartReader& opened(std::uint32_t part);

  checkpoint::Part about_;
  std::vector<checkpoint::PartReader> readers_;
  std::vector<Place> places_;        // of all pieces, in order of the points
  std::vector<std::uint32_t> open_;  // in order of their last use
  Coverage coverage_;
  std::vector<std::string> remarks_;
};

/// Throws InputError that names what no part has: `shards` (missing_shards()), points, and trials of points.
void require_complete(const RunPlan& run, const Coverage& coverage, const std::string& shards);

/// A point's part of the result, from its pieces.
PointResult merged_point(const RunPlan& run, std::uint64_t point, std::vector<checkpoint::PartPiece> pieces,
                         const montecarlo::RunOptions& options);

/// The result of the whole run, whatever the order, number and overlap of the parts. Throws InputError that names what
/// is missing.
store::Result merge_parts(const RunPlan& run, PartSet& parts, const montecarlo::RunOptions& options);

}  // namespace surveymc::study
