#include "cli/sweep_status.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "cli/progress.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "study/point_failure.h"
#include "study/point_result_bytes.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 5;    // points of each kind that are named
constexpr std::size_t kMostFailed = 20;  // reasons that are kept

/// Time since the epoch, s.
double now_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

struct Times {
  double made = kNaN, written = kNaN;  ///< s since the epoch; NaN: not known
};

Times times_of(const fs::path& path) {
  struct statx s {};
  if (statx(AT_FDCWD, path.c_str(), 0, STATX_BTIME | STATX_MTIME, &s) != 0) return {};
  const auto seconds = [](const struct statx_timestamp& t) {
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  Times times;
  if ((s.stx_mask & STATX_BTIME) != 0) times.made = seconds(s.stx_btime);
  if ((s.stx_mask & STATX_MTIME) != 0) times.written = seconds(s.stx_mtime);
  return times;
}

/// Length of what intervals of time cover together.
double covered(std::vector<std::pair<double, double>> intervals) {
  std::sort(intervals.begin(), intervals.end());
  double length = 0, upto = -1e300;
  for (const auto& [begin, end] : intervals) {
    if (end <= upto) continue;
    length += end - std::max(begin, upto);
    upto = end;
  }
  return length;
}

void add(VerdictCounts& sum, const VerdictCounts& counts) {
  sum.agrees += counts.agrees;
  sum.differs += counts.differs;
  sum.undecided += counts.undecided;
  sum.findings += counts.findings;
  sum.unexpected += counts.unexpected;
  sum.unexpected_undecided += counts.unexpected_undecided;
  sum.judged = sum.judged || counts.judged;
  for (const auto& [margin, n] : counts.agrees_within) sum.agrees_within[margin] += n;
  for (const auto& [margin, n] : counts.differs_beyond) sum.differs_beyond[margin] += n;
}

std::string name_of(const study::RunPlan& run, std::uint64_t point) {
  std::string name;
  for (const config::SweepValue& v : run.config.sweep_values(point)) {
    const auto* number = std::get_if<double>(&v.value);
    name += fmt::format("{}{} = {}", name.empty() ? "" : ", ", v.key,
                        number ? fmt::format("{:.6g}", *number) : std::get<std::string>(v.value));
  }
  return name;
}

std::string point_words(const SweepStatus& s, std::uint64_t point) {
  const auto name = s.names.find(point);
  return name == s.names.end() || name->second.empty() ? fmt::format("point {}", point)
                                                       : fmt::format("point {} ({})", point, name->second);
}

}  // namespace

/// What journals have.
struct SweepWatch::Kept {
  std::map<std::uint64_t, std::vector<montecarlo::Subtree>> nodes;
  std::map<std::uint64_t, std::string> results;
};

SweepWatch::SweepWatch(study::RunPlan run) : run_(std::move(run)) {
  if (!run_.is_large()) costs_.emplace(run_);
}

double SweepWatch::cost(std::uint64_t first, std::uint64_t end) const {
  return costs_ ? costs_->before(end) - costs_->before(first) : static_cast<double>(end - first);
}

void SweepWatch::judge(std::uint64_t point, const store::Result& result) {
  judged_.insert(point);
  for (const store::Table& t : result.tables)
    if (t.name == study::kFailedPoints) {
      ++failed_count_;
      if (failed_.size() < kMostFailed) failed_[point] = t.word("reason", 0);
      return;
    }
  add(verdicts_, count_verdicts(result.tables));
}

void SweepWatch::judge_journals(Kept& kept, Clock::time_point until) {
  const std::atomic<bool> at_once = true;  // nothing is computed for a point that is not at its end
  montecarlo::RunOptions options;
  options.stop = stop_flag();
  const auto tables_of = [&](std::uint64_t point, study::PointResult r) {
    store::Result result;
    result.tables = study::placed_in_sweep(run_, point, std::move(r)).tables;
    return result;
  };
  for (auto& [point, bytes] : kept.results)
    if (!judged_.contains(point) && point < run_.point_count() && Clock::now() < until)
      judge(point, tables_of(point, study::point_result_from_bytes(bytes)));
  for (auto& [point, nodes] : kept.nodes) {
    if (judged_.contains(point) || point >= run_.point_count() || Clock::now() >= until) continue;
    std::uint64_t trials = 0;
    for (const montecarlo::Subtree& n : nodes) trials += n.tally.trials;
    const std::shared_ptr<const study::PointPlan> plan = run_.plan(point);
    const bool may_be_whole = trials >= (plan->looks().empty() ? plan->trials() : plan->looks().front());
    if (const auto before = not_whole_.find(point);
        !may_be_whole || (before != not_whole_.end() && before->second == trials))
      continue;
    const std::shared_ptr<const study::StudyPoint> prepared = run_.prepare(point, options);
    try {
      montecarlo::RunOptions only_merge = options;
      only_merge.stop = &at_once;
      only_merge.threads = 1;
      study::Checkpoint checkpoint;
      checkpoint.finished[point] = nodes;
      const stats::Tally tally = study::point_tally(run_, point, *prepared, only_merge, checkpoint);
      judge(point, tables_of(point, study::point_report(prepared, tally, options)));
    } catch (const Interrupted&) {
      if (*stop_flag()) throw;
      not_whole_[point] = trials;
    }
  }
}

void SweepWatch::judge_parts(const std::vector<ListedPart>& parts, const study::Coverage& there,
                             Clock::time_point until) {
  montecarlo::RunOptions options;
  options.stop = stop_flag();
  options.threads = 1;
  std::map<std::uint64_t, std::vector<std::pair<const ListedPart*, std::size_t>>> shards;
  const auto look_at = [&](std::uint64_t point, std::vector<checkpoint::PartPiece> pieces) {
    store::Result result;
    result.tables =
        study::placed_in_sweep(run_, point, study::merged_point(run_, point, std::move(pieces), options)).tables;
    judge(point, result);
  };
  const PointSet open = there.missing(run_.point_count());
  for (const ListedPart& part : parts) {
    if (Clock::now() >= until) return;
    if (judged_parts_.contains(part.path.string())) continue;
    checkpoint::PartReader reader(part.path);
    bool is_all = true;
    for (std::size_t i = 0; i < reader.pieces().size(); ++i) {
      const checkpoint::PieceEntry& e = reader.pieces()[i];
      if (judged_.contains(e.point)) continue;
      if (!e.whole && !e.failed && e.blocks_in_all > 0) {
        if (!open.contains(e.point)) shards[e.point].emplace_back(&part, i);
        is_all = false;
      } else if (Clock::now() < until) {
        look_at(e.point, {reader.piece(i)});
      } else {
        is_all = false;
      }
    }
    if (is_all) judged_parts_.insert(part.path.string());
  }
  for (const auto& [point, places] : shards) {
    if (Clock::now() >= until) return;
    std::vector<checkpoint::PartPiece> pieces;
    for (const auto& [part, i] : places) pieces.push_back(checkpoint::PartReader(part->path).piece(i));
    look_at(point, std::move(pieces));
  }
}

void SweepWatch::note_times(const SweepStatus& status) {
  const double now = std::chrono::duration<double>(Clock::now() - start_).count();
  for (const auto& [point, share] : status.begun)
    if (const auto [at, is_new] = seen_.try_emplace(point); is_new && !is_first_) at->second.begun_s = now;
  for (auto& [point, seen] : seen_)
    if (std::isnan(seen.done_s) && status.done.contains(point)) seen.done_s = now;
}

void SweepWatch::add_slowest(SweepStatus& status, const std::vector<ListedPart>& parts) const {
  for (const ListedPart& p : parts) status.slowest.emplace_back(p.path.filename().string(), p.head.elapsed_s);
  for (const auto& [point, seen] : seen_)
    if (seen.done_s > seen.begun_s) {
      status.names[point] = name_of(run_, point);
      status.slowest.emplace_back(point_words(status, point), seen.done_s - seen.begun_s);
    }
  std::stable_sort(status.slowest.begin(), status.slowest.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  if (status.slowest.size() > kMostNamed) status.slowest.resize(kMostNamed);
}

SweepStatus SweepWatch::look(const std::vector<ListedPart>& parts, const std::vector<fs::path>& journals,
                             double seconds) {
  SweepStatus s;
  s.title = run_.config.title();
  s.experiment = run_.experiment.name();
  s.config_hash = run_.config.source_hash();
  s.points = run_.point_count();
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));

  // what is there
  study::Coverage there;
  std::vector<std::pair<double, double>> worked;
  double last = kNaN;
  const auto note_written = [&](const Times& t) { last = std::isnan(last) ? t.written : std::max(last, t.written); };
  for (const ListedPart& p : parts) {
    add_to(there, p);
    const Times t = times_of(p.path);
    worked.emplace_back(t.written - p.head.elapsed_s, t.written);
    note_written(t);
  }
  Kept kept;
  for (const fs::path& path : journals) {
    std::optional<checkpoint::JournalLook> look = checkpoint::look_at_journal(path);
    if (!look) continue;
    const Times t = times_of(path);
    constexpr double kBefore = 5;  // s: a run works for about this time before its journal is made
    if (t.written >= t.made) worked.emplace_back(t.made - kBefore, t.written);
    note_written(t);
    for (auto& [point, nodes] : look->finished)
      std::move(nodes.begin(), nodes.end(), std::back_inserter(kept.nodes[point]));
    kept.results.merge(look->points);
  }
  for (auto& [point, nodes] : kept.nodes) {
    nodes = montecarlo::disjoint_subtrees(std::move(nodes));
    if (point >= s.points) continue;
    const std::shared_ptr<const study::PointPlan> plan = run_.plan(point);
    const std::uint64_t all = montecarlo::all_blocks(plan->trials(), plan->block_trials()).end;
    for (const montecarlo::Subtree& n : nodes) {
      checkpoint::PieceEntry entry;
      entry.point = point;
      entry.blocks = {n.first_block(), std::min(n.end_block(), all)};
      entry.blocks_in_all = all;
      there.add(entry);
      s.begun[point] += static_cast<double>(n.tally.trials) / static_cast<double>(plan->trials());
    }
    s.may_end_early = s.may_end_early || !plan->looks().empty();
  }
  for (const auto& [point, bytes] : kept.results) there.add(checkpoint::PointRange{point, point + 1, 1});

  // verdicts, which also tell of a stopping rule that has ended a point
  judge_parts(parts, there, until);
  judge_journals(kept, until);
  for (const auto& [point, nodes] : kept.nodes)
    if (judged_.contains(point)) there.add(checkpoint::PointRange{point, point + 1, 1});
  s.done = there.missing(s.points).others(s.points);
  std::erase_if(s.begun, [&](const auto& p) { return s.done.contains(p.first); });
  for (const auto& [point, share] : s.begun)
    if (s.names.size() < kMostNamed) s.names[point] = name_of(run_, point);
  s.verdicts = verdicts_;
  s.judged = judged_.size();
  s.failed = failed_;
  s.failed_count = failed_count_;
  for (const auto& [point, reason] : failed_) s.names[point] = name_of(run_, point);
  note_times(s);
  add_slowest(s, parts);

  // time
  double work = 0;
  for (const auto& [first, end] : s.done.ranges()) work += cost(first, end);
  for (const auto& [point, share] : s.begun) work += std::min(share, 1.0) * cost(point, point + 1);
  const double whole = cost(0, s.points);
  s.share = whole > 0 ? work / whole : 0;
  s.computed_s = covered(std::move(worked));
  s.age_s = now_s() - last;
  const double now = std::chrono::duration<double>(Clock::now() - start_).count();
  if (is_first_) first_work_ = last_work_ = work;
  if (work > last_work_) {
    last_work_ = work;
    last_work_s_ = now;
  }
  is_first_ = false;
  if (last_work_ > first_work_)  // as it goes while we look
    s.left_s = last_work_s_ * (whole - work) / (last_work_ - first_work_);
  else if (work > 0 && s.computed_s > 0)
    s.left_s = s.computed_s * (whole - work) / work;
  return s;
}

std::vector<std::string> status_lines(const SweepStatus& s) {
  std::vector<std::string> lines;
  const std::uint64_t done = s.done.count();
  lines.push_back(fmt::format("{} of {} points done, {:.0f} % of the work{}", done, s.points, std::floor(100 * s.share),
                              s.finished ? "; the result is written" : ""));
  if (!s.begun.empty()) {
    std::vector<std::string> words;
    for (const auto& [point, share] : s.begun) {
      if (words.size() == kMostNamed) break;
      words.push_back(fmt::format("{} {:.0f} %", point_words(s, point), std::floor(100 * std::min(share, 1.0))));
    }
    const std::size_t more = s.begun.size() - words.size();
    lines.push_back(fmt::format("in work: {}{}{}", fmt::join(words, ", "),
                                more > 0 ? fmt::format(" and {} more", more) : "",
                                s.may_end_early ? "; at most: a stopping rule may end them before" : ""));
  }
  if (s.failed_count > 0)
    lines.push_back(fmt::format("{} cannot be run; the first: {}: {}", counted(s.failed_count, "point"),
                                point_words(s, s.failed.begin()->first), s.failed.begin()->second));
  if (const std::string words = in_words(s.verdicts); !words.empty())
    lines.push_back(fmt::format("verdicts of {}: {}",
                                s.judged < done ? fmt::format("{} of them", s.judged) : counted(s.judged, "point"),
                                words));
  if (!s.slowest.empty()) {
    std::vector<std::string> words;
    for (const auto& [name, seconds] : s.slowest) words.push_back(fmt::format("{} {}", name, format_duration(seconds)));
    lines.push_back(fmt::format("slowest: {}", fmt::join(words, ", ")));
  }
  if (!std::isnan(s.age_s))
    lines.push_back(fmt::format("computed for {}; the last work was kept {} ago{}", format_duration(s.computed_s),
                                format_duration(std::max(0.0, s.age_s)),
                                s.finished || std::isnan(s.left_s) || s.share >= 1
                                    ? ""
                                    : fmt::format("; about {} left at this pace", format_duration(s.left_s))));
  return lines;
}

}  // namespace surveymc::cli
