#pragma once
/// An experiment turns each point of a config's sweep into tables. All experiments run in the same stages:
///   read      config -> PointPlan: checked, and so cheap that a sweep of 10,000 points is read in a moment.
///             A task of a sweep reads the points that it runs, and no others
///   prepare   PointPlan -> StudyPoint, in the task that runs the point and for no other point
///   run       blocks of trials -> tally
///   report    tally -> tables and maps -> Result
#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "checkpoint/journal.h"
#include "checkpoint/part_file.h"
#include "compare/answer.h"
#include "config/config.h"
#include "montecarlo/run_blocks.h"
#include "random/study_id.h"
#include "scenario/reference_field.h"
#include "store/result_file.h"

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
  /// The proposal that weighted trials are drawn from (stats::Tally::proposal); 0: none. Tallies of another proposal
  /// are refused.
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
  /// Cost of the point relative to others, in any unit: tasks of a sweep get points of equal total cost.
  virtual double cost() const { return std::max<double>(1, static_cast<double>(trials())); }
  /// Trial counts at which StudyPoint::trials_needed is called, rising; empty if the number of trials is fixed.
  virtual std::vector<std::uint64_t> looks() const { return {}; }
  /// Axes of the point's maps; all points of a sweep must have the same. Empty: no maps, or known to be the same.
  virtual std::vector<store::Axis> map_axes() const { return {}; }
  /// Text that `surveymc check` prints as comments, besides the config: the meaning of files and names.
  virtual std::string details() const { return {}; }
  /// May compute: predictions, models, starts of the trials. A long computation checks options.stop and throws
  /// Interrupted. Throws InputError, by ConfigPlace, where only computing shows that a value is not allowed. What takes
  /// long and is the same at other points goes through shared_work(options.shared, ...).
  virtual std::unique_ptr<StudyPoint> prepare(const montecarlo::RunOptions& options) const = 0;
};

/// The plan of a study whose config is read into a `Scenario`. Its trials and looks are those of the scenario's member
/// `trial_plan` (TrialPlan), or it has `trials` and no looks; without either it is of a study without Monte Carlo.
template <class Scenario>
class PlanOf : public PointPlan {
 public:
  explicit PlanOf(Scenario scenario) : s_(std::move(scenario)) {}
  std::uint64_t trials() const override {
    if constexpr (requires { this->s_.trial_plan; })
      return s_.trial_plan.trials;
    else if constexpr (requires { this->s_.trials; })
      return s_.trials;
    else
      return PointPlan::trials();
  }
  std::vector<std::uint64_t> looks() const override {
    if constexpr (requires { this->s_.trial_plan; })
      return s_.trial_plan.looks;
    else
      return PointPlan::looks();
  }

 protected:
  const Scenario s_;
};

/// The same of a study whose `Point` is made of the scenario alone.
template <class Scenario, class Point, int kBlockTrials = montecarlo::kBlockTrials>
class PlanOfPoint : public PlanOf<Scenario> {
 public:
  using PlanOf<Scenario>::PlanOf;
  int block_trials() const override { return kBlockTrials; }
  std::unique_ptr<StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return std::make_unique<Point>(this->s_);
  }
};

struct Experiment {
  random::StudyId id = random::StudyId::none;  ///< address of its random numbers
  std::string summary;                         ///< one line: what it computes
  std::string reproduces;                      ///< source
  /// Reads one point, checks all that costs next to nothing, calls finish() on the reader. Throws InputError.
  std::unique_ptr<PointPlan> (*read)(config::ConfigReader&, random::StudySeed) = nullptr;
  /// Formulations that hold in some cases only, as is known, but in which is the question: where one differs from Monte
  /// Carlo, that is a finding. The same of all rows of a table `claims`.
  std::vector<std::string> approximations = {};
  /// What the result says, in sentences made from its tables, which are those of all points.
  void (*answer)(compare::Answer&, const store::Result&) = nullptr;

  /// The `experiment` key of a config.
  std::string name() const { return std::string(random::name_of(id)); }
};

/// For Experiment::read: a `Plan` of what `read_scenario` reads, which draws random numbers (a second argument, the
/// seed) or not.
template <class Plan, auto read_scenario>
std::unique_ptr<PointPlan> plan_of(config::ConfigReader& config, random::StudySeed seed) {
  if constexpr (std::is_invocable_v<decltype(read_scenario), config::ConfigReader&, random::StudySeed>)
    return std::make_unique<Plan>(read_scenario(config, seed));
  else
    return std::make_unique<Plan>(read_scenario(config));
}

/// Reads a point as its study does, with what every study checks. Throws InputError.
std::unique_ptr<PointPlan> read_point(const Experiment& experiment, const config::Config& config,
                                      config::ConfigReader& reader);

/// A sweep of more points is not read whole before it runs, and a point that turns out to be invalid does not end it:
/// the result lists it in the table failed_points.
inline constexpr std::size_t kMostReadWhole = 10'000;

/// A config and its points, which are read on demand. Several threads may ask.
class RunPlan {
 public:
  RunPlan(Experiment of, config::Config from) : experiment(std::move(of)), config(std::move(from)) {}

  Experiment experiment;
  mutable config::Config config;  ///< reading a point tells it the files and defaults of the point

  std::size_t point_count() const { return config.point_count(); }
  bool is_large() const { return point_count() > kMostReadWhole; }
  /// Reads the point, unless it still has it. Throws InputError, also where the maps of a sweep have different axes.
  std::shared_ptr<const PointPlan> plan(std::size_t point) const;
  /// The reference field of the point, if it is that of a place.
  std::optional<scenario::PlacedField> placed(std::size_t point) const;
  /// `verdict.family`, which no sweep changes, is not "none": see family.h.
  bool is_family() const { return is_family_; }
  /// Trials of all points. For a large sweep: trials of the first point times the number of points.
  std::uint64_t total_trials() const;
  /// Trials of one point. For a large sweep: trials of the first point that was read and is valid.
  std::uint64_t trials_of(std::size_t point) const;
  /// The point, ready to run. InputError of a sweep's point says which point it is. Throws Interrupted if options.stop
  /// is set.
  std::shared_ptr<const StudyPoint> prepare(std::size_t point, const montecarlo::RunOptions& options) const;
  /// Points of a large sweep that read_run() has tried, and those of them that are invalid.
  struct Sample {
    std::size_t points = 0, invalid = 0;
    std::string first_reason;
  };
  Sample sample;
  /// Work that the prepared points share.
  const SharedWork& shared() const { return *shared_; }
  /// For a large sweep: the point is not needed again.
  void forget(std::size_t point) const;

 private:
  struct ReadPoint {
    std::shared_ptr<const PointPlan> plan;
    std::optional<scenario::PlacedField> placed;
  };
  std::shared_ptr<const ReadPoint> read(std::size_t point) const;

  std::unique_ptr<std::mutex> reading_ = std::make_unique<std::mutex>();          // for what follows
  mutable std::map<std::size_t, std::shared_ptr<const ReadPoint>> read_;          // of a large sweep the latest ones
  mutable std::optional<std::pair<std::size_t, std::vector<store::Axis>>> axes_;  // the first point that was read
  mutable std::optional<std::pair<std::size_t, std::uint64_t>> first_trials_;     // of the first valid point, if large
  mutable bool is_family_ = true;
  std::unique_ptr<SharedWork> shared_ = std::make_unique<SharedWork>();
};

/// Reads all points; of a large sweep the table of points, if it has one, and sample_points(), some of which may be
/// invalid, but not all. Prepares none. Throws InputError, Interrupted when *stop is set; touches no file but those
/// that the config names. `threads` read points at a time; 0: as many as there are.
RunPlan read_run(const Experiment& experiment, config::Config config, const std::atomic<bool>* stop = nullptr,
                 int threads = 0);

/// Reads no point.
RunPlan open_run(const Experiment& experiment, config::Config config);

/// Finished blocks and points of an earlier attempt at a run, and the journal for those that this attempt finishes.
struct Checkpoint {
  checkpoint::FinishedBlocks finished = {};
  checkpoint::Journal* journal = nullptr;  ///< none: nothing is kept
  checkpoint::FinishedPoints points = {};  ///< of a study without trials
  checkpoint::JournalsOfProposals drawn_in = {};
};

/// Throws IoError that names `whose`, where the tally's weights are of another proposal than the point's.
void require_proposal(const StudyPoint& point, const stats::Tally& tally, const std::string& whose);

/// The blocks of point `index` that an earlier attempt has finished. `point` is that point, prepared. Throws IoError
/// that names the journal where their weights are of another proposal.
std::vector<montecarlo::Subtree> finished_blocks(const Checkpoint& checkpoint, std::size_t index,
                                                 const StudyPoint& point);

/// Tally of point `index` of `run`, computed or taken from the checkpoint; empty without trials. `point` is that point,
/// prepared. Here and below: where Interrupted is thrown, the journal has all finished blocks; they are not yet synced.
/// `seconds`: a number to which the processor time of its blocks is added.
stats::Tally point_tally(const RunPlan& run, std::size_t index, const StudyPoint& point,
                         const montecarlo::RunOptions& options, const Checkpoint& checkpoint,
                         std::atomic<double>* seconds = nullptr);

/// Tables and maps of a point; the streams among them own it.
PointResult point_report(const std::shared_ptr<const StudyPoint>& point, const stats::Tally& tally,
                         const montecarlo::RunOptions& options);

/// `options` with the point's number and block size, and with callbacks that write its finished blocks to the journal,
/// if there is one.
montecarlo::RunOptions options_of_point(montecarlo::RunOptions options, const RunPlan& run, std::size_t point,
                                        checkpoint::Journal* journal);

/// The point's part of a result: with the tables of its reference field, and the sweep's keys as first columns.
PointResult placed_in_sweep(const RunPlan& run, std::size_t point, PointResult result);
/// A result with everything but tables, samples and maps: inputs, and provenance from the config, all of whose points
/// were read.
store::Result result_without_tables(const RunPlan& run);

/// Puts the table `answer` in front of the tables of a result, which has all others.
void add_answer(const Experiment& experiment, store::Result& result);

/// A whole result from those of all points, which are asked for in order: tables below each other, the sweep's keys as
/// the first columns of every table and the first axes of every map, inputs, and provenance from the config.
store::Result assemble(const RunPlan& run, const std::function<PointResult(std::size_t)>& point_result,
                       const std::atomic<bool>* stop);

/// The threads that share these points of a run and their blocks. With other ranks it is one: points go one after the
/// other then, and all ranks share the blocks of each.
int threads_of(const RunPlan& run, const checkpoint::PointRange& points, const montecarlo::RunOptions& options);

/// Progress of all points of a run together, for options.progress. Several threads report their points.
class SweepProgress {
 public:
  /// `expected`: trials of all points.
  SweepProgress(const montecarlo::RunOptions& options, std::uint64_t expected)
      : told_(options.progress), expected_(expected) {}
  /// `options` with a progress of one point, of which `trials` are expected so far.
  montecarlo::RunOptions of_point(montecarlo::RunOptions options, std::uint64_t trials);

 private:
  std::function<void(std::uint64_t, std::uint64_t)> told_;
  std::mutex telling_;
  std::uint64_t done_ = 0, expected_;
};

/// Computes the points of a run: its part of execute(). Several threads may do so.
class ComputedPoints {
 public:
  /// `run` and `checkpoint` outlive it.
  ComputedPoints(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint);
  ~ComputedPoints();
  struct Point {
    PointResult result;
    std::uint64_t trials = 0;  ///< those of the checkpoint too
    store::Table cost = {};    ///< add_cost()
  };
  Point compute(std::size_t point);

 private:
  const RunPlan& run_;
  const montecarlo::RunOptions options_;
  const Checkpoint& checkpoint_;
  SweepProgress progress_;
  std::unique_ptr<class KeptPoints> kept_points_;
};

/// Prepares and runs the points, several at a time, and puts their tables together in order of the points: the sweep's
/// keys become the first columns of every table and the first axes of every map. Streams of the result compute while
/// they are read, and throw Interrupted when options.stop is set. Fills provenance from the config, but for versions
/// and command, and not RunInfo. options.progress gets the trials done and expected over all points. `trials` gets the
/// trials in the result, those of the checkpoint too.
store::Result execute(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint = {},
                      std::uint64_t* trials = nullptr);

}  // namespace surveymc::study
