#include "cli/commands.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "base/shell_word.h"
#include "cli/new_files.h"
#include "cli/print_result.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "config/key_log.h"
#include "sweep/config_schema.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> shipped(const std::string& path) {
  for (const config::InputText& file : config::shipped_config_files())
    if (file.path == path) return file.text;
  return std::nullopt;
}

struct DataFile {
  std::string name, text;  ///< without folder
};

struct Template {
  std::string text;
  std::vector<DataFile> data;  ///< files that it names
};

/// configs/new/NAME.toml, which names data of another folder of configs/: here they are beside the config.
Template template_of(const std::string& name) {
  const std::optional<std::string> text = shipped("configs/new/" + name + ".toml");
  require(text.has_value(), "new {}: no config of it comes with the program: write one, from surveymc keys {}", name,
          name);
  Template out{*text, {}};
  std::size_t begin = 0;
  while ((begin = out.text.find("\"../", begin)) != std::string::npos) {
    const std::size_t end = out.text.find('"', begin + 1);
    const fs::path named = out.text.substr(begin + 1, end - begin - 1);
    const std::string own = named.filename().string();
    const bool is_new =
        std::none_of(out.data.begin(), out.data.end(), [&](const DataFile& d) { return d.name == own; });
    if (is_new) out.data.push_back({own, shipped(("configs/new" / named).lexically_normal().string()).value()});
    // A comment behind the name stays in its column.
    const std::size_t comment = out.text.find_first_of("#\n", end);
    if (out.text[comment] == '#') out.text.insert(comment, named.string().size() - own.size(), ' ');
    out.text.replace(begin + 1, named.string().size(), own);
  }
  return out;
}

}  // namespace

void new_config(const std::vector<study::Experiment>& studies, const NewArguments& a) {
  const study::Experiment& experiment = experiment_named(studies, a.experiment, "new");
  const std::string name = experiment.name(), schema = name + ".schema.json";
  Template made = template_of(name);
  made.text = fmt::format("#:schema ./{}\n{}", schema, made.text);  // taplo and editors with it look for this line
  if (a.output.empty()) {
    fmt::print("{}", made.text);
    return;
  }
  catch_signals();  // writing takes no time
  const fs::path path = a.output;
  NewFiles files;
  files.add(path, made.text, {});
  for (const DataFile& file : made.data) files.add(path.parent_path() / file.name, file.text, {.is_needed = false});
  files.add(path.parent_path() / schema, sweep::config_schema(experiment), {.is_needed = false});
  const std::vector<fs::path> written = files.commit();
  const EndsBySignal ends(nullptr, EndMessage::at_once(fmt::format("{} is written", path.string())));
  say(fmt::format("wrote {}: put in your well; surveymc keys {} lists every key", path.string(), name));
  for (const DataFile& file : made.data) {
    const fs::path data = path.parent_path() / file.name;
    if (std::find(written.begin(), written.end(), data) != written.end())
      say(fmt::format("wrote {}: an example of the data that it names; put in yours", data.string()));
    else
      say(fmt::format("{} is there: the config names it", data.string()));
  }
  if (std::find(written.begin(), written.end(), path.parent_path() / schema) != written.end())
    say(fmt::format("wrote {}: what editors of TOML check it with", (path.parent_path() / schema).string()));
  say(fmt::format("then: surveymc check {0}, surveymc run {0}", shell_word(path.string())));
}

}  // namespace surveymc::cli
