#include "cli/part_commands.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "checkpoint/same_numbers.h"
#include "cli/log.h"
#include "cli/print_result.h"
#include "store/atomic_file.h"
#include "store/backup.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".part";

std::uint64_t slurm_number(const char* name) {
  const char* text = std::getenv(name);
  require_usage(text != nullptr, "--array: {} is not set: this is for tasks of a Slurm array (sbatch --array=...)",
                name);
  return whole_number(name, text);
}

std::uint64_t shard_count(const RunArguments& a) {
  const std::uint64_t n = a.shards ? whole_number("--shards", *a.shards) : 0;
  require_usage(!a.shards || (n > 0 && n <= 1'000'000), "--shards {}: must be 1 to 1000000", n);
  return n;
}

/// A part that the run does not have was asked for by an option.
void require_choice(const study::RunPlan& run, const study::PartChoice& choice) {
  try {
    study::check_choice(run, choice);
  } catch (const InputError& e) {
    throw UsageError(e.what());
  }
}

study::PartChoice array_choice(const RunArguments& a, const study::RunPlan& run) {
  const std::uint64_t id = slurm_number("SLURM_ARRAY_TASK_ID");
  if (const std::uint64_t n = shard_count(a)) return {std::nullopt, id, n};
  const bool divisible = run.points.size() == 1 && run.total_trials() > 0 && run.points[0]->looks().empty();
  if (!divisible) return {id};
  const std::uint64_t count = slurm_number("SLURM_ARRAY_TASK_COUNT");
  const char* first = std::getenv("SLURM_ARRAY_TASK_MIN");
  require_usage(
      id < count && (!first || std::string(first) == "0"),
      "--array: task {} of {}: shards are numbered from 0 without gaps; where tasks are submitted again, say how "
      "many shards there are in all with --shards N",
      id, count);
  return {std::nullopt, id, count};
}

fs::path part_path(const RunArguments& a, const study::PartChoice& choice) {
  std::error_code error;
  fs::path output = a.output;
  const bool is_default = output.empty();
  if (is_default) output = fs::path("results") / (fs::path(a.config).stem().string() + ".parts") / "";
  const bool is_folder = !output.has_filename() || fs::is_directory(output, error);
  if (!is_folder) return output;
  fs::create_directories(output, error);
  if (error) throw IoError(fmt::format("{}: cannot be made: {}", output.string(), error.message()));
  return output / (study::part_name(choice) + kExtension);
}

bool same_pieces(const std::vector<checkpoint::PartPiece>& a, const std::vector<checkpoint::PartPiece>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const checkpoint::PartPiece& x, const checkpoint::PartPiece& y) {
                      return x.point == y.point && x.blocks.first == y.blocks.first && x.blocks.end == y.blocks.end;
                    });
}

/// True if the part is there already. Throws IoError if another file is in its place, or if it could not be written.
bool is_done(const fs::path& path, const study::RunPlan& run, const study::PartChoice& choice, bool overwrite) {
  const checkpoint::PartState state = checkpoint::part_state(path);
  if (state == checkpoint::PartState::foreign)
    throw IoError(fmt::format("{}: exists and is no surveymc part file: refusing to overwrite it", path.string()));
  if (state == checkpoint::PartState::damaged)
    log_warning(fmt::format("{}: is damaged; that part is computed again", path.string()));
  if (state == checkpoint::PartState::whole) {
    const checkpoint::Part there = checkpoint::read_part(path);
    const checkpoint::RunKey key = run_key(run);
    const char* what = there.key.config_hash != key.config_hash                      ? "a part of another config"
                       : numerics_of(there.key.program) != numerics_of(key.program)  ? "this part by another build"
                       : !same_pieces(there.pieces, study::part_pieces(run, choice)) ? "another part of this config"
                                                                                     : nullptr;
    if (what && !overwrite)
      throw IoError(
          fmt::format("{}: holds {} (config hash {}, made by {}): choose another name or folder with -o, or replace it "
                      "with --overwrite",
                      path.string(), what, there.key.config_hash, there.key.program));
    if (!what) return true;
  }
  try {
    store::remove_stale_temporaries(store::resolved(path));
    store::AtomicFile(store::resolved(path))
        .write(std::vector<char>(4096));  // only this tells a full disk or a read-only folder
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
  }
  return false;
}

std::vector<fs::path> files_with(const fs::path& folder, const std::string& word) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool hit = word == kExtension ? it->path().extension() == word : name.find(word) != std::string::npos;
    if (hit && name[0] != '.') found.push_back(it->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// The part without its tallies and maps, which take memory.
std::optional<checkpoint::Part> outline(const fs::path& path) {
  try {
    checkpoint::Part part = checkpoint::read_part(path);
    for (checkpoint::PartPiece& p : part.pieces) {
      p.subtrees.clear();
      p.result.clear();
    }
    return part;
  } catch (const IoError& e) {
    log_warning(e.what());
    return std::nullopt;
  }
}

}  // namespace

std::optional<study::PartChoice> part_choice(const RunArguments& a, const study::RunPlan& run) {
  require_usage(!a.shards || a.array, "--shards: belongs to --array; without Slurm it is --shard I/N");
  require_usage(!a.array || (!a.point && !a.shard),
                "--array: chooses the part itself: not together with --point or --shard");
  if (!a.array && !a.point && !a.shard) return std::nullopt;
  require_usage(!a.check, "--check: a part has no verdicts; give it to surveymc merge");
  study::PartChoice choice;
  if (a.array) choice = array_choice(a, run);
  if (a.point) choice.point = whole_number("--point", *a.point);
  if (a.shard) {
    const std::size_t slash = a.shard->find('/');
    require_usage(slash != std::string::npos, "--shard {}: must be I/N, such as 0/4", *a.shard);
    choice.shard = whole_number("--shard", a.shard->substr(0, slash));
    choice.shards = whole_number("--shard", a.shard->substr(slash + 1));
    require_usage(choice.shards <= 1'000'000, "--shard {}: at most 1000000 shards", *a.shard);
  }
  require_choice(run, choice);
  if (choice.shards == 1 && !choice.point && run.points.size() == 1) choice.point = 0;  // one name for one thing
  return choice;
}

int run_one_part(const RunArguments& a, const study::RunPlan& run, const study::PartChoice& choice,
                 const std::string& command) {
  const fs::path path = part_path(a, choice);
  if (is_done(path, run, choice, a.overwrite)) {
    checkpoint::remove_journals(path, run_key(run));
    fmt::print("{} is done already\n", path.string());
    return kDone;
  }
  log_info(fmt::format("{}: {} of {}", a.config, study::part_name(choice), run.experiment.name()));
  log_remarks(run.config);
  double elapsed = 0;
  checkpoint::Part part;
  const auto compute = [&](const study::Checkpoint& checkpoint) {
    Progress progress;
    const auto created = std::chrono::system_clock::now();
    part = study::run_part(run, choice, run_options(a, run, progress), checkpoint);
    elapsed = progress.elapsed_s();
    part.key = run_key(run);
    part.command = command;
    part.folder = fs::absolute(a.config).parent_path().string();
    part.run = run_info(created, elapsed, a);
  };
  fs::path kept;  // what was there is damaged, but it is the user's
  with_checkpoint(a, run, path, command, compute, [&] {
    kept = store::write_beside_old(path, a.overwrite, [&] { checkpoint::write_part(path, part); });
  });
  say(fmt::format("wrote {} (in {})", path.string(), format_duration(elapsed)));
  tell_backup(kept);
  return kDone;
}

int plan_parts(const RunArguments& a, const PlanArguments& plan) {
  require_usage(plan.count || !plan.folder.empty(), "plan: say --count or --missing FOLDER");
  const study::RunPlan run = load(a);
  const std::uint64_t shards = shard_count(a), parts = shards > 0 ? shards : run.points.size();
  if (shards > 0) require_choice(run, {std::nullopt, 0, shards});
  if (plan.count) {
    fmt::print("{}\n", parts);
    return kDone;
  }
  std::vector<checkpoint::Part> there;
  const checkpoint::RunKey key = run_key(run);
  for (const fs::path& path : files_with(plan.folder, kExtension)) {
    std::optional<checkpoint::Part> part = outline(path);
    if (!part) continue;
    if (checkpoint::same_numbers(part->key, key))
      there.push_back(std::move(*part));
    else
      log_warning(fmt::format("{}: is of another config or build: not counted", path.string()));
  }
  std::vector<const checkpoint::PartPiece*> pieces;
  for (const checkpoint::Part& part : there)
    for (const checkpoint::PartPiece& p : part.pieces) pieces.push_back(&p);
  const auto missing = study::missing_blocks(study::part_pieces(run, {}), pieces);
  std::vector<std::uint64_t> ids;
  for (std::uint64_t i = 0; i < parts; ++i) {
    const study::PartChoice choice = shards > 0 ? study::PartChoice{std::nullopt, i, shards} : study::PartChoice{i};
    if (!study::is_covered(study::part_pieces(run, choice), missing)) ids.push_back(i);
  }
  if (!ids.empty()) fmt::print("{}\n", study::array_list(ids));
  return kDone;
}

int merge_files(const RunArguments& a, const std::vector<std::string>& names, const std::string& inputs) {
  catch_signals();
  std::vector<fs::path> paths;
  for (const std::string& name : names) {
    std::error_code error;
    const std::vector<fs::path> within = files_with(name, kExtension);
    if (fs::is_directory(name, error)) {
      require(!within.empty(), "{}: has no part files (*{})", name, kExtension);
      paths.insert(paths.end(), within.begin(), within.end());
    } else {
      paths.push_back(name);
    }
  }
  store::check_output_path(a.output);
  std::optional<EndsBySignal> ends(std::in_place, a);
  std::vector<checkpoint::Part> parts;
  for (const fs::path& path : paths) {
    parts.push_back(checkpoint::read_part(path));
    const checkpoint::RunKey &key = parts.back().key, &first = parts.front().key;
    require(key.config_hash == first.config_hash, "{}: is of another config (hash {}) than {} ({})", path.string(),
            key.config_hash, paths[0].string(), first.config_hash);
    require(numerics_of(key.program) == numerics_of(program_name()),
            "{}: was made by another build ({}, this is {}), whose results may differ in their last bits: merge with "
            "that build, or run the part again",
            path.string(), key.program, program_name());
    if (key.program != program_name())
      log_info(fmt::format("{}: is of another build ({}), whose numbers have the same bits: used", path.string(),
                           key.program));
  }
  config::Config config = study::config_of(parts.front(), paths[0].string(), inputs);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  const study::RunPlan run = study::read_run(experiment, std::move(config), stop_flag());
  if (run.config.hash() != parts.front().key.config_hash)
    throw IoError(fmt::format("{}: its config does not have the hash it says", paths[0].string()));
  Progress progress;
  store::Result result = study::merge_parts(run, parts, run_options(a, run, progress));
  ends.reset();
  stamp(result, "surveymc merge");
  result.run = {"", "", 0, 0, 0};  // of many runs; so the file does not depend on who ran what
  const fs::path kept = store::write_beside_old(a.output, a.overwrite, [&] { store::write_result(a.output, result); });
  print_tables(result, a.output, a.units == "ft");
  const int exit = report_verdicts(result, a.check);
  print_warnings(result);
  say(fmt::format("wrote {} (from {} part{})", a.output, parts.size(), parts.size() == 1 ? "" : "s"));
  tell_backup(kept);
  return exit;
}

int status_of(const std::string& folder) {
  std::error_code error;
  require(fs::is_directory(folder, error), "{}: is not a folder", folder);
  std::map<std::string, std::vector<checkpoint::Part>> runs;
  std::size_t damaged = 0;
  for (const fs::path& path : files_with(folder, kExtension)) {
    if (std::optional<checkpoint::Part> part = outline(path))
      runs[part->key.config_hash + part->key.program].push_back(std::move(*part));
    else
      ++damaged;
  }
  for (const auto& [key, parts] : runs) {
    const checkpoint::Part& first = parts.front();
    std::vector<checkpoint::PartPiece> whole(first.points);
    std::vector<const checkpoint::PartPiece*> pieces;
    double elapsed = 0;
    for (const checkpoint::Part& part : parts) {
      elapsed += part.run.elapsed_s;
      for (const checkpoint::PartPiece& p : part.pieces) {
        pieces.push_back(&p);
        if (p.point < whole.size()) whole[p.point] = {p.point, {0, p.blocks_in_all}, p.blocks_in_all, p.whole};
      }
    }
    std::vector<bool> seen(whole.size());
    for (const checkpoint::PartPiece* p : pieces)
      if (p->point < seen.size()) seen[p->point] = true;
    const auto missing = study::missing_blocks(whole, pieces);
    std::vector<std::uint64_t> open;
    for (std::uint64_t i = 0; i < whole.size(); ++i)
      if (!seen[i] || !missing[i].empty()) open.push_back(i);
    fmt::print("{}\n  experiment {}, config hash {}, {}\n  {} part{}, computed in {}; {} of {} points done{}{}\n",
               store::printable(first.title), first.experiment, first.key.config_hash, first.key.program, parts.size(),
               parts.size() == 1 ? "" : "s", format_duration(elapsed), first.points - open.size(), first.points,
               open.empty() ? "" : "; missing, whole or in part: ", study::array_list(open));
  }
  if (runs.empty()) fmt::print("no part files in {}\n", folder);
  if (damaged > 0) fmt::print("{} damaged or foreign part file{}\n", damaged, damaged == 1 ? "" : "s");
  for (const fs::path& path : files_with(folder, ".journal."))
    fmt::print("unfinished: {} ({} bytes)\n", path.string(), fs::file_size(path, error));
  return kDone;
}

}  // namespace surveymc::cli
