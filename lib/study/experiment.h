#pragma once
/// An experiment turns each point of a config's sweep into tables. This is the frame that all of them run in:
/// config -> StudyPoint (validated) -> blocks of trials -> tally -> tables and maps -> Result.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "checkpoint/journal.h"
#include "config/config.h"
#include "montecarlo/run_blocks.h"
#include "store/result_file.h"

namespace surveymc {

/// What one point leaves for the file.
struct PointResult {
  std::vector<Table> tables, samples;
  std::vector<Map> maps;
  std::vector<MapStream> streams = {};  ///< maps that are made while they are written
};

/// One point of a sweep, read and checked, ready to run. Immutable; run_block is called from several threads.
class StudyPoint {
 public:
  virtual ~StudyPoint() = default;
  /// At most. 0 for a study without Monte Carlo: run_block is not called, finish gets an empty tally.
  virtual std::uint64_t trials() const = 0;
  /// Trials that are run in one go: fewer where one takes long, so that threads share them.
  virtual int block_trials() const { return kBlockTrials; }
  /// Trial counts at which trials_needed is asked, rising; empty if the number of trials is fixed.
  virtual std::vector<std::uint64_t> looks() const { return {}; }
  /// Predicted from the trials so far. The run ends at a look that has as many.
  virtual std::uint64_t trials_needed(const Tally& /*so_far*/) const { return trials(); }
  virtual Tally run_block(TrialBlock block) const = 0;
  virtual PointResult finish(const Tally& tally) const = 0;
  /// For studies whose work is here and not in blocks: they look at options.stop.
  virtual PointResult finish(const Tally& tally, const RunOptions& /*options*/) const { return finish(tally); }
  /// Axes of the point's maps; all points of a sweep must have the same. Empty: no maps, or known to be the same.
  virtual std::vector<Axis> map_axes() const { return {}; }
  /// One trial in words: its draws, estimate and result. Same bits as in the run.
  virtual std::string replay(std::uint64_t trial) const = 0;
};

struct Experiment {
  std::string name;        ///< the `experiment` key of a config
  std::string summary;     ///< one line: what it computes
  std::string reproduces;  ///< source
  /// Reads one point, checks all of it, calls finish() on the reader. Throws InputError.
  std::function<std::unique_ptr<StudyPoint>(ConfigReader&, std::uint64_t seed)> read;
};

/// A config whose every point was read without error.
struct PreparedRun {
  Experiment experiment;
  Config config;
  std::vector<std::unique_ptr<StudyPoint>> points;

  std::uint64_t total_trials() const;
};

/// Throws InputError, also where the maps of a sweep have different axes; touches no file but those that the config
/// names.
PreparedRun prepare_run(const Experiment& experiment, Config config);

/// What an earlier attempt has left of a run, and where this one keeps what it finishes.
struct Checkpoint {
  FinishedBlocks finished = {};
  Journal* journal = nullptr;  ///< none: nothing is kept
};

/// Tally of a point of `run`, computed or taken from the checkpoint; empty for a point without trials.
/// Here and below: where Interrupted is thrown, the journal has all finished blocks; they are not yet synced.
Tally point_tally(const PreparedRun& run, std::size_t point, const RunOptions& options, const Checkpoint& checkpoint);

/// `options` with the point's number and block size, which keep its finished blocks in the journal, if there is one.
RunOptions options_of_point(RunOptions options, const PreparedRun& run, std::size_t point, Journal* journal);

/// A whole result from those of all points, which are asked for in order: tables below each other, the sweep's keys as
/// the first columns of every table and the first axes of every map, inputs, and provenance from the config.
Result assemble(const PreparedRun& run, const std::function<PointResult(std::size_t)>& point_result,
                const std::atomic<bool>* stop);

/// Runs every point and puts their tables together: the sweep's keys become the first columns of every table and the
/// first axes of every map. Streams of the result compute while they are read; they refer to the points of `run`, which
/// must outlive the result, and throw Interrupted when options.stop is set. Fills provenance from the config, but for
/// versions and command, and not RunInfo. options.progress gets the trials done and expected over all points.
Result execute(const PreparedRun& run, const RunOptions& options, const Checkpoint& checkpoint = {});

/// The unit that a name ends in (`field.total_nT` -> "nT"); "1" if it ends in none that we know.
std::string unit_of_name(const std::string& name);

/// Column with the sweep value `value` on `rows` rows.
Column sweep_column(const SweepValue& value, std::size_t rows);

}  // namespace surveymc
