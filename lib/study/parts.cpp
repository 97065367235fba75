#include "study/parts.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/error.h"
#include "base/numerics.h"
#include "montecarlo/threads.h"
#include "study/kept_points.h"
#include "study/point_failure.h"
#include "study/point_result_bytes.h"
#include "study/tally_sizes.h"

namespace surveymc::study {

namespace {

montecarlo::BlockRange blocks_of(const PointPlan& point) {
  return montecarlo::all_blocks(point.trials(), point.block_trials());
}

std::string points_in_words(const RunPlan& run) {
  return fmt::format("the points of this config are numbered 0 to {}", run.point_count() - 1);
}

template <class... Args>
void require_choice(bool ok, fmt::format_string<Args...> format, Args&&... args) {
  if (!ok) throw BadChoice(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace

std::string part_name(const PartChoice& c) {
  std::string name;
  if (c.points) {
    const checkpoint::PointRange& p = *c.points;
    name = p.count() == 1 ? fmt::format("point-{:05}", p.first) : fmt::format("points-{:05}-{:05}", p.first, p.end);
    if (p.count() > 1 && p.stride > 1) name += fmt::format("-by-{:05}", p.stride);
  }
  if (c.shards > 1 || !c.points) name += fmt::format("{}shard-{}-of-{}", name.empty() ? "" : "-", c.shard, c.shards);
  return name;
}

void check_choice(const RunPlan& run, const PartChoice& c) {
  const checkpoint::PointRange range = c.range(run);
  if (range.count() == 1)
    require_choice(range.first < run.point_count(), "--point {}: {}", range.first, points_in_words(run));
  require_choice(range.count() > 0 && range.end <= run.point_count(), "--point {}:{}: {}", range.first, range.end,
                 range.count() == 0 ? "has no points: FIRST:END goes from FIRST to END - 1" : points_in_words(run));
  require_choice(c.shards > 0, "--shard {}/{}: there must be at least one shard", c.shard, c.shards);
  require_choice(c.shard < c.shards, "--shard {}/{}: shards are numbered 0 to {}", c.shard, c.shards,
                 c.shards - (c.shards > 0));
  if (c.points && c.shards == 1) return;
  // Of a large sweep the first point stands for the others, as only shards need them all.
  for (std::uint64_t i = 0; i < (run.is_large() ? 1 : range.count()); ++i) {
    const std::shared_ptr<const PointPlan> plan = run.plan(range.point(i));
    require_choice(plan->trials() > 0,
                   "--shard {}/{}: a config of {} has no trials to divide; divide it by --point (0 to {})", c.shard,
                   c.shards, run.experiment.name(), run.point_count() - 1);
    require_choice(
        plan->looks().empty(),
        "--shard {}/{}: this config ends by [stop], which looks at all trials so far, and a shard sees only its "
        "own; divide it by --point (0 to {}), or give trials instead of [stop]",
        c.shard, c.shards, run.point_count() - 1);
  }
}

void read_points(const RunPlan& run, const PartChoice& choice, const std::atomic<bool>* stop) {
  const checkpoint::PointRange range = choice.range(run);
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(range.count(), kMostReadWhole); ++i) {
    if (stop && *stop) throw Interrupted("stopped before all points were read");
    try {
      run.plan(range.point(i));
    } catch (const InputError&) {
      if (!run.is_large()) throw;
    }
  }
}

checkpoint::PartPiece part_piece(const RunPlan& run, const PartChoice& c, std::uint64_t point) {
  const std::shared_ptr<const PointPlan> plan = run.plan(point);
  const std::uint64_t blocks = blocks_of(*plan).end;
  const bool whole = blocks == 0 || !plan->looks().empty() || c.shards == 1;
  return {point, {blocks * c.shard / c.shards, blocks * (c.shard + 1) / c.shards}, blocks, whole};
}

std::vector<checkpoint::PartPiece> part_pieces(const RunPlan& run, const PartChoice& c) {
  std::vector<checkpoint::PartPiece> pieces;
  const checkpoint::PointRange range = c.range(run);
  for (std::uint64_t i = 0; i < range.count(); ++i) pieces.push_back(part_piece(run, c, range.point(i)));
  return pieces;
}

namespace {

/// Computes the piece of a part, or takes it from the checkpoint.
checkpoint::PartPiece computed_piece(const RunPlan& run, const PartChoice& choice, std::uint64_t number, bool is_only,
                                     const montecarlo::RunOptions& options, const Checkpoint& checkpoint) {
  checkpoint::PartPiece p = part_piece(run, choice, number);
  const std::shared_ptr<const PointPlan> plan = run.plan(number);
  if (!p.whole && p.blocks.first == p.blocks.end) return p;  // there are more shards than blocks
  const auto kept_point = checkpoint.points.find(number);
  if (plan->trials() == 0 && kept_point != checkpoint.points.end()) {
    p.result = kept_point->second;
    return p;
  }
  const std::shared_ptr<const StudyPoint> point = run.prepare(number, options);
  if (plan->trials() == 0) {
    p.result = point_result_to_bytes(point_report(point, {}, options));
    if (!is_only) keep_point(checkpoint.journal, number, p.result);  // else it is done by now
  } else if (p.whole) {
    p.subtrees.push_back({0, 0, point_tally(run, number, *point, options, checkpoint)});
  } else {
    p.subtrees = montecarlo::run_block_range(
        plan->trials(), p.blocks, [&](montecarlo::TrialBlock b) { return point->run_block(b); },
        options_of_point(options, run, number, checkpoint.journal), finished_blocks(checkpoint, number, *point));
  }
  return p;
}

}  // namespace

checkpoint::Part run_part(const RunPlan& run, const PartChoice& choice, const montecarlo::RunOptions& options,
                          const Checkpoint& checkpoint) {
  checkpoint::Part part;
  part.range = choice.range(run);
  part.shard = choice.shard;
  part.shards = choice.shards;
  const std::uint64_t count = part.range.count();
  const auto trials_of = [&](std::uint64_t point) {
    if (run.is_large()) return run.trials_of(point) / choice.shards;
    const std::shared_ptr<const PointPlan> plan = run.plan(point);
    return montecarlo::trials_in(part_piece(run, choice, point).blocks, plan->trials(), plan->block_trials());
  };
  std::uint64_t trials = 0;
  if (run.is_large())
    trials = trials_of(part.range.first) * count;
  else
    for (std::uint64_t i = 0; i < count; ++i) trials += trials_of(part.range.point(i));
  SweepProgress progress(options, trials);
  montecarlo::compute_in_order(
      count, threads_of(run, part.range, options),
      [&](std::size_t i) {
        const std::uint64_t number = part.range.point(i);
        try {
          return computed_piece(run, choice, number, count == 1, progress.of_point(options, trials_of(number)),
                                checkpoint);
        } catch (const InputError& e) {
          if (!run.is_large()) throw;
          checkpoint::PartPiece failed{number, {}, 0, true};
          failed.failure = without_place(e.what());
          return failed;
        }
      },
      [&](std::size_t i, checkpoint::PartPiece piece) {
        part.pieces.push_back(std::move(piece));
        run.forget(part.range.point(i));
      });
  part.title = run.config.title().empty() ? run.experiment.summary : run.config.title();
  part.experiment = run.experiment.name();
  part.config = run.config.source_text();
  part.key.config_hash = run.config.source_hash();
  part.inputs = run.config.inputs();
  part.texts = run.config.input_texts();
  part.references = run.config.input_references();
  // A table of all points is not copied into every part: it stays beside the config.
  const std::string table = run.config.sweep_file();
  for (auto it = part.texts.begin(); it != part.texts.end(); ++it)
    if (it->path == table && !table.empty()) {
      part.references.push_back(config::describe_text(it->path, it->text));
      part.texts.erase(it);
      break;
    }
  part.points = run.point_count();
  return part;
}

// ---------------------------------------------------------------------------------------------------------- coverage

void Coverage::add(const checkpoint::PointRange& range) {
  if (range.stride == 1) {
    whole_.add(range.first, range.end);
    return;
  }
  for (std::uint64_t i = 0; i < range.count(); ++i) whole_.add(range.point(i));
}

void Coverage::add(const checkpoint::PieceEntry& piece) {
  if (piece.whole) {
    whole_.add(piece.point);
    partial_.erase(piece.point);
    return;
  }
  if (whole_.contains(piece.point)) return;
  Blocks& b = partial_[piece.point];
  b.there.push_back(piece.blocks);
  b.in_all = piece.blocks_in_all;
  if (gaps(piece.point).empty()) {
    whole_.add(piece.point);
    partial_.erase(piece.point);
  }
}

PointSet Coverage::missing(std::uint64_t count) const { return whole_.others(count); }

std::vector<montecarlo::BlockRange> Coverage::gaps(std::uint64_t point) const {
  const auto it = partial_.find(point);
  if (it == partial_.end()) return {};
  std::vector<montecarlo::BlockRange> there = it->second.there, missing;
  std::sort(there.begin(), there.end(),
            [](montecarlo::BlockRange a, montecarlo::BlockRange b) { return a.first < b.first; });
  std::uint64_t reached = 0;
  for (const montecarlo::BlockRange& r : there) {
    if (r.first > reached) missing.push_back({reached, r.first});
    reached = std::max(reached, r.end);
  }
  if (reached < it->second.in_all) missing.push_back({reached, it->second.in_all});
  return missing;
}

bool Coverage::covers(const checkpoint::PartPiece& p) const {
  if (whole_.contains(p.point)) return true;
  if (p.whole) return false;
  if (p.blocks.first == p.blocks.end) return true;  // more shards than blocks
  if (!partial_.contains(p.point)) return false;
  const std::vector<montecarlo::BlockRange> open = gaps(p.point);
  return std::none_of(open.begin(), open.end(),
                      [&](montecarlo::BlockRange g) { return g.first < p.blocks.end && p.blocks.first < g.end; });
}

std::string array_list(const PointSet& points) {
  std::string text;
  for (const auto& [first, end] : points.ranges()) {
    text += fmt::format("{}{}", text.empty() ? "" : ",", first);
    if (end > first + 1) text += fmt::format("-{}", end - 1);
  }
  return text;
}

// ------------------------------------------------------------------------------------------------------------- merge

config::Config config_of(const checkpoint::Part& part, const std::string& label, const std::string& folder) {
  return config::Config::from_text(part.config, label, part.inputs, part.texts, part.references,
                                   folder.empty() ? part.folder : folder);
}

namespace {

bool same_file(const config::InputTable& a, const config::InputTable& b) {
  return a.names == b.names && a.columns == b.columns;
}
bool same_file(const config::InputText& a, const config::InputText& b) { return a.text == b.text; }
bool same_file(const config::InputReference& a, const config::InputReference& b) {
  return a.size == b.size && a.hash == b.hash;
}

/// Adds the files of a part to those that are known, each once.
template <class File>
void add_files(std::vector<File>& known, std::vector<File>& more, const std::string& part) {
  for (File& f : more) {
    const auto same = std::find_if(known.begin(), known.end(), [&](const File& k) { return k.path == f.path; });
    if (same == known.end())
      known.push_back(std::move(f));
    else
      require(same_file(*same, f),
              "{}: was made when {} had other contents than for the parts before: run one of them again", part, f.path);
  }
}

}  // namespace

std::string other_file(const checkpoint::Part& part, const config::Config& config) {
  const auto other = [](const auto& there, const auto& here) -> std::string {
    for (const auto& f : there)
      for (const auto& own : here)
        if (own.path == f.path && !same_file(f, own)) return f.path;
    return "";
  };
  std::string name = other(part.inputs, config.inputs());
  if (name.empty()) name = other(part.texts, config.input_texts());
  if (name.empty()) name = other(part.references, config.input_references());
  return name;
}

PartSet::PartSet(const std::vector<std::filesystem::path>& paths, const std::string& program) {
  for (const std::filesystem::path& path : paths) {
    readers_.emplace_back(path);
    checkpoint::PartReader& r = readers_.back();
    checkpoint::Part part = r.about();
    r.close();
    if (readers_.size() == 1) {
      about_ = part;
      about_.inputs.clear();
      about_.texts.clear();
      about_.references.clear();
    }
    require(part.key.config_hash == about_.key.config_hash, "{}: is of another config (hash {}) than {} ({})",
            path.string(), part.key.config_hash, paths[0].string(), about_.key.config_hash);
    require(numerics_of(part.key.program) == numerics_of(program),
            "{}: was made by another build ({}, this is {}), whose results may differ in their last bits: merge with "
            "that build, or run the part again",
            path.string(), part.key.program, program);
    if (part.key.program != program)
      remarks_.push_back(fmt::format("{}: is of another build ({}), whose numbers have the same bits: used",
                                     path.string(), part.key.program));
    add_files(about_.inputs, part.inputs, path.string());
    add_files(about_.texts, part.texts, path.string());
    add_files(about_.references, part.references, path.string());
    const auto number = static_cast<std::uint32_t>(readers_.size() - 1);
    for (std::uint32_t i = 0; i < r.pieces().size(); ++i) {
      const checkpoint::PieceEntry& e = r.pieces()[i];
      coverage_.add(e);
      if (e.point < about_.points) places_.push_back({e.point, number, i});
    }
  }
  std::stable_sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.point < b.point; });
}

checkpoint::PartReader& PartSet::opened(std::uint32_t part) {
  constexpr std::size_t kMostOpen = 64;
  std::erase(open_, part);
  open_.push_back(part);
  if (open_.size() > kMostOpen) {
    readers_[open_.front()].close();
    open_.erase(open_.begin());
  }
  return readers_[part];
}

std::vector<checkpoint::PartPiece> PartSet::pieces(std::uint64_t point) {
  std::vector<checkpoint::PartPiece> out;
  auto at = std::lower_bound(places_.begin(), places_.end(), point,
                             [](const Place& p, std::uint64_t wanted) { return p.point < wanted; });
  for (; at != places_.end() && at->point == point; ++at) {
    out.push_back(opened(at->part).piece(at->piece));
    if (out.back().whole) return {std::move(out.back())};
  }
  return out;
}

std::vector<std::filesystem::path> PartSet::write_merged(const std::filesystem::path& path,
                                                         const std::atomic<bool>* stop, store::OldFile old) {
  checkpoint::Part about = about_;
  std::vector<Place> chosen;
  std::vector<checkpoint::PieceEntry> entries;
  for (std::size_t i = 0; i < places_.size();) {
    std::size_t end = i;
    const Place* whole = nullptr;
    for (; end < places_.size() && places_[end].point == places_[i].point; ++end) {
      const checkpoint::PieceEntry& e = readers_[places_[end].part].pieces()[places_[end].piece];
      if (e.whole && !whole) whole = &places_[end];
    }
    for (std::size_t k = i; k < end; ++k) {  // a whole point once; of shards each once
      const checkpoint::PieceEntry& e = readers_[places_[k].part].pieces()[places_[k].piece];
      const bool is_known =
          std::any_of(entries.begin() + static_cast<std::ptrdiff_t>(entries.size() - (k - i)), entries.end(),
                      [&](const checkpoint::PieceEntry& o) {
                        return o.point == e.point && o.blocks.first == e.blocks.first && o.blocks.end == e.blocks.end;
                      });
      if (whole ? &places_[k] != whole : is_known) continue;
      chosen.push_back(places_[k]);
      entries.push_back(e);
    }
    i = end;
  }
  about.range = {entries.front().point, entries.back().point + 1, 1};
  about.shard = 0;
  about.shards = 1;
  about.run.elapsed_s = 0;
  for (const checkpoint::PartReader& r : readers_) about.run.elapsed_s += r.head().elapsed_s;
  const auto bytes = [&](std::size_t i) {
    if (stop && *stop) throw Interrupted("stopped before all pieces were written");
    return opened(chosen[i].part).piece_bytes(chosen[i].piece);
  };
  return checkpoint::write_part_of(path, about, entries, bytes, old);
}

std::vector<checkpoint::PartHead> PartSet::heads() const {
  std::vector<checkpoint::PartHead> out;
  for (const checkpoint::PartReader& r : readers_) out.push_back(r.head());
  return out;
}

std::string missing_shards(const std::vector<checkpoint::PartHead>& parts) {
  PointSet there;
  for (const checkpoint::PartHead& p : parts) {
    if (p.shards < 2 || p.shards != parts.front().shards || !(p.range == parts.front().range)) return "";
    there.add(p.shard);
  }
  const PointSet missing = there.others(parts.empty() ? 0 : parts.front().shards);
  if (missing.empty()) return "";
  return fmt::format("{} {} of {}", missing.count() == 1 ? "shard" : "shards", array_list(missing),
                     parts.front().shards);
}

void require_complete(const RunPlan& run, const Coverage& coverage, const std::string& shards) {
  PointSet none;
  std::string text;
  const PointSet missing = coverage.missing(run.point_count());
  for (const auto& [first, end] : missing.ranges())
    for (std::uint64_t i = first; i < end; ++i) {
      if (!coverage.is_partial(i)) {
        none.add(i);
        continue;
      }
      const std::shared_ptr<const PointPlan> plan = run.plan(i);
      const auto size = static_cast<std::uint64_t>(plan->block_trials());
      for (const montecarlo::BlockRange& r : coverage.gaps(i))
        text += fmt::format("; of point {} the trials {} to {}", i, r.first * size,
                            std::min(r.end * size, plan->trials()) - 1);
    }
  if (!none.empty())
    text = fmt::format("; {} {}{}", none.count() == 1 ? "point" : "points", array_list(none),
                       run.point_count() == none.count() ? " (all)" : "") +
           text;
  if (!text.empty() && !shards.empty()) text = "; " + shards + text;
  require(text.empty(), "the parts are not the whole run: missing {}", text.empty() ? text : text.substr(2));
}

PointResult merged_point(const RunPlan& run, std::uint64_t point, std::vector<checkpoint::PartPiece> pieces,
                         const montecarlo::RunOptions& options) {
  if (pieces.empty()) throw IoError(fmt::format("no part has point {}", point));
  checkpoint::PartPiece& first = pieces.front();
  if (!first.failure.empty()) {
    try {  // as the task has read it: the defaults that all points have depend on it
      run.plan(point);
    } catch (const InputError&) {
    }
    return failed_point(point, first.failure);
  }
  const std::uint64_t trials = run.plan(point)->trials();
  if (trials == 0) return point_result_from_bytes(first.result);
  const std::shared_ptr<const StudyPoint> prepared = run.prepare(point, options);
  const TallySizes sizes(*prepared, trials);
  for (const checkpoint::PartPiece& p : pieces)
    for (const montecarlo::Subtree& node : p.subtrees) {
      const std::string whose = fmt::format("{}: blocks {} to {} of point {}", p.file.empty() ? "a part" : p.file,
                                            p.blocks.first, p.blocks.end - 1, point);
      require_proposal(*prepared, node.tally, whose);
      sizes.require(node.tally, whose);
    }
  const std::string whose_all = fmt::format("{}: point {}", first.file.empty() ? "a part" : first.file, point);
  if (first.whole && first.subtrees.size() == 1) {
    sizes.require_whole(first.subtrees.front().tally, whose_all);
    return point_report(prepared, first.subtrees.front().tally, options);
  }
  std::vector<montecarlo::Subtree> nodes;
  for (checkpoint::PartPiece& p : pieces)
    nodes.insert(nodes.end(), std::make_move_iterator(p.subtrees.begin()), std::make_move_iterator(p.subtrees.end()));
  montecarlo::OrderedMerge merge;
  nodes = montecarlo::disjoint_subtrees(std::move(nodes));
  for (const montecarlo::Subtree& node : nodes)
    if (!stats::can_merge(nodes.front().tally, node.tally))
      throw IoError(
          fmt::format("the parts have tallies of different sizes for point {}: one of them is of "
                      "another build, or damaged: run its parts again",
                      point));
  for (montecarlo::Subtree& node : nodes) merge.add(std::move(node), true);
  const stats::Tally tally = merge.whole();
  if (tally.trials != trials)
    throw IoError(fmt::format("the parts have {} trials of point {}, not {}", tally.trials, point, trials));
  sizes.require_whole(tally, whose_all);
  return point_report(prepared, tally, options);
}

store::Result merge_parts(const RunPlan& run, PartSet& parts, const montecarlo::RunOptions& options) {
  require_complete(run, parts.coverage(), missing_shards(parts.heads()));
  return assemble(
      run,
      [&](std::size_t i) {
        if (options.stop && *options.stop) throw Interrupted("stopped before all points were merged");
        return merged_point(run, i, parts.pieces(i), options);
      },
      options.stop);
}

}  // namespace surveymc::study
