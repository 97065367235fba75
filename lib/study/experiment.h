#pragma once
/// An experiment turns each point of a config's sweep into tables. All experiments run in the same stages:
///   read      config -> PointPlan for every point: checked, and so cheap that a sweep of 10,000 points is read in a
///             moment by every task of an array
///   prepare   PointPlan -> StudyPoint, in the task that runs the point and for no other point
///   run       blocks of trials -> tally
///   report    tally -> tables and maps -> Result
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "checkpoint/journal.h"
#include "config/config.h"
#include "montecarlo/run_blocks.h"
#include "random/study_id.h"
#include "store/result_file.h"
#include "study/reference_field.h"

namespace surveymc::study {

/// The part of the result file that comes from one point.
struct PointResult {
  std::vector<store::Table> tables, samples;
  std::vector<store::Map> maps;
  std::vector<store::MapStream> streams = {};  ///< maps that are made while they are written
};

/// One point of a sweep, ready to run. Immutable; run_block is called from several threads.
class StudyPoint {
 public:
  virtual ~StudyPoint() = default;
  /// Not called for a study without trials.
  virtual stats::Tally run_block(montecarlo::TrialBlock /*block*/) const { return {}; }
  /// Which proposal its trials are drawn from, where they have weights (stats::Tally::proposal); 0: none. Tallies of
  /// another one are refused.
  virtual std::uint64_t proposal() const { return 0; }
  /// Number of trials needed in all, predicted from the trials so far. Called at the looks of the plan; the run ends at
  /// a look that has as many trials.
  virtual std::uint64_t trials_needed(const stats::Tally& /*so_far*/) const {
    return std::numeric_limits<std::uint64_t>::max();
  }
  /// `tally` of all trials; empty for a study without trials. A long computation checks options.stop and throws
  /// Interrupted. Streams of the result may refer to the point, which outlives them.
  virtual PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const = 0;
  /// One trial in words: its draws, estimate and result. Same bits as in the run.
  virtual std::string replay(std::uint64_t /*trial*/) const { return {}; }
};

/// One point of a sweep as its config gives it: read and checked, nothing computed.
class PointPlan {
 public:
  virtual ~PointPlan() = default;
  /// Largest number of trials. 0 for a study without Monte Carlo.
  virtual std::uint64_t trials() const { return 0; }
  /// Trials in a block: fewer where a trial takes long, so that threads share them. Results depend on this number.
  virtual int block_trials() const { return montecarlo::kBlockTrials; }
  /// Trial counts at which StudyPoint::trials_needed is called, rising; empty if the number of trials is fixed.
  virtual std::vector<std::uint64_t> looks() const { return {}; }
  /// Axes of the point's maps; all points of a sweep must have the same. Empty: no maps, or known to be the same.
  virtual std::vector<store::Axis> map_axes() const { return {}; }
  /// Text that `surveymc check` prints as comments, besides the config: the meaning of files and names.
  virtual std::string details() const { return {}; }
  /// May compute: predictions, models, starts of the trials. A long computation checks options.stop and throws
  /// Interrupted. Throws InputError, by ConfigPlace, where only computing shows that a value is not allowed.
  virtual std::unique_ptr<StudyPoint> prepare(const montecarlo::RunOptions& options) const = 0;
};

struct Experiment {
  random::StudyId id = random::StudyId::none;  ///< address of its random numbers
  std::string summary;                         ///< one line: what it computes
  std::string reproduces;                      ///< source
  /// Reads one point, checks all that costs next to nothing, calls finish() on the reader. Throws InputError.
  std::unique_ptr<PointPlan> (*read)(config::ConfigReader&, random::StudySeed) = nullptr;

  /// The `experiment` key of a config.
  std::string name() const { return std::string(random::name_of(id)); }
};

/// A config whose every point was read without error.
struct RunPlan {
  Experiment experiment;
  config::Config config;
  std::vector<std::unique_ptr<PointPlan>> points;
  std::vector<std::optional<PlacedField>> placed;  ///< of each point whose reference field is that of a place
  bool as_family = true;                           ///< `verdict.family` is not "none": see family.h

  std::uint64_t total_trials() const;
  /// The point, ready to run. InputError of a sweep's point says which point it is. Throws Interrupted if options.stop
  /// is set.
  std::shared_ptr<const StudyPoint> prepare(std::size_t point, const montecarlo::RunOptions& options) const;
};

/// Reads all points; prepares none. Throws InputError, also where the maps of a sweep have different axes; Interrupted
/// when *stop is set; touches no file but those that the config names.
RunPlan read_run(const Experiment& experiment, config::Config config, const std::atomic<bool>* stop = nullptr);

/// Finished blocks of an earlier attempt at a run, and the journal for the blocks that this attempt finishes.
struct Checkpoint {
  checkpoint::FinishedBlocks finished = {};
  checkpoint::Journal* journal = nullptr;  ///< none: nothing is kept
};

/// Throws InputError that names `whose`, where the tally's weights are of another proposal than the point's.
void require_proposal(const StudyPoint& point, const stats::Tally& tally, const std::string& whose);

/// Tally of point `index` of `run`, computed or taken from the checkpoint; empty without trials. `point` is that point,
/// prepared. Here and below: where Interrupted is thrown, the journal has all finished blocks; they are not yet synced.
stats::Tally point_tally(const RunPlan& run, std::size_t index, const StudyPoint& point,
                         const montecarlo::RunOptions& options, const Checkpoint& checkpoint);

/// Tables and maps of a point; the streams among them own it.
PointResult point_report(const std::shared_ptr<const StudyPoint>& point, const stats::Tally& tally,
                         const montecarlo::RunOptions& options);

/// `options` with the point's number and block size, and with callbacks that write its finished blocks to the journal,
/// if there is one.
montecarlo::RunOptions options_of_point(montecarlo::RunOptions options, const RunPlan& run, std::size_t point,
                                        checkpoint::Journal* journal);

/// A whole result from those of all points, which are asked for in order: tables below each other, the sweep's keys as
/// the first columns of every table and the first axes of every map, inputs, and provenance from the config.
store::Result assemble(const RunPlan& run, const std::function<PointResult(std::size_t)>& point_result,
                       const std::atomic<bool>* stop);

/// Prepares and runs one point after the other and puts their tables together: the sweep's keys become the first
/// columns of every table and the first axes of every map. Streams of the result compute while they are read, and throw
/// Interrupted when options.stop is set. Fills provenance from the config, but for
/// versions and command, and not RunInfo. options.progress gets the trials done and expected over all points.
store::Result execute(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint = {});

/// The unit that a name ends in (`field.total_nT` -> "nT"); "1" if it ends in none that we know.
std::string unit_of_name(const std::string& name);

/// Column with the sweep value `value` on `rows` rows.
store::Column sweep_column(const config::SweepValue& value, std::size_t rows);

}  // namespace surveymc::study
