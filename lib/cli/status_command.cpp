/// surveymc status: what is done of a run, in one process, in parts or on ranks.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "base/error.h"
#include "base/numerics.h"
#include "cli/commands.h"
#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/load_run.h"
#include "cli/log.h"
#include "cli/part_files.h"
#include "cli/print_result.h"
#include "cli/provenance.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "cli/sweep_status.h"
#include "cli/version_text.h"
#include "render/text.h"
#include "store/atomic_file.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

/// Lines for the terminal, and the runs for the page.
struct Look {
  std::vector<std::string> lines;
  std::vector<SweepStatus> runs;
  bool finished = false;  ///< there is nothing to wait for
};

void add_lines(Look& look, const SweepStatus& status) {
  for (const std::string& line : status_lines(status)) look.lines.push_back("  " + line);
  look.runs.push_back(status);
}

/// A run that is not in parts: journals beside its output.
class WholeRun {
 public:
  WholeRun(const RunArguments& a, fs::path output)
      : watch_(load(a)), key_(run_key(watch_.run(), false)), output_(std::move(output)) {}

  Look look(double seconds) {
    std::vector<fs::path> journals, others;
    SweepStatus s;
    const auto is_there = [](const fs::path& path) {
      std::error_code error;
      return fs::exists(path, error);
    };
    do {  // once more where a run has written its result meanwhile, and removed its journals
      journals.clear();
      others.clear();
      for (const fs::path& path : checkpoint::journals_of(output_)) {
        const std::optional<checkpoint::JournalLook> j = checkpoint::look_at_journal(path);
        if (j && !j->key.config_hash.empty())
          (checkpoint::same_numbers(j->key, key_) ? journals : others).push_back(path);
      }
      s = watch_.look({}, journals, seconds);
    } while (!std::all_of(journals.begin(), journals.end(), is_there));
    Look look;
    s.config_hash = key_.config_hash;
    s.finished = journals.empty() && is_written();
    if (s.finished) {
      s.done.add(0, s.points);
      s.share = 1;
      s.verdicts = verdicts_;
      s.judged = s.points;
    }
    look.finished = s.finished;
    look.lines.push_back(s.title);
    look.lines.push_back(
        fmt::format("  experiment {}, config hash {}, output {}", s.experiment, key_.config_hash, output_.string()));
    if (journals.empty() && !s.finished)
      look.lines.push_back("  nothing is kept of it there yet: a run keeps its work in a journal beside its output");
    if (std::error_code error; !s.finished && fs::exists(output_, error))
      look.lines.push_back(
          fmt::format("  {} is there, but of another config or build: give status the options of its run (--set, "
                      "--trials, --seed)",
                      output_.string()));
    add_lines(look, s);
    for (const fs::path& path : others)
      look.lines.push_back(fmt::format("  {}: is of another config or build: not counted", path.string()));
    return look;
  }

 private:
  bool is_written() {
    std::error_code error;
    const auto written = fs::last_write_time(output_, error);
    if (error) return false;
    if (written == looked_at_) return is_written_;
    looked_at_ = written;
    try {
      const store::Result r = store::read_unchecked_result(output_);
      is_written_ = r.provenance.config_hash == watch_.run().config.hash() &&
                    numerics_of(r.provenance.compiler) == numerics_text();
      if (is_written_) verdicts_ = count_verdicts(r.tables);
    } catch (const IoError&) {
      is_written_ = false;
    }
    return is_written_;
  }

  SweepWatch watch_;
  checkpoint::RunKey key_;
  fs::path output_;
  fs::file_time_type looked_at_ = fs::file_time_type::min();
  bool is_written_ = false;
  VerdictCounts verdicts_;  // of what is written
};

/// All runs whose parts are in a folder.
class PartsFolder {
 public:
  PartsFolder(const std::vector<study::Experiment>& studies, std::string folder)
      : studies_(studies), folder_(std::move(folder)) {}

  Look look(double seconds) {
    std::map<std::string, std::vector<ListedPart>> runs;
    std::size_t damaged = 0;
    for (const fs::path& path : files_with(folder_, kPartExtension)) {
      if (std::optional<ListedPart> part = listed(path))
        runs[part->head.run].push_back(std::move(*part));
      else
        ++damaged;
    }
    const std::vector<fs::path> journals = files_with(folder_, checkpoint::kJournalInfix);
    Look look;
    look.finished = !runs.empty() && journals.empty();
    for (const auto& [key, parts] : runs) {
      // A journal has no config: it is of the run whose parts are here, if they are of one.
      const SweepStatus* s = add(look, key, parts, runs.size() == 1 ? journals : std::vector<fs::path>{}, seconds);
      look.finished = look.finished && s && s->done.count() == s->points;
    }
    if (runs.empty()) look.lines.push_back(fmt::format("no part files in {}", folder_));
    if (damaged > 0) look.lines.push_back(counted(damaged, "damaged or foreign part file"));
    std::error_code error;
    for (const fs::path& path : journals)
      look.lines.push_back(fmt::format("unfinished: {} ({} bytes)", path.string(), fs::file_size(path, error)));
    return look;
  }

 private:
  const SweepStatus* add(Look& look, const std::string& key, const std::vector<ListedPart>& parts,
                         const std::vector<fs::path>& journals, double seconds) {
    const checkpoint::Part first = checkpoint::PartReader(parts.front().path).about();
    study::Coverage there;
    double elapsed = 0;
    std::size_t failed = 0;
    std::vector<checkpoint::PartHead> heads;
    for (const ListedPart& part : parts) {
      heads.push_back(part.head);
      elapsed += part.head.elapsed_s;
      failed += part.head.failed;
      add_to(there, part);
    }
    const PointSet open = there.missing(first.points);
    look.lines.push_back(first.title);
    look.lines.push_back(
        fmt::format("  experiment {}, config hash {}, {}", first.experiment, first.key.config_hash, first.key.program));
    look.lines.push_back(fmt::format("  {}, computed in {}; {} of {} points done{}{}", counted(parts.size(), "part"),
                                     format_duration(elapsed), first.points - open.count(), first.points,
                                     open.empty() ? "" : "; missing, whole or in part: ", study::array_list(open)));
    if (const std::string shards = study::missing_shards(heads); !shards.empty())
      look.lines.push_back(fmt::format("  missing {}", shards));
    if (failed > 0) look.lines.push_back(fmt::format("  {} with points that cannot be run", counted(failed, "part")));
    SweepWatch* watch = watch_of(key, first, parts.front().path);
    if (!watch) return nullptr;
    try {
      add_lines(look, watch->look(parts, journals, seconds));
      return &look.runs.back();
    } catch (const IoError& e) {  // a part that was replaced meanwhile, or is damaged behind its head
      look.lines.push_back(fmt::format("  {}", e.what()));
      return nullptr;
    }
  }

  /// Nothing where its config cannot be read here, or this program's numbers may have other bits.
  SweepWatch* watch_of(const std::string& key, const checkpoint::Part& about, const fs::path& part) {
    const auto [at, is_new] = watches_.try_emplace(key);
    if (is_new && numerics_of(about.key.program) == numerics_text()) try {
        config::Config config = study::config_of(about, part.string());
        const study::Experiment& experiment = find_experiment(studies_, config);
        at->second = std::make_unique<SweepWatch>(study::open_run(experiment, std::move(config)));
      } catch (const InputError& e) {
        log_warning(e.what());
      } catch (const IoError& e) {
        log_warning(e.what());
      }
    return at->second.get();
  }

  const std::vector<study::Experiment>& studies_;
  std::string folder_;
  std::map<std::string, std::unique_ptr<SweepWatch>> watches_;
};

/// Throws IoError unless the file is a page of this command.
void require_own_page(const fs::path& path) {
  std::ifstream in(path);
  std::string head(1000, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.find(kStatusPageMark) == std::string::npos)
    throw IoError(fmt::format("{}: is no page of surveymc status: choose another name", path.string()));
}

void write_page(const std::string& name, const std::string& text) {
  const fs::path path = store::resolved(name);
  try {
    store::AtomicFile file(path);
    file.write(text);
    file.commit(store::OldFile::replaced, require_own_page);
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", name, e.code().message()));
  }
}

/// Waits, unless the program is stopped. False if it is.
bool wait_for(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!*stop_flag()) {
    if (std::chrono::steady_clock::now() >= end) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

/// Prints looks until nothing is left to wait for.
template <class Source>
int show_looks(Source&& source, const StatusArguments& s) {
  constexpr double kVerdicts = 1;  // s of a look; the next one sees more of them
  if (s.watch) catch_signals();    // a single look ends by the signal itself
  std::vector<std::string> before;
  while (true) {
    Look look;
    try {
      look = source.look(kVerdicts);
    } catch (const Interrupted&) {
      return kDone;
    }
    const bool goes_on = s.watch && !look.finished;
    if (!s.page.empty()) write_page(s.page, status_page(look.runs, goes_on ? s.every_s : 0));
    if (isatty(STDOUT_FILENO) && s.watch) fmt::print("\033[H\033[2J");
    if (look.lines != before)
      for (const std::string& line : look.lines) say(render::printable(line));
    std::fflush(stdout);
    before = std::move(look.lines);
    if (!goes_on || !wait_for(s.every_s)) return kDone;
  }
}

}  // namespace

int status_of(const RunArguments& a, const StatusArguments& s) {
  std::error_code error;
  const FileKind kind = kind_of_file(a.config);
  if (fs::is_directory(a.config, error)) {
    require_usage(a.output.empty() && a.set.empty() && !a.trials && !a.seed,
                  "status {}: a folder of parts needs no options of a config: these have it", a.config);
    return show_looks(PartsFolder(*a.studies, a.config), s);
  }
  require(kind == FileKind::config, "{}: is no folder of parts and no config{}{}", a.config,
          kind == FileKind::unknown ? "" : ", but ", what_to_do(a.config, kind));
  const std::string stem = fs::path(a.config).stem().string();
  const fs::path output = !a.output.empty() ? fs::path(a.output) : fs::path("results") / (stem + ".h5");
  const fs::path parts = !a.output.empty() ? output : fs::path("results") / (stem + ".parts");
  if (fs::is_directory(parts, error) && (!a.output.empty() || !fs::exists(output, error)))
    return show_looks(PartsFolder(*a.studies, parts.string()), s);
  return show_looks(WholeRun(a, output), s);
}

}  // namespace surveymc::cli
