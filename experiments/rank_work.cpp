#include "rank_work.h"

#include <exception>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace surveymc {

std::string run_name(const PreparedRun& run) {
  const RunKey key = run_key(run);
  return fmt::format("config hash {}, {}", key.config_hash, key.program);
}

int work_for_rank_0(Messages& messages, int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  CommandLine line("");
  std::optional<PreparedRun> run;
  std::exception_ptr error;
  try {
    line.app.parse(argc, argv);
    if (*line.run || *line.rerun) catch_signals();
    if (*line.run) run.emplace(load(line.arguments));
    if (*line.rerun) run.emplace(prepare_rerun(line.file, read_result(line.file), line.inputs));
  } catch (...) {
    error = std::current_exception();  // if it is not rank 0's, too, the first order brings it there
  }
  const RunArguments& a = line.arguments;
  std::unique_ptr<Journal> journal;
  return serve(messages, [&](const BlockOrder& order) -> Share {
    if (error) std::rethrow_exception(error);
    if (!run || run_name(*run) != order.run)
      throw IoError(
          fmt::format("does not see the same run as rank 0 ({}, here {}): the same program and files must be "
                      "there for all ranks",
                      order.run, run ? run_name(*run) : "nothing"));
    if (!order.journal.empty() && !journal)
      journal =
          std::make_unique<Journal>(order.journal, run_key(*run), std::chrono::duration<double>(a.checkpoint_seconds));
    const StudyPoint& point = *run->points.at(order.point);
    RunOptions options;
    options.threads = a.threads > 0 ? a.threads : messages.threads();
    options.stop = stop_flag();
    return {point.trials(), [&point](TrialBlock b) { return point.run_block(b); },
            options_of_point(options, *run, order.point, journal.get())};
  });
}

}  // namespace surveymc
