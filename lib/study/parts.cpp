#include "study/parts.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/error.h"
#include "study/point_result_bytes.h"

namespace surveymc::study {

namespace {

montecarlo::BlockRange blocks_of(const PointPlan& point) {
  return montecarlo::all_blocks(point.trials(), point.block_trials());
}

}  // namespace

std::string part_name(const PartChoice& c) {
  std::string name;
  if (c.point) name = fmt::format("point-{:05}", *c.point);
  if (c.shards > 1 || !c.point) name += fmt::format("{}shard-{}-of-{}", name.empty() ? "" : "-", c.shard, c.shards);
  return name;
}

void check_choice(const RunPlan& run, const PartChoice& c) {
  if (c.point)
    require(*c.point < run.points.size(), "--point {}: the points of this config are numbered 0 to {}", *c.point,
            run.points.size() - 1);
  require(c.shards > 0 && c.shard < c.shards, "--shard {}/{}: shards are numbered 0 to {}", c.shard, c.shards,
          c.shards - (c.shards > 0));
  if (c.point && c.shards == 1) return;
  for (std::size_t i = 0; i < run.points.size(); ++i) {
    if (c.point && *c.point != i) continue;
    require(run.points[i]->trials() > 0,
            "--shard {}/{}: a config of {} has no trials to divide; divide it by --point (0 to {})", c.shard, c.shards,
            run.experiment.name(), run.points.size() - 1);
    require(run.points[i]->looks().empty(),
            "--shard {}/{}: this config ends by [stop], which looks at all trials so far, and a shard sees only its "
            "own; divide it by --point (0 to {}), or give trials instead of [stop]",
            c.shard, c.shards, run.points.size() - 1);
  }
}

std::vector<checkpoint::PartPiece> part_pieces(const RunPlan& run, const PartChoice& c) {
  std::vector<checkpoint::PartPiece> pieces;
  const std::uint64_t first = c.point.value_or(0), end = c.point ? first + 1 : run.points.size();
  for (std::uint64_t i = first; i < end; ++i) {
    const std::uint64_t blocks = blocks_of(*run.points[i]).end;
    const bool whole = blocks == 0 || !run.points[i]->looks().empty();
    pieces.push_back({i, {blocks * c.shard / c.shards, blocks * (c.shard + 1) / c.shards}, blocks, whole});
  }
  return pieces;
}

checkpoint::Part run_part(const RunPlan& run, const PartChoice& choice, const montecarlo::RunOptions& options,
                          const Checkpoint& checkpoint) {
  checkpoint::Part part;
  part.pieces = part_pieces(run, choice);
  std::uint64_t done_before = 0, after = 0;
  const auto trials_of = [&](const checkpoint::PartPiece& p) {
    return montecarlo::trials_in(p.blocks, run.points[p.point]->trials(), run.points[p.point]->block_trials());
  };
  for (const checkpoint::PartPiece& p : part.pieces) after += trials_of(p);
  for (checkpoint::PartPiece& p : part.pieces) {
    const PointPlan& plan = *run.points[p.point];
    after -= trials_of(p);
    montecarlo::RunOptions of_point = options;
    if (options.progress)
      of_point.progress = [&](std::uint64_t done, std::uint64_t expected) {
        options.progress(done_before + done, done_before + expected + after);
      };
    if (!p.whole && p.blocks.first == p.blocks.end) continue;  // more shards than blocks
    const std::shared_ptr<const StudyPoint> point = run.prepare(p.point, of_point);
    if (plan.trials() == 0) {
      p.result = point_result_to_bytes(point_report(point, {}, of_point));
    } else if (p.whole) {
      p.subtrees.push_back({0, 0, point_tally(run, p.point, *point, of_point, checkpoint)});
    } else {
      const auto kept = checkpoint.finished.find(p.point);
      p.subtrees = montecarlo::run_block_range(
          plan.trials(), p.blocks, [&](montecarlo::TrialBlock b) { return point->run_block(b); },
          options_of_point(of_point, run, p.point, checkpoint.journal),
          kept == checkpoint.finished.end() ? std::vector<montecarlo::Subtree>{} : kept->second);
    }
    done_before += trials_of(p);
  }
  part.title = run.config.title().empty() ? run.experiment.summary : run.config.title();
  part.experiment = run.experiment.name();
  part.config = run.config.resolved_text();
  part.key.config_hash = run.config.hash();
  part.inputs = run.config.inputs();
  part.texts = run.config.input_texts();
  part.references = run.config.input_references();
  part.points = run.points.size();
  return part;
}

std::vector<std::vector<montecarlo::BlockRange>> missing_blocks(
    const std::vector<checkpoint::PartPiece>& whole, const std::vector<const checkpoint::PartPiece*>& pieces) {
  std::vector<std::vector<montecarlo::BlockRange>> there(whole.size());
  std::vector<bool> complete(whole.size());
  for (const checkpoint::PartPiece* p : pieces) {
    if (p->point >= whole.size()) continue;
    if (p->whole) complete[p->point] = true;
    there[p->point].push_back(p->blocks);
  }
  std::vector<std::vector<montecarlo::BlockRange>> missing(whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (complete[i]) continue;
    if (whole[i].whole) {  // such points are in one piece
      missing[i].push_back(whole[i].blocks);
      continue;
    }
    std::sort(there[i].begin(), there[i].end(),
              [](montecarlo::BlockRange a, montecarlo::BlockRange b) { return a.first < b.first; });
    std::uint64_t reached = 0;
    for (const montecarlo::BlockRange& r : there[i]) {
      if (r.first > reached) missing[i].push_back({reached, r.first});
      reached = std::max(reached, r.end);
    }
    if (reached < whole[i].blocks.end) missing[i].push_back({reached, whole[i].blocks.end});
  }
  return missing;
}

bool is_covered(const std::vector<checkpoint::PartPiece>& choice,
                const std::vector<std::vector<montecarlo::BlockRange>>& missing) {
  return std::all_of(choice.begin(), choice.end(), [&](const checkpoint::PartPiece& p) {
    const std::vector<montecarlo::BlockRange>& gaps = missing[p.point];
    if (p.whole) return gaps.empty();
    if (p.blocks.first == p.blocks.end) return true;  // more shards than blocks
    return std::none_of(gaps.begin(), gaps.end(),
                        [&](montecarlo::BlockRange g) { return g.first < p.blocks.end && p.blocks.first < g.end; });
  });
}

std::string array_list(const std::vector<std::uint64_t>& rising) {
  std::string text;
  for (std::size_t i = 0; i < rising.size();) {
    std::size_t last = i;
    while (last + 1 < rising.size() && rising[last + 1] == rising[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", rising[i]);
    if (last > i) text += fmt::format("-{}", rising[last]);
    i = last + 1;
  }
  return text;
}

config::Config config_of(const checkpoint::Part& part, const std::string& label, const std::string& folder) {
  return config::Config::from_text(part.config, label, part.inputs, part.texts, part.references,
                                   folder.empty() ? part.folder : folder);
}

namespace {

/// Throws InputError that names all gaps.
void require_complete(const RunPlan& run, const std::vector<const checkpoint::PartPiece*>& pieces) {
  const auto missing = missing_blocks(part_pieces(run, {}), pieces);
  std::vector<std::uint64_t> whole;
  std::string text;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (missing[i].empty()) continue;
    const std::uint64_t trials = run.points[i]->trials(), blocks = blocks_of(*run.points[i]).end;
    const auto size = static_cast<std::uint64_t>(run.points[i]->block_trials());
    if (missing[i].front().first == 0 && missing[i].front().end == blocks) {
      whole.push_back(i);
      continue;
    }
    for (const montecarlo::BlockRange& r : missing[i])
      text += fmt::format("; of point {} the trials {} to {}", i, r.first * size, std::min(r.end * size, trials) - 1);
  }
  if (!whole.empty())
    text = fmt::format("; {} {}{}", whole.size() == 1 ? "point" : "points", array_list(whole),
                       run.points.size() == whole.size() ? " (all)" : "") +
           text;
  require(text.empty(), "the parts are not the whole run: missing {}", text.empty() ? text : text.substr(2));
}

}  // namespace

store::Result merge_parts(const RunPlan& run, const std::vector<checkpoint::Part>& parts,
                          const montecarlo::RunOptions& options) {
  std::vector<const checkpoint::PartPiece*> pieces;
  for (const checkpoint::Part& part : parts)
    for (const checkpoint::PartPiece& p : part.pieces) pieces.push_back(&p);
  require_complete(run, pieces);
  std::vector<std::vector<const checkpoint::PartPiece*>> of_point(run.points.size());
  for (const checkpoint::PartPiece* p : pieces)
    if (p->point < of_point.size()) of_point[p->point].push_back(p);

  return assemble(
      run,
      [&](std::size_t i) {
        const std::uint64_t trials = run.points[i]->trials();
        const checkpoint::PartPiece& first = *of_point[i].front();
        if (trials == 0) return point_result_from_bytes(first.result);
        const std::shared_ptr<const StudyPoint> point = run.prepare(i, options);
        for (const checkpoint::PartPiece* p : of_point[i])
          for (const montecarlo::Subtree& node : p->subtrees)
            require_proposal(
                *point, node.tally,
                fmt::format("the part with blocks {} to {} of point {}", p->blocks.first, p->blocks.end - 1, i));
        if (first.whole && first.subtrees.size() == 1)
          return point_report(point, first.subtrees.front().tally, options);
        std::vector<montecarlo::Subtree> nodes;
        for (const checkpoint::PartPiece* p : of_point[i])
          nodes.insert(nodes.end(), p->subtrees.begin(), p->subtrees.end());
        montecarlo::OrderedMerge merge;
        nodes = montecarlo::disjoint_subtrees(std::move(nodes));
        for (const montecarlo::Subtree& node : nodes)
          if (!stats::can_merge(nodes.front().tally, node.tally))
            throw IoError(
                fmt::format("the parts have tallies of different sizes for point {}: one of them is of "
                            "another build, or damaged: run its parts again",
                            i));
        for (montecarlo::Subtree& node : nodes) merge.add(std::move(node), true);
        const stats::Tally tally = merge.whole();
        if (tally.trials != trials)
          throw IoError(fmt::format("the parts have {} trials of point {}, not {}", tally.trials, i, trials));
        return point_report(point, tally, options);
      },
      options.stop);
}

}  // namespace surveymc::study
