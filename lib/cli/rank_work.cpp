#include "cli/rank_work.h"

#include <exception>
#include <memory>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/load_run.h"
#include "cli/log.h"
#include "cli/provenance.h"
#include "cli/signals.h"

namespace surveymc::cli {

std::string run_name(const checkpoint::RunKey& key) {
  return fmt::format("config hash {}, {}", key.config_hash, key.program);
}

int work_for_rank_0(const std::vector<study::Experiment>& studies, montecarlo::Messages& messages, int argc,
                    char** argv) {
  silence_log();
  CommandLine line;
  std::optional<study::RunPlan> run;
  checkpoint::RunKey key;
  std::exception_ptr error;
  try {
    std::variant<CommandLine, int> read = read_command_line(
        argc, argv, [] { return std::string(); }, /*silent=*/true);
    if (std::holds_alternative<CommandLine>(read)) {  // else rank 0 says why and ends it
      line = std::get<CommandLine>(std::move(read));
      line.arguments.studies = &studies;
      const bool computes = line.command == Command::run || line.command == Command::rerun;
      if (computes) catch_signals();
      std::optional<EndsBySignal> reading;
      if (computes) reading.emplace();
      const bool part = line.command == Command::run && is_part(line.arguments);
      if (line.command == Command::run) run.emplace(part ? open_config(line.arguments) : load(line.arguments));
      if (line.command == Command::rerun)
        run.emplace(read_rerun(studies, line.file, store::read_result(line.file),
                               line.inputs.empty() ? "." : line.inputs, line.arguments.threads));
      if (part) study::read_points(*run, part_choice(line.arguments, *run), stop_flag());
      if (run) key = run_key(*run, part);
    }
  } catch (...) {
    error = std::current_exception();  // if rank 0 does not have this error, too, the first order takes it there
  }
  const RunArguments& a = line.arguments;
  std::unique_ptr<checkpoint::Journal> journal;
  std::optional<std::uint64_t> prepared;  // rank 0 goes from point to point
  std::shared_ptr<const study::StudyPoint> point;
  const std::string name = run ? run_name(key) : "nothing";
  return montecarlo::serve(messages, [&](const montecarlo::BlockOrder& order) -> montecarlo::Share {
    if (error) std::rethrow_exception(error);
    if (!run || name != order.run)
      throw IoError(
          fmt::format("does not see the same run as rank 0 ({}, here {}): the same program and files must be "
                      "there for all ranks",
                      order.run, name));
    if (!order.journal.empty() && !journal)
      journal = std::make_unique<checkpoint::Journal>(order.journal, key,
                                                      std::chrono::duration<double>(a.checkpoint_seconds));
    montecarlo::RunOptions options;
    options.threads = a.threads > 0 ? a.threads : messages.threads();
    options.stop = stop_flag();
    if (*stop_flag()) throw Interrupted("stopped before the first block");
    // Until the answer to this order: an idle rank may not end while rank 0 writes.
    const auto ends = std::make_shared<EndsBySignal>(
        journal.get(), EndMessage{.kept = "what is done is kept beside " + order.journal});
    if (prepared != order.point) {
      point = run->prepare(order.point, options);
      prepared = order.point;
    }
    return {run->plan(order.point)->trials(), [point, ends](montecarlo::TrialBlock b) { return point->run_block(b); },
            study::options_of_point(options, *run, order.point, journal.get())};
  });
}

}  // namespace surveymc::cli
