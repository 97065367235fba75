#include "cli/load_run.h"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/exit_codes.h"
#include "cli/log.h"
#include "cli/signals.h"
#include "config/suggest.h"

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

}  // namespace

study::RunPlan load(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  return study::read_run(experiment, std::move(config), stop_flag(), a.threads);
}

study::RunPlan open_config(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  return study::open_run(experiment, std::move(config));
}

study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder) {
  config::StoredInputs in;
  try {
    in = stored_inputs(stored);
  } catch (const IoError& e) {
    throw IoError(fmt::format("{}: {}", file, e.what()));
  }
  config::Config config = config::Config::from_text(stored.provenance.config, file, std::move(in.tables),
                                                    std::move(in.texts), std::move(in.references), folder);
  const study::Experiment& experiment = find_experiment(studies, config);
  return study::read_run(experiment, std::move(config), stop_flag());
}

std::vector<std::string> remark_lines(const config::Config& config) {
  std::vector<std::string> lines;
  for (const bool warnings : {false, true}) {
    std::size_t count = 0;
    for (const config::Remark& r : config.remarks())
      if (r.is_warning == warnings && ++count <= kMostRemarks) lines.push_back((warnings ? "warning: " : "") + r.text);
    if (count > kMostRemarks)
      lines.push_back(fmt::format("{}and {} more of this kind", warnings ? "warning: " : "", count - kMostRemarks));
  }
  return lines;
}

void log_remarks(const config::Config& config) {
  for (const std::string& line : remark_lines(config))
    line.starts_with("warning: ") ? log_warning(line) : log_info(line);
}

}  // namespace surveymc::cli
