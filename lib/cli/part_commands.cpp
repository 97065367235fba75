#include "cli/commands.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/kept_work.h"
#include "cli/load_run.h"
#include "cli/log.h"
#include "cli/part_files.h"
#include "cli/print_result.h"
#include "cli/progress.h"
#include "cli/provenance.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "cli/write_output.h"
#include "store/atomic_file.h"
#include "study/point_costs.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

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
  } catch (const study::BadChoice& e) {
    throw UsageError(e.what());
  }
}

study::PartChoice array_choice(const RunArguments& a, const study::RunPlan& run) {
  const std::uint64_t id = slurm_number("SLURM_ARRAY_TASK_ID");
  if (const std::uint64_t n = shard_count(a)) return {std::nullopt, id, n};
  const bool divisible = run.point_count() == 1 && run.total_trials() > 0 && run.plan(0)->looks().empty();
  if (!divisible) return study::PartChoice::of_point(id);
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
  if (!is_folder) {
    require_usage(output.extension() == kPartExtension,
                  "-o {}: the name of a part ends in {}, so that surveymc merge finds it; or give a folder",
                  output.string(), kPartExtension);
    return output;
  }
  fs::create_directories(output, error);
  if (error) throw IoError(fmt::format("{}: cannot be made: {}", output.string(), error.message()));
  return output / (study::part_name(choice) + kPartExtension);
}

/// What the reader of parts says of a damaged one.
std::string why_damaged(const fs::path& path) {
  try {
    checkpoint::read_part(path);
  } catch (const IoError& e) {
    const std::string why = e.what();
    return why.substr(0, why.rfind(": "));
  }
  return path.string();
}

/// True if the part is there already. Throws IoError if another file is in its place, or if it could not be written.
bool is_done(const fs::path& path, const study::RunPlan& run, const study::PartChoice& choice, bool overwrite) {
  checkpoint::refuse_foreign_part(path);
  const checkpoint::PartState state = checkpoint::part_state(path);
  if (state == checkpoint::PartState::damaged)
    log_warning(fmt::format("{}; that part is computed again", why_damaged(path)));
  if (state == checkpoint::PartState::whole) {
    const checkpoint::Part there = checkpoint::PartReader(path).about();
    const checkpoint::RunKey key = part_key(run);
    const std::string other = study::other_file(there, run.config);
    const bool same = there.range == choice.range(run) && there.shard == choice.shard && there.shards == choice.shards;
    const std::string what = there.key.config_hash != key.config_hash                     ? "a part of another config"
                             : numerics_of(there.key.program) != numerics_of(key.program) ? "this part by another build"
                             : !same          ? "another part of this config"
                             : !other.empty() ? fmt::format("this part with other contents of {}", other)
                                              : "";
    if (!what.empty() && !overwrite)
      throw IoError(
          fmt::format("{}: holds {} (config hash {}, made by {}): choose another name or folder with -o, or replace it "
                      "with --overwrite",
                      path.string(), what, there.key.config_hash, there.key.program));
    if (what.empty()) return true;
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

/// "17", "100:200", "0:100000:1000".
checkpoint::PointRange range_of(const std::string& text) {
  const auto number = [&](std::string_view word) {
    require_usage(!word.empty(), "--point {}: must be POINT, FIRST:END or FIRST:END:STEP", text);
    return whole_number("--point", std::string(word));
  };
  const std::size_t first = text.find(':');
  if (first == std::string::npos) {
    const std::uint64_t point = number(text);
    return {point, point + 1, 1};
  }
  const std::size_t second = text.find(':', first + 1);
  checkpoint::PointRange r{number(text.substr(0, first)), number(text.substr(first + 1, second - first - 1)), 1};
  if (second != std::string::npos) r.stride = number(text.substr(second + 1));
  require_usage(r.stride > 0, "--point {}: the step must not be 0", text);
  return r;
}

void refuse_options_of_results(const RunArguments& a) {
  constexpr const char* kWhere = "give it to the surveymc merge that writes the result";
  require_usage(!a.check, "--check: a part has no verdicts; {}", kWhere);
  require_usage(a.units == "m", "--units {}: a part prints no tables; {}", a.units, kWhere);
  require_usage(a.compression == 0, "--compress {}: a part is not compressed; {}", a.compression, kWhere);
}

}  // namespace

bool is_part(const RunArguments& a) { return (a.point || a.shard || a.array) && !a.trial; }

study::PartChoice part_choice(const RunArguments& a, const study::RunPlan& run) {
  require_usage(!a.shards || a.array, "--shards: belongs to --array; without Slurm it is --shard I/N");
  require_usage(!a.array || (!a.point && !a.shard),
                "--array: chooses the part itself: not together with --point or --shard");
  refuse_options_of_results(a);
  study::PartChoice choice;
  if (a.array) choice = array_choice(a, run);
  if (a.point) choice.points = range_of(*a.point);
  if (a.shard) {
    const std::size_t slash = a.shard->find('/');
    require_usage(slash != std::string::npos, "--shard {}: must be I/N, such as 0/4", *a.shard);
    choice.shard = whole_number("--shard", a.shard->substr(0, slash));
    choice.shards = whole_number("--shard", a.shard->substr(slash + 1));
    require_usage(choice.shards <= 1'000'000, "--shard {}: at most 1000000 shards", *a.shard);
  }
  require_choice(run, choice);
  if (choice.shards == 1 && !choice.points && run.point_count() == 1)
    choice.points = checkpoint::PointRange{0, 1, 1};  // one name for one thing
  return choice;
}

int run_one_part(const RunArguments& a, const std::string& command) {
  std::optional<EndsBySignal> ends(std::in_place, nullptr, EndMessage::at_once());
  const study::RunPlan run = open_config(a);
  const study::PartChoice choice = part_choice(a, run);
  study::read_points(run, choice, stop_flag());
  ends.reset();
  const fs::path path = part_path(a, choice);
  const checkpoint::RunKey key = run_key(run, true);
  if (is_done(path, run, choice, a.overwrite)) {
    checkpoint::remove_journals(path, key);
    say(fmt::format("{} is done already", path.string()));
    return kDone;
  }
  log_info(fmt::format("{}: {} of {}", a.config, study::part_name(choice), run.experiment.name()));
  log_remarks(run.config);
  double elapsed = 0;
  checkpoint::Part part;
  std::vector<fs::path> renamed;  // what was there is damaged, but it is the user's
  KeptWork kept(a, key, path, command);
  try {
    Progress progress;
    const auto created = std::chrono::system_clock::now();
    part = study::run_part(run, choice, run_options(a, run, progress, true), kept.checkpoint());
    elapsed = progress.elapsed_s();
    part.key = part_key(run);
    part.command = command;
    part.folder = fs::absolute(a.config).parent_path().string();
    part.run = run_info(created, elapsed, a);
    renamed = checkpoint::write_part(path, part, old_file(a));
  } catch (...) {
    kept.rethrow();
  }
  kept.remove();
  const auto failed =
      std::count_if(part.pieces.begin(), part.pieces.end(), [](const auto& p) { return !p.failure.empty(); });
  for (const checkpoint::PartPiece& p : part.pieces)
    if (!p.failure.empty()) {
      log_warning(fmt::format("{} of {} points cannot be run, and the result will list them; the first: {}", failed,
                              part.pieces.size(), p.failure));
      break;
    }
  say(fmt::format("wrote {} (in {})", path.string(), format_duration(elapsed)));
  print_backup(renamed);
  return kDone;
}

namespace {

std::string range_text(const checkpoint::PointRange& r) {
  return r.count() == 1 ? fmt::format("{}", r.first) : fmt::format("{}:{}", r.first, r.end);
}

}  // namespace

int plan_parts(const RunArguments& a, const PlanArguments& plan) {
  require_usage(plan.count || plan.groups || !plan.folder.empty(), "plan: say --count, --missing FOLDER or --groups N");
  const std::uint64_t groups = plan.groups ? whole_number("--groups", *plan.groups) : 0;
  require_usage(!plan.groups || (groups > 0 && groups <= 1'000'000), "--groups {}: must be 1 to 1000000",
                plan.groups.value_or(""));
  const std::uint64_t shards = shard_count(a);
  require_usage(shards == 0 || !plan.groups, "--groups: not together with --shards");
  const study::RunPlan run = open_config(a);
  if (shards > 0) require_choice(run, {std::nullopt, 0, shards});
  const std::vector<checkpoint::PointRange> ranges =
      plan.groups ? study::PointCosts(run).ranges(groups) : std::vector<checkpoint::PointRange>{};
  const std::uint64_t parts = plan.groups ? ranges.size() : shards > 0 ? shards : run.point_count();
  if (plan.count) {
    fmt::print("{}\n", parts);
    return kDone;
  }
  if (plan.folder.empty()) {
    for (const checkpoint::PointRange& r : ranges) fmt::print("{}\n", range_text(r));
    return kDone;
  }
  study::Coverage there;
  const std::string key = checkpoint::run_bytes(part_key(run));
  for (const fs::path& path : files_with(plan.folder, kPartExtension)) {
    const std::optional<ListedPart> part = listed(path);
    if (!part) continue;
    if (part->head.run == key)
      add_to(there, *part);
    else
      log_warning(fmt::format("{}: is of another config or build: not counted", path.string()));
  }
  const PointSet points = there.missing(run.point_count());
  PointSet ids;
  if (plan.groups) {
    for (std::uint64_t g = 0; g < ranges.size(); ++g)
      if (points.meets(ranges[g].first, ranges[g].end)) ids.add(g);
  } else if (shards > 0) {
    for (std::uint64_t i = 0; i < shards; ++i) {
      const std::vector<checkpoint::PartPiece> pieces = study::part_pieces(run, {std::nullopt, i, shards});
      if (!std::all_of(pieces.begin(), pieces.end(), [&](const auto& p) { return there.covers(p); })) ids.add(i);
    }
  } else {
    ids = points;
  }
  if (!ids.empty()) fmt::print("{}\n", study::array_list(ids));
  return kDone;
}

namespace {

/// Writes and prints a merged result; the exit code of the command.
int write_merged(const RunArguments& a, store::Result result, const std::string& from,
                 std::optional<EndsBySignal>& ends) {
  stamp(result, "surveymc merge");
  result.run = {"", "", 0, 0, 0};  // of many runs; so the file does not depend on who ran what
  const std::vector<fs::path> kept = write_result_file(a, a.output, result);
  ends.reset();
  ends.emplace(nullptr, EndMessage{.nothing = fmt::format("{} is written", a.output)});
  const int exit = print_findings(a, result, a.output);
  if (a.json) return exit;
  say(fmt::format("wrote {} (from {})", a.output, from));
  print_backup(kept);
  return exit;
}

}  // namespace

int merge_files(const RunArguments& a, const std::vector<std::string>& names, const std::string& inputs, bool part) {
  catch_signals();
  std::optional<EndsBySignal> ends(std::in_place, nullptr, EndMessage());
  std::vector<fs::path> paths;
  for (const std::string& name : names) {
    std::error_code error;
    if (fs::is_directory(name, error)) {
      const std::vector<fs::path> within = files_with(name, kPartExtension);
      require(!within.empty(), "{}: has no part files (*{})", name, kPartExtension);
      paths.insert(paths.end(), within.begin(), within.end());
    } else {
      paths.push_back(name);
    }
  }
  if (part) {
    refuse_options_of_results(a);
    require_usage(fs::path(a.output).extension() == kPartExtension, "-o {}: the name of a part ends in {}", a.output,
                  kPartExtension);
    for (const fs::path& path : paths) {
      std::error_code error;
      require(!fs::equivalent(path, a.output, error), "{}: is one of the parts: choose another name with -o", a.output);
    }
    checkpoint::refuse_foreign_part(a.output);
  } else {
    store::check_output_path(a.output);
  }
  const std::size_t count = paths.size();
  if (!part && count > 1 && paths[0].extension() == ".h5") {  // results: rounds of one sweep
    std::vector<std::string> files;
    for (const fs::path& path : paths) files.push_back(path.string());
    return write_merged(a, merge_rounds(*a.studies, files, a.output, inputs), counted(count, "result"), ends);
  }
  study::PartSet parts(paths, program_name());
  for (const std::string& remark : parts.remarks()) log_info(remark);
  if (part) {
    const std::vector<fs::path> kept = parts.write_merged(a.output, stop_flag(), old_file(a));
    say(fmt::format("wrote {} (from {})", a.output, counted(count, "part")));
    print_backup(kept);
    return kDone;
  }
  config::Config config = study::config_of(parts.about(), paths[0].string(), inputs);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  const study::RunPlan run = study::open_run(experiment, std::move(config));
  if (run.config.source_hash() != parts.about().key.config_hash)
    throw IoError(fmt::format("{}: its config does not have the hash it says", paths[0].string()));
  Progress progress;
  return write_merged(a, study::merge_parts(run, parts, run_options(a, run, progress, true)), counted(count, "part"),
                      ends);
}

}  // namespace surveymc::cli
