#include "cli/commands.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/print_result.h"
#include "cli/run_setup.h"
#include "cli/screen.h"
#include "store/atomic_file.h"
#include "study/refine.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

/// Texts that become files together, at the end: a signal before that leaves the old files, and no temporary ones.
class NewFiles {
 public:
  void add(const fs::path& path, const std::string& text) {
    at(path, [&] {
      store::remove_stale_temporaries(store::resolved(path));
      files_.emplace_back(path, std::make_unique<store::AtomicFile>(store::resolved(path)));
      constexpr std::size_t kPiece = std::size_t{1} << 20;
      for (std::size_t done = 0; done < text.size(); done += kPiece) {
        end_if_signalled();
        files_.back().second->write(std::span(text).subspan(done, std::min(kPiece, text.size() - done)));
      }
    });
  }
  void commit() {
    end_if_signalled();
    for (const auto& written : files_) at(written.first, [&] { written.second->commit(); });
  }

 private:
  static void end_if_signalled() {
    if (HoldsSignals::any()) throw Interrupted("stopped before the files were written");
  }
  static void at(const fs::path& path, const std::function<void()>& work) {
    try {
      work();
    } catch (const std::system_error& e) {
      throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
    }
  }
  HoldsSignals held_;  // until the temporary files are gone
  std::vector<std::pair<fs::path, std::unique_ptr<store::AtomicFile>>> files_;
};

study::Round round_of(const std::string& file) {
  store::Result result = store::read_result(file);
  config::StoredInputs inputs = stored_inputs(result);
  return {file, std::move(result), std::move(inputs)};
}

std::string csv_of(const config::InputTable& t) {
  store::Table table{t.path, ""};
  for (std::size_t c = 0; c < t.names.size(); ++c) table.columns.push_back({t.names[c], "", "", t.columns[c]});
  return store::to_csv(table);
}

/// Files that the config names, from the result, where the next config does not find them.
void add_missing_inputs(NewFiles& files, const study::Round& round, const fs::path& folder, const std::string& points) {
  const auto write = [&](const std::string& name, const std::string& text) {
    const fs::path path = folder / name;
    std::error_code error;
    if (name == points || name.ends_with(".points.csv") || fs::exists(path, error)) return;
    if (fs::path(name).is_absolute() || name.find("..") != std::string::npos)
      throw IoError(
          fmt::format("{}: is named by the config, and is not there: write the next config into the folder "
                      "of the first one",
                      path.string()));
    fs::create_directories(path.parent_path(), error);
    files.add(path, text);
  };
  for (const config::InputTable& t : round.inputs.tables) write(t.path, csv_of(t));
  for (const config::InputText& t : round.inputs.texts) write(t.path, t.text);
}

}  // namespace

int refine_result(const RefineArguments& a) {
  const fs::path output = a.output;
  require_usage(output.extension() == ".toml", "-o {}: the name of a config ends in .toml", a.output);
  const study::Round round = round_of(a.file);
  const std::string points = output.stem().string() + ".points.csv";
  const study::NextRound next = study::next_round(round.result, a.file, points);
  if (next.count == 0) {
    say(fmt::format("nothing to refine: the boundary passes {} of the size that [refine] wants, and no larger one",
                    counted(next.crossed, "cell")));
    return kDone;
  }
  const fs::path folder = store::folder_of(output);
  for (const fs::path& path : {output, folder / points}) {
    std::error_code error;
    if (fs::exists(path, error) && !a.overwrite)
      throw IoError(
          fmt::format("{}: exists: choose another name with -o, or replace it with --overwrite", path.string()));
  }
  {
    NewFiles files;
    add_missing_inputs(files, round, folder, points);
    files.add(folder / points, next.points);
    files.add(output, next.config);  // last: what it names is there
    files.commit();
  }
  say(fmt::format("wrote {} with {} in {}", output.string(), counted(next.count, "new point"), points));
  return kDone;
}

store::Result merge_rounds(const std::vector<study::Experiment>& studies, const std::vector<std::string>& files,
                           const std::string& output, const std::string& folder) {
  std::vector<study::Round> rounds;
  for (const std::string& file : files) {
    rounds.push_back(round_of(file));
    const store::Provenance &p = rounds.back().result.provenance, &first = rounds.front().result.provenance;
    require(p.experiment == first.experiment, "{}: is of another experiment than {}", file, files.front());
    require(p.git_revision == first.git_revision && p.compiler == first.compiler,
            "{}: was made by another build than {}, whose results may differ in their last bits", file, files.front());
  }
  const std::string& name = rounds.front().result.provenance.experiment;
  for (const study::Experiment& e : studies)
    if (e.name() == name)
      return study::merged_rounds(e, std::move(rounds), fs::path(output).stem().string() + ".points.csv", folder);
  throw InputError(fmt::format("{}: is of the experiment {}, which this program does not have", files.front(), name));
}

}  // namespace surveymc::cli
