#include "cli/load_run.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/exit_codes.h"
#include "cli/log.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "config/suggest.h"
#include "study/mistakes.h"
#include "sweep/config_keys.h"

namespace surveymc::cli {

const study::Experiment& find_experiment(const std::vector<study::Experiment>& studies, const config::Config& config) {
  std::vector<std::string> known;
  for (const study::Experiment& e : studies) {
    if (e.name() == config.experiment()) return e;
    known.push_back(e.name());
  }
  config.fail("experiment", fmt::format("must be one of {}{}", fmt::join(known, ", "),
                                        config::suggestion(config.experiment(), known)));
}

namespace {

config::Config config_with_changes(const RunArguments& a) {
  std::vector<std::string> overrides = a.set;
  for (const std::string& s : overrides)
    require_usage(s.find('=') != std::string::npos && s.find('=') > 0, "--set {}: {}must be KEY=VALUE", s,
                  s.starts_with('=') ? "the key is missing: " : "");
  if (a.seed) overrides.push_back(fmt::format("seed={}", whole_number("--seed", *a.seed)));
  if (a.trials) overrides.push_back(fmt::format("trials={}", number_of_trials(*a.trials)));
  return config::Config::load(a.config, overrides);
}

/// All that is wrong with a config, in a line each; `first` is what has ended its reading.
[[noreturn]] void refuse_config(const RunArguments& a, const study::Experiment& experiment, const std::string& first) {
  std::map<config::KeysOf, config::KeyTypes> types;
  const auto known = [&](config::KeysOf which) {  // all of them take a second
    const auto [it, is_new] = types.try_emplace(which);
    if (!is_new) return it->second;
    const store::Table keys = sweep::config_keys(experiment, which);
    for (std::size_t row = 0; row < keys.rows(); ++row) it->second[keys.word("key", row)] = keys.word("type", row);
    return it->second;
  };
  const std::vector<std::string> all = study::all_mistakes(experiment, config_with_changes(a), known, first);
  if (all.size() == 1) throw InputError(all.front());
  throw InputError(fmt::format("{}: {} mistakes:\n{}", a.config, all.size(), fmt::join(all, "\n")));
}

}  // namespace

study::RunPlan load(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  try {
    return study::read_run(experiment, std::move(config), stop_flag(), a.threads);
  } catch (const InputError& e) {
    refuse_config(a, experiment, e.what());
  }
}

study::RunPlan open_config(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  return study::open_run(experiment, std::move(config));
}

study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder, int threads) {
  config::StoredInputs in;
  try {
    in = stored_inputs(stored);
  } catch (const IoError& e) {
    throw IoError(fmt::format("{}: {}", file, e.what()));
  }
  config::Config config = config::Config::from_text(stored.provenance.config, file, std::move(in.tables),
                                                    std::move(in.texts), std::move(in.references), folder);
  const study::Experiment& experiment = find_experiment(studies, config);
  return study::read_run(experiment, std::move(config), stop_flag(), threads);
}

namespace {

/// The first remarks of one kind, and of more how many.
std::vector<std::string> lines_of(const config::Config& config, bool warnings) {
  std::vector<std::string> lines;
  std::size_t count = 0;
  const char* kind = warnings ? "warning: " : "";
  for (const config::Remark& r : config.remarks())
    if (r.is_warning == warnings && ++count <= kMostRemarks) lines.push_back(kind + r.text());
  if (count > kMostRemarks) lines.push_back(fmt::format("{}and {} more of this kind", kind, count - kMostRemarks));
  return lines;
}

}  // namespace

std::vector<std::string> remark_lines(const config::Config& config) {
  std::vector<std::string> lines = lines_of(config, false);
  for (std::string& line : lines_of(config, true)) lines.push_back(std::move(line));
  return lines;
}

void log_remarks(const config::Config& config) {
  for (const std::string& line : lines_of(config, false)) log_info(line);
  log_warnings(config);
}

void log_warnings(const config::Config& config) {
  for (const std::string& line : lines_of(config, true)) log_warning(line);
}

void log_notes(const config::Config& config) {
  for (const std::string& line : lines_of(config, false)) log_info(line);
  const std::vector<config::Remark> all = config.remarks();
  const auto warnings = std::count_if(all.begin(), all.end(), [](const config::Remark& r) { return r.is_warning; });
  if (warnings > 0)
    log_info(fmt::format("{} about the input: printed at the end; surveymc check prints {} now",
                         counted(static_cast<std::size_t>(warnings), "warning"), warnings == 1 ? "it" : "them"));
}

}  // namespace surveymc::cli
