#include "cli/commands.h"

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/load_run.h"
#include "cli/new_files.h"
#include "cli/print_result.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "render/csv.h"
#include "store/atomic_file.h"
#include "sweep/refine.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

sweep::Round round_of(const std::string& file) {
  store::Result result = store::read_result(file);
  config::StoredInputs inputs = stored_inputs(result);
  return {file, std::move(result), std::move(inputs)};
}

std::string csv_of(const config::InputTable& t) {
  store::Table table{t.path, ""};
  for (std::size_t c = 0; c < t.names.size(); ++c) table.columns.push_back({t.names[c], "", "", t.columns[c]});
  return render::to_csv(table);
}

/// Adds the files that the config names and that the next config would not find, from the result.
void add_missing_inputs(NewFiles& files, const sweep::Round& round, const fs::path& output, const std::string& points) {
  const fs::path folder = store::folder_of(output);
  const auto add = [&](const std::string& name, const std::string& text) {
    const fs::path path = folder / name;
    std::error_code error;
    if (name == points || name.ends_with(".points.csv") || fs::exists(path, error)) return;
    if (name.starts_with("<shipped>/")) return;         // comes with the program
    if (name.ends_with(config::kDoubtsSuffix)) return;  // what a result says of another file
    std::string fault = name == output.filename() ? "its name is that of the next config" : fault_of_input_name(name);
    if (fault.empty()) fault = make_folders(folder, name);
    if (!fault.empty())
      throw IoError(
          fmt::format("{}: is named by the config, is not there, and is not written from the result, as {}: write the "
                      "next config into the folder of the first one",
                      path.string(), fault));
    files.add(path, text, {.is_needed = false});
  };
  for (const config::InputTable& t : round.inputs.tables) add(t.path, csv_of(t));
  for (const config::InputText& t : round.inputs.texts) add(t.path, t.text);
}

}  // namespace

int refine_result(const RefineArguments& a) {
  catch_signals();
  std::optional<EndsBySignal> ends(std::in_place, nullptr, EndMessage::at_once());
  const fs::path output = a.output;
  require_usage(output.extension() == ".toml", "-o {}: the name of a config ends in .toml", a.output);
  const sweep::Round round = round_of(a.file);
  const std::string points = output.stem().string() + ".points.csv";
  const sweep::NextRound next = sweep::next_round(round.result, a.file, points);
  if (next.count == 0) {
    say(fmt::format("nothing to refine: the boundary passes {} of the size that [refine] wants, and no larger one",
                    counted(next.crossed, "cell")));
    return kDone;
  }
  const fs::path points_path = store::folder_of(output) / points;
  for (const fs::path& path : {output, points_path}) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error)) && !a.overwrite)
      throw IoError(
          fmt::format("{}: exists: choose another name with -o, or replace it with --overwrite", path.string()));
  }
  NewFiles files;
  add_missing_inputs(files, round, output, points);
  files.add(points_path, next.points, {.overwrite = a.overwrite});
  files.add(output, next.config, {.overwrite = a.overwrite, .follows_link = true});  // last: what it names is there
  ends.reset();  // a signal before this leaves the old files
  const std::vector<fs::path> written = files.commit();
  ends.emplace(nullptr, EndMessage::at_once(fmt::format("{} is written", output.string())));
  for (const fs::path& path : written)
    if (path != output && path != points_path)
      say(fmt::format("wrote {}, which the config names, as the result stores it", path.string()));
  say(fmt::format("wrote {} with {} in {}", output.string(), counted(next.count, "new point"), points));
  return kDone;
}

store::Result merge_rounds(const std::vector<study::Experiment>& studies, const std::vector<std::string>& files,
                           const std::string& output, const std::string& folder) {
  std::vector<sweep::Round> rounds;
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
      return sweep::merged_rounds(e, std::move(rounds), fs::path(output).stem().string() + ".points.csv", folder);
  throw InputError(fmt::format("{}: is of the experiment {}, which this program does not have", files.front(), name));
}

}  // namespace surveymc::cli
