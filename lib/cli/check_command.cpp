#include <unistd.h>

#include <set>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include "base/error.h"
#include "cli/commands.h"
#include "cli/exit_codes.h"
#include "cli/load_run.h"
#include "cli/screen.h"
#include "render/text.h"

namespace surveymc::cli {

int check_config(const RunArguments& a) {
  const study::RunPlan run = load(a);
  if (run.sample.invalid > 0)
    throw InputError(
        fmt::format("{} ({} of {} points of the sweep that were tried are invalid: a run goes on without "
                    "such points, and lists them)",
                    run.sample.first_reason, run.sample.invalid, run.sample.points));
  fmt::print("{}\n", printable_toml(run.config.resolved_text()));
  for (const std::string& line : remark_lines(run.config)) {
    std::string comment = on_screen("# " + render::printable(line), STDOUT_FILENO, 4);
    for (std::size_t at = 0; (at = comment.find("\n ", at)) != std::string::npos;) comment[at + 1] = '#';
    fmt::print("{}\n", comment);
  }
  std::set<std::string> printed;
  for (std::size_t i = 0; i < (run.is_large() ? 1 : run.point_count()); ++i) {
    const std::string details = run.plan(i)->details();
    if (!printed.insert(details).second) continue;
    std::istringstream lines(details);
    for (std::string text; std::getline(lines, text);)
      print_lines(fmt::format("#{}{}\n", text.empty() ? "" : " ", text));
  }
  if (run.is_large())
    fmt::print(
        "# a sample of {} points was read: values of every key, and random points; a point that turns out to be "
        "invalid is listed in the result\n",
        run.config.sample_points().size());
  fmt::print("# {}, {} trials in all; config hash {}\n", counted(run.point_count(), "sweep point"), run.total_trials(),
             run.is_large() ? run.config.source_hash() : run.config.hash());
  return kDone;
}

}  // namespace surveymc::cli
