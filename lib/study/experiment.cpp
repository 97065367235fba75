#include "study/experiment.h"

#include <algorithm>
#include <stdexcept>

#include "base/error.h"
#include "base/units.h"
#include "compare/family.h"
#include "compare/sensitivity.h"
#include "compare/warnings.h"
#include "montecarlo/threads.h"
#include "montecarlo/workers.h"
#include "study/cost.h"
#include "study/input_tables.h"
#include "study/kept_points.h"
#include "study/point_failure.h"
#include "study/sweep_columns.h"
#include "study/tally_sizes.h"

namespace surveymc::study {

namespace {

/// The seed; 0 where a config has none, because it draws nothing.
std::uint64_t seed_of(const config::Config& config) { return config.has_seed() ? config.seed() : 0; }

/// Tables that only some studies have, for a message that says which.
struct OfferedTable {
  const char* table;
  std::vector<random::StudyId> studies;
  const char* otherwise;
};
const std::vector<OfferedTable>& offered_tables() {
  using enum random::StudyId;
  static const std::vector<OfferedTable> tables{
      {"stop",
       {msa_position, msa_benefit, sensor_monte_carlo, vertical_well, error_model_monte_carlo, chained_multistation,
        gross_error_detection, collision, rare_event},
       "a fixed number of trials: give `trials`"},
      {"calibration", {msa_position, msa_benefit, chained_multistation}, "no estimator that claims a distribution"}};
  return tables;
}

void require_offered(const config::ConfigReader& reader, const Experiment& experiment) {
  for (const OfferedTable& t : offered_tables()) {
    if (!reader.has(t.table) || std::find(t.studies.begin(), t.studies.end(), experiment.id) != t.studies.end())
      continue;
    std::string names;
    for (const random::StudyId id : t.studies) names += (names.empty() ? "" : ", ") + std::string(random::name_of(id));
    reader.fail(t.table, fmt::format("{} has {}; the table is of {}", experiment.name(), t.otherwise, names));
  }
}

}  // namespace

std::unique_ptr<PointPlan> read_point(const Experiment& experiment, const config::Config& config,
                                      config::ConfigReader& reader) {
  require_offered(reader, experiment);
  std::unique_ptr<PointPlan> plan = experiment.read(reader, random::StudySeed{seed_of(config), experiment.id});
  if (plan->trials() > 0) config.seed();  // trials draw: there must be one
  return plan;
}

std::shared_ptr<const RunPlan::ReadPoint> RunPlan::read(std::size_t point) const {
  {
    const std::scoped_lock lock(*reading_);
    if (const auto it = read_.find(point); it != read_.end()) return it->second;
  }
  config::ConfigReader reader = config.reader(point);
  const auto p = std::make_shared<ReadPoint>();
  p->plan = read_point(experiment, config, reader);
  // A study that maps places has a model without a place.
  if (reader.has("field.model") && reader.has("field.latitude_deg")) p->placed = scenario::read_placed_field(reader);
  const bool is_family =
      !reader.has("verdict.family") || reader.text("verdict.family", config::kMeaningElsewhere) != "none";
  const std::vector<store::Axis> own = p->plan->map_axes();

  const std::scoped_lock lock(*reading_);
  is_family_ = is_family;
  if (!axes_) axes_.emplace(point, own);
  const std::vector<store::Axis>& first = axes_->second;
  for (std::size_t a = 0; a < std::max(first.size(), own.size()); ++a)
    require(a < first.size() && a < own.size() && first[a].name == own[a].name && first[a].values == own[a].values,
            "sweep: point {} has other values of the map axis {} than point {}: give all of them as the grid itself",
            point, (a < own.size() ? own : first)[a].name, axes_->first);
  if (is_large()) {
    constexpr std::size_t kMostKept = 1024;  // more than are computed at a time
    if (read_.size() >= kMostKept) read_.clear();
    if (!first_trials_ || point < first_trials_->first) first_trials_.emplace(point, p->plan->trials());
  }
  return read_.emplace(point, p).first->second;
}

void RunPlan::forget(std::size_t point) const {
  const std::scoped_lock lock(*reading_);
  if (is_large()) read_.erase(point);
}

std::shared_ptr<const PointPlan> RunPlan::plan(std::size_t point) const { return read(point)->plan; }

std::optional<scenario::PlacedField> RunPlan::placed(std::size_t point) const { return read(point)->placed; }

std::uint64_t RunPlan::trials_of(std::size_t point) const {
  if (!is_large()) return plan(point)->trials();
  const auto known = [this] {
    const std::scoped_lock lock(*reading_);
    return first_trials_ ? std::optional(first_trials_->second) : std::nullopt;
  };
  if (const std::optional<std::uint64_t> trials = known()) return *trials;
  try {
    plan(point);
  } catch (const InputError&) {  // a point that fails has no trials; another one will tell
    return 0;
  }
  return *known();
}

std::uint64_t RunPlan::total_trials() const {
  if (is_large()) return trials_of(0) * point_count();
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < point_count(); ++i) n += plan(i)->trials();
  return n;
}

std::shared_ptr<const StudyPoint> RunPlan::prepare(std::size_t point, const montecarlo::RunOptions& options) const {
  if (options.stop && *options.stop) throw Interrupted("stopped before all points were prepared");
  const std::shared_ptr<const PointPlan> of_point = plan(point);
  try {
    montecarlo::RunOptions sharing = options;
    sharing.shared = shared_.get();
    return of_point->prepare(sharing);
  } catch (const InputError& e) {
    if (point_count() == 1) throw;
    throw InputError(fmt::format("{} (point {} of the sweep)", e.what(), point));
  }
}

RunPlan open_run(const Experiment& experiment, config::Config config) { return {experiment, std::move(config)}; }

RunPlan read_run(const Experiment& experiment, config::Config config, const std::atomic<bool>* stop, int threads) {
  RunPlan run = open_run(experiment, std::move(config));
  const auto look = [&] {
    if (stop && *stop) throw Interrupted("stopped before all points were read");
  };
  run.config.check_sweep(look);
  if (run.is_large()) {
    for (const std::size_t i : run.config.sample_points()) {
      look();
      ++run.sample.points;
      try {
        run.plan(i);
      } catch (const InputError& e) {
        if (run.sample.invalid++ == 0) run.sample.first_reason = e.what();
      }
    }
    require(run.sample.invalid < run.sample.points, "{}", run.sample.first_reason);
    return run;
  }
  look();
  if (run.point_count() > 0) run.plan(0);  // with whose axes the others are compared
  montecarlo::compute_in_order(
      run.point_count(), montecarlo::threads_for(threads, run.point_count()),
      [&](std::size_t i) {
        look();
        return run.plan(i);
      },
      [](std::size_t, const std::shared_ptr<const PointPlan>&) {});
  return run;
}

namespace {

void add_point(std::vector<store::Table>& all, std::vector<store::Table>&& tables) {
  for (store::Table& t : tables) {
    const auto same = std::find_if(all.begin(), all.end(), [&](const store::Table& o) { return o.name == t.name; });
    if (same == all.end()) {
      all.push_back(std::move(t));
    } else {
      const auto named_alike = [](const store::Column& x, const store::Column& y) { return x.name == y.name; };
      require(std::equal(same->columns.begin(), same->columns.end(), t.columns.begin(), t.columns.end(), named_alike),
              "table {}: points of the sweep fill it with other columns: run them apart", t.name);
      store::append_rows(*same, std::move(t));
    }
  }
}

void add_maps(std::vector<store::Map>& all, std::vector<store::Map>&& maps, const std::vector<store::Axis>& sweep) {
  for (store::Map& m : maps) {
    const auto same = std::find_if(all.begin(), all.end(), [&](const store::Map& o) { return o.name == m.name; });
    if (same != all.end()) {  // points come in product order, last key fastest: appending is the right place
      drop_varying_axes(*same, sweep.size(), m, 0);
      if (same->unit != m.unit) same->unit = "mixed";  // a sweep over what decides the unit
      same->values.insert(same->values.end(), m.values.begin(), m.values.end());
      continue;
    }
    m.axes.insert(m.axes.begin(), sweep.begin(), sweep.end());
    all.push_back(std::move(m));
  }
}

/// The streams of all points, one after the other: points come in product order, last key fastest.
class Streams {
 public:
  void add(std::vector<store::MapStream>&& streams, const std::vector<store::Axis>& sweep) {
    if (all_.empty()) {
      all_.resize(streams.size());
      for (std::size_t i = 0; i < streams.size(); ++i)
        for (store::Map m : streams[i].maps) {
          m.axes.insert(m.axes.begin(), sweep.begin(), sweep.end());
          all_[i].maps.push_back(std::move(m));
        }
      points_.resize(streams.size(), std::vector<store::MapStream>(missing_));
      for (const store::MapStream& one : streams)
        of_point_.push_back(one.maps.empty() ? 1 : store::map_size(one.maps.front()));
    }
    for (std::size_t i = 0; i < streams.size(); ++i) {
      for (std::size_t m = 0; m < streams[i].maps.size(); ++m)
        if (all_[i].maps[m].unit != streams[i].maps[m].unit) all_[i].maps[m].unit = "mixed";
      points_[i].push_back(std::move(streams[i]));
    }
  }

  /// A point without values.
  void add_missing() {
    ++missing_;
    for (auto& points : points_) points.push_back({});
  }

  std::vector<store::MapStream> take(const std::atomic<bool>* stop) {
    for (std::size_t i = 0; i < all_.size(); ++i)
      all_[i].values = [points = std::move(points_[i]), stop, of_point = of_point_[i], maps = all_[i].maps.size()](
                           std::size_t first, std::size_t count) {
        if (stop && *stop) throw Interrupted("stopped before all maps were written");
        std::vector<std::vector<double>> out;
        while (count > 0) {
          const std::size_t at = first % of_point, n = std::min(count, of_point - at);
          const store::MapStream& point = points[first / of_point];
          std::vector<std::vector<double>> part =
              point.values ? point.values(at, n) : std::vector<std::vector<double>>(maps, std::vector<double>(n, kNaN));
          if (out.empty()) {
            out = std::move(part);
          } else {
            for (std::size_t m = 0; m < out.size(); ++m) out[m].insert(out[m].end(), part[m].begin(), part[m].end());
          }
          first += n;
          count -= n;
        }
        return out;
      };
    return std::move(all_);
  }

 private:
  std::vector<store::MapStream> all_;
  std::vector<std::vector<store::MapStream>> points_;  // [stream][point]; without values: missing
  std::vector<std::size_t> of_point_;                  // [stream] values of a point
  std::size_t missing_ = 0;                            // before the first point with values
};

}  // namespace

montecarlo::RunOptions options_of_point(montecarlo::RunOptions options, const RunPlan& run, std::size_t point,
                                        checkpoint::Journal* journal) {
  options.block_trials = run.plan(point)->block_trials();
  options.point = point;
  if (!journal) return options;
  options.save_due = [journal] { return journal->due(); };
  options.save = [journal, point](montecarlo::OrderedMerge& merge) {
    merge.take_unsaved([&](const montecarlo::Subtree& s) { journal->add(point, s); });
    if (journal->due()) journal->write();
  };
  return options;
}

void require_proposal(const StudyPoint& point, const stats::Tally& tally, const std::string& whose) {
  if (tally.proposal == 0 || tally.proposal == point.proposal()) return;
  throw IoError(fmt::format(
      "{}: its trials were drawn from another preparation ({:016x}) than this run's ({:016x}), so that their "
      "weights do not add up: must be of this config, seed and program; remove it, and run it again",
      whose, tally.proposal, point.proposal()));
}

std::vector<montecarlo::Subtree> finished_blocks(const Checkpoint& checkpoint, std::size_t index,
                                                 const StudyPoint& point) {
  const auto kept = checkpoint.finished.find(index);
  if (kept == checkpoint.finished.end()) return {};
  const TallySizes sizes(point, TallySizes::kTrials);  // with fewer, none would be finished before the run
  for (const montecarlo::Subtree& s : kept->second) {
    const auto in = checkpoint.drawn_in.find({index, s.tally.proposal});
    const std::string whose = in == checkpoint.drawn_in.end() ? "a journal beside the output" : in->second.string();
    require_proposal(point, s.tally, whose);
    sizes.require(s.tally, whose);
  }
  return kept->second;
}

stats::Tally point_tally(const RunPlan& run, std::size_t index, const StudyPoint& point,
                         const montecarlo::RunOptions& options, const Checkpoint& checkpoint,
                         std::atomic<double>* seconds) {
  const std::shared_ptr<const PointPlan> of_point = run.plan(index);
  const PointPlan& plan = *of_point;
  if (plan.trials() == 0) return {};
  const auto run_block = [&](montecarlo::TrialBlock b) {
    const double before = thread_seconds();
    stats::Tally tally = point.run_block(b);
    if (seconds) *seconds += thread_seconds() - before;
    return tally;
  };
  return montecarlo::run_blocks(plan.trials(), run_block, options_of_point(options, run, index, checkpoint.journal),
                                {plan.looks(), [&](const stats::Tally& t) { return point.trials_needed(t); }},
                                finished_blocks(checkpoint, index, point));
}

PointResult point_report(const std::shared_ptr<const StudyPoint>& point, const stats::Tally& tally,
                         const montecarlo::RunOptions& options) {
  PointResult r = point->report(tally, options);
  for (store::MapStream& s : r.streams)
    s.values = [point, values = std::move(s.values)](std::size_t first, std::size_t count) {
      return values(first, count);
    };
  return r;
}

int threads_of(const RunPlan& run, const checkpoint::PointRange& points, const montecarlo::RunOptions& options) {
  if (options.workers && options.workers->count() > 0) return 1;
  std::size_t work = points.count();
  if (!run.is_large()) {
    work = 0;
    for (std::uint64_t i = 0; i < points.count(); ++i) {
      const std::shared_ptr<const PointPlan> plan = run.plan(points.point(i));
      work += std::max<std::size_t>(1, montecarlo::all_blocks(plan->trials(), plan->block_trials()).end);
    }
  }
  return montecarlo::threads_for(options.threads, work);
}

montecarlo::RunOptions SweepProgress::of_point(montecarlo::RunOptions options, std::uint64_t trials) {
  if (!told_) return options;
  options.progress = [this, done_before = std::uint64_t{0}, expected_before = trials](std::uint64_t done,
                                                                                      std::uint64_t expected) mutable {
    const std::scoped_lock lock(telling_);
    done_ += done - done_before;
    expected_ += expected - expected_before;
    done_before = done;
    expected_before = expected;
    told_(done_, expected_);
  };
  return options;
}

ComputedPoints::ComputedPoints(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint)
    : run_(run),
      options_(options),
      checkpoint_(checkpoint),
      progress_(options, run.total_trials()),
      kept_points_(std::make_unique<KeptPoints>(checkpoint, run.point_count())) {}

ComputedPoints::~ComputedPoints() = default;

ComputedPoints::Point ComputedPoints::compute(std::size_t i) {
  try {
    const bool draws = run_.plan(i)->trials() > 0;
    if (!draws)
      if (std::optional<PointResult> earlier = kept_points_->find(i)) return {*std::move(earlier)};
    const montecarlo::RunOptions of_point = progress_.of_point(options_, run_.trials_of(i));
    const std::shared_ptr<const StudyPoint> point = run_.prepare(i, of_point);
    std::atomic<double> seconds = 0;
    const stats::Tally tally = point_tally(run_, i, *point, of_point, checkpoint_, &seconds);
    const auto of_earlier = checkpoint_.finished.find(i);
    if (draws && of_earlier != checkpoint_.finished.end())
      TallySizes(*point, run_.plan(i)->trials()).require_whole(tally, "a journal beside the output");
    Point p{point_report(point, tally, of_point), tally.trials};
    if (!draws) {
      p.result = kept_points_->keep(i, std::move(p.result));
      return p;
    }
    std::uint64_t kept = 0;
    if (of_earlier != checkpoint_.finished.end())
      for (const montecarlo::Subtree& n : of_earlier->second) kept += n.tally.trials;
    // The time of other ranks is not known here.
    if (tally.trials > kept && !options_.workers)
      add_cost(p.cost, p.result.tables, run_.config.sweep_values(i), seconds, tally.trials - kept, tally.trials);
    return p;
  } catch (const InputError& e) {
    if (!run_.is_large()) throw;
    return {failed_point(i, without_place(e.what()))};
  }
}

namespace {

/// Says in column `expected` that either verdict is fine, where the config expects none.
void mark_approximations(store::Table& t, const std::vector<std::string>& approximations) {
  store::Column *expected = nullptr, *formulation = nullptr;
  for (store::Column& c : t.columns) {
    if (c.name == "expected") expected = &c;
    if (c.name == "formulation") formulation = &c;
  }
  if (!expected || !t.find_column("verdict")) return;
  auto& words = std::get<std::vector<std::string>>(expected->values);
  for (std::size_t row = 0; row < words.size(); ++row) {
    const bool is_known =
        t.name == "claims" || (formulation && std::find(approximations.begin(), approximations.end(),
                                                        t.word("formulation", row)) != approximations.end());
    if (is_known && words[row].empty() && !t.word("verdict", row).empty()) words[row] = store::kEither;
  }
}

}  // namespace

PointResult placed_in_sweep(const RunPlan& run, std::size_t point, PointResult r) {
  for (store::Table& t : r.tables) mark_approximations(t, run.experiment.approximations);
  if (!is_failed(r)) {
    if (const std::optional<scenario::PlacedField> field = run.placed(point))
      for (store::Table& t : scenario::field_tables(*field)) r.tables.push_back(std::move(t));
    if (!run.config.is_product() && (!r.maps.empty() || !r.streams.empty())) r.tables.push_back(table_of_point(point));
  }
  const std::vector<config::SweepValue> sweep = run.config.sweep_values(point);
  for (std::vector<store::Table>* tables : {&r.tables, &r.samples})
    for (store::Table& t : *tables)
      if (t.name != compare::kWarningsTable) t = with_sweep_columns(std::move(t), sweep);
  return r;
}

store::Result result_without_tables(const RunPlan& run) {
  store::Result result;
  result.inputs = input_tables(run.config);
  store::Provenance& p = result.provenance;
  p.title = run.config.title().empty() ? run.experiment.summary : run.config.title();
  p.experiment = run.experiment.name();
  p.config = run.config.resolved_text();
  p.config_hash = run.config.hash();
  p.seed = seed_of(run.config);
  p.trials = run.point_count() == 0 ? 0 : run.trials_of(0);
  return result;
}

void add_answer(const Experiment& experiment, store::Result& result) {
  compare::Answer answer;
  try {
    const compare::Rows severe = compare::Rows(result.tables, compare::kWarningsTable).where("severity", "severe");
    if (!severe.empty())
      answer.say("Read the severe warnings first ({}): these numbers may not hold.", {severe.count()});
    if (experiment.answer) experiment.answer(answer, result);
  } catch (const compare::LongTable& t) {
    answer.say("Table {} has {} rows, too many for a sentence: surveymc show prints them.", {t.name, t.rows});
  }
  answer.say_failures(result.tables);
  if (!answer.empty()) result.tables.insert(result.tables.begin(), answer.table());
}

namespace {

/// Results of neighbouring points, in order. The thread that computes the points puts their rows together, so that less
/// is left for the one thread that takes them.
struct PointGroup {
  struct Point {
    bool has_failed = false;
    std::vector<compare::Warning> warnings = {};
    std::vector<store::Map> maps = {};
    std::vector<store::MapStream> streams = {};
  };
  std::vector<store::Table> tables = {}, samples = {};
  std::vector<Point> points = {};
  std::uint64_t trials = 0;
  store::Table cost = {};
  std::size_t values = 0;

  /// `r`: of placed_in_sweep().
  void add(PointResult r) {
    for (const auto* of_point : {&r.tables, &r.samples})
      for (const store::Table& t : *of_point) values += t.rows() * t.columns.size();
    for (const store::Map& m : r.maps) values += m.values.size();
    Point& p = points.emplace_back();
    p.has_failed = is_failed(r);
    std::erase_if(r.tables, [&](const store::Table& t) {
      if (t.name != compare::kWarningsTable) return false;
      for (compare::Warning& w : compare::warnings_of(t)) p.warnings.push_back(std::move(w));
      return true;
    });
    add_point(tables, std::move(r.tables));
    add_point(samples, std::move(r.samples));
    p.maps = std::move(r.maps);
    p.streams = std::move(r.streams);
  }
};

/// Of how many of `count` points the results are put together by one thread: more where points are many, quick and
/// small, so that memory holds little more than without groups. `values`: of the largest point so far.
std::size_t group_size(std::size_t count, int threads, std::uint64_t trials, std::size_t values) {
  constexpr std::size_t kMost = 16, kLeastGroups = 8, kMostValues = std::size_t{1} << 15;
  constexpr std::uint64_t kQuick = 512;  // trials
  if (trials > kQuick) return 1;
  const std::size_t most = std::min(kMost, kMostValues / std::max<std::size_t>(1, values));
  return std::clamp<std::size_t>(count / (kLeastGroups * static_cast<std::size_t>(threads)), 1,
                                 std::max<std::size_t>(1, most));
}

/// Puts the results of points together, which come in order.
class Assembly {
 public:
  explicit Assembly(const RunPlan& run)
      : run_(run),
        axes_(sweep_axes(run.config)),
        sensitivity_(config::sensitivity_rule_of(run.config.source_text(), "the config")) {}

  void add(PointGroup group) {
    const bool has_values =
        std::any_of(group.points.begin(), group.points.end(), [](const auto& p) { return !p.has_failed; });
    if (sensitivity_ && has_values && !is_checked_) compare::check_sensitivity(*sensitivity_, group.tables);
    is_checked_ = is_checked_ || has_values;
    add_point(tables_, std::move(group.tables));
    add_point(samples_, std::move(group.samples));
    for (PointGroup::Point& p : group.points) add(std::move(p));
  }

  store::Result result(const std::atomic<bool>* stop) {
    store::Result result = result_without_tables(run_);
    result.tables = std::move(tables_);
    result.samples = std::move(samples_);
    result.maps = std::move(maps_);
    result.tables.push_back(warnings_table());
    if (run_.is_family()) compare::apply_family(result.tables);
    if (sensitivity_)
      result.tables.push_back(compare::sensitivity_table(*sensitivity_, result.tables, run_.point_count()));
    result.streams = streams_.take(stop);
    add_answer(run_.experiment, result);
    return result;
  }

 private:
  void add(PointGroup::Point p) {
    for (compare::Warning& w : p.warnings) {
      w.at = point_in_words(run_.config, point_);
      warnings_.add(std::move(w), point_);
    }
    ++point_;
    const std::size_t before = maps_.size();
    add_maps(maps_, std::move(p.maps), axes_);
    // A map that the point does not have is NaN there: of a point that failed all, else those that its keys ask for.
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      std::vector<double>& values = maps_[i].values;
      const std::size_t n = store::map_size(maps_[i]) / run_.point_count(), behind = (point_ - 1) * n;
      if (i >= before)
        values.insert(values.begin(), behind, kNaN);
      else if (values.size() == behind)
        values.insert(values.end(), n, kNaN);
    }
    if (p.has_failed) {
      streams_.add_missing();
      return;
    }
    streams_.add(std::move(p.streams), axes_);
  }

  /// Those of the input first. All points have been read by now, whoever has computed them.
  store::Table warnings_table() const {
    compare::WarningList all;
    for (const config::Remark& r : run_.config.remarks())
      if (r.is_warning)
        all.add({"warning", r.place, r.value, r.message, r.way_out, r.points, point_in_words(run_.config, r.point)});
    for (compare::Warning& w : compare::warnings_of(warnings_.table())) all.add(std::move(w));
    return all.table();
  }

  const RunPlan& run_;
  std::vector<store::Table> tables_, samples_;
  std::vector<store::Map> maps_;
  const std::vector<store::Axis> axes_;
  Streams streams_;
  compare::WarningList warnings_;  // of the points
  std::size_t point_ = 0;          // that comes next
  const std::optional<config::SensitivityRule> sensitivity_;
  bool is_checked_ = false;  // at the first point, not after hours
};

}  // namespace

store::Result assemble(const RunPlan& run, const std::function<PointResult(std::size_t)>& point_result,
                       const std::atomic<bool>* stop) {
  Assembly all(run);
  for (std::size_t i = 0; i < run.point_count(); ++i) {
    PointGroup one;
    one.add(placed_in_sweep(run, i, point_result(i)));
    all.add(std::move(one));
    run.forget(i);
  }
  return all.result(stop);
}

store::Result execute(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint,
                      std::uint64_t* trials) {
  Assembly all(run);
  store::Table cost;
  ComputedPoints points(run, options, checkpoint);
  const std::size_t count = run.point_count();
  const int threads = threads_of(run, {0, count, 1}, options);
  std::size_t values = 0;
  const auto compute_points = [&](std::size_t first, std::size_t end, std::size_t size) {
    const auto end_of = [&](std::size_t k) { return std::min(end, first + (k + 1) * size); };
    const auto compute = [&](std::size_t k) {
      PointGroup group;
      for (std::size_t i = first + k * size; i < end_of(k); ++i) {
        ComputedPoints::Point p = points.compute(i);
        group.trials += p.trials;
        if (!p.cost.columns.empty()) store::append_rows(group.cost, std::move(p.cost));
        group.add(placed_in_sweep(run, i, std::move(p.result)));
      }
      return group;
    };
    montecarlo::compute_in_order((end - first + size - 1) / size, threads, compute,
                                 [&](std::size_t k, PointGroup group) {
                                   values = std::max(values, group.values);
                                   if (trials) *trials += group.trials;
                                   if (!group.cost.columns.empty()) store::append_rows(cost, std::move(group.cost));
                                   all.add(std::move(group));
                                   for (std::size_t i = first + k * size; i < end_of(k); ++i) run.forget(i);
                                 });
  };
  const std::size_t alone = std::min(count, montecarlo::most_in_flight(threads));
  compute_points(0, alone, 1);
  if (alone < count) compute_points(alone, count, group_size(count - alone, threads, run.trials_of(0), values));
  store::Result result = all.result(options.stop);
  result.cost = std::move(cost);
  return result;
}

}  // namespace surveymc::study
