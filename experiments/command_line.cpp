#include "command_line.h"

namespace surveymc {

CommandLine::CommandLine(const std::string& version) {
  app.set_version_flag("--version", version);
  app.require_subcommand(1);
  RunArguments& a = arguments;
  const auto config_options = [&](CLI::App* sub) {
    sub->add_option("config", a.config, "TOML config of an experiment")->required();
    sub->add_option("--set", a.set, "KEY=VALUE: replaces a key of the config, checked like one in the file")
        ->allow_extra_args(false);
    sub->add_option("--trials", a.trials, "replaces the config's number of trials");
    sub->add_option("--seed", a.seed, "replaces the config's seed");
  };
  const auto thread_option = [&](CLI::App* sub) {
    sub->add_option("--threads", a.threads, "number of threads (all cores); the result does not depend on it")
        ->check(CLI::Range(1, 4096));
  };
  list = app.add_subcommand("list", "experiments and what each reproduces");
  check = app.add_subcommand("check", "validate a config and print it resolved; runs nothing");
  config_options(check);
  run = app.add_subcommand("run", "run a config and write its result file");
  config_options(run);
  thread_option(run);
  run->add_option("-o,--output", a.output, "result file (results/<config>.h5)")->check([](const std::string& name) {
    return name.empty() ? "the name is empty" : "";
  });
  run->add_flag("--check", a.check, "exit with 1 if a verdict is not the expected one");
  run->add_option("--trial", a.trial, "replay this one trial (from 0) and print it; writes nothing");
  run->add_option("--point", a.point, "only this sweep point (from 0): writes a part file, or with --trial none");
  run->add_option("--shard", a.shard, "I/N: only slice I (from 0) of N of the trials: writes a part file");
  run->add_flag("--array", a.array, "the part of this Slurm array task: a point, or with --shards a shard");
  run->add_option("--shards", a.shards, "with --array: the task is shard SLURM_ARRAY_TASK_ID of so many");
  run->add_flag("--resume", a.resume, "go on from what an interrupted run has left, if it has");
  run->add_option("--max-seconds", a.max_seconds, "stop then, keep what is done, exit with 75")
      ->check(CLI::PositiveNumber);
  run->add_option("--checkpoint-seconds", a.checkpoint_seconds, "keep finished blocks so often (5)")
      ->check(CLI::Range(0.001, 1e6));
  plan = app.add_subcommand("plan", "parts of a config: how many, and which are missing");
  config_options(plan);
  CLI::Option* count = plan->add_flag("--count", parts_plan.count, "print how many parts there are");
  CLI::Option* missing =
      plan->add_option("--missing", parts_plan.folder, "print those not in this folder, as a Slurm array list");
  count->excludes(missing);
  plan->add_option("--shards", a.shards, "the parts are so many shards, not the sweep points");
  merge = app.add_subcommand("merge", "put part files together to the result of the whole run");
  merge->add_option("parts", parts, "part files, or folders of them")->required();
  merge->add_option("-o,--output", a.output, "result file")->required();
  merge->add_flag("--check", a.check, "exit with 1 if a verdict is not the expected one");
  status = app.add_subcommand("status", "part files and journals of a folder");
  status->add_option("folder", parts_plan.folder, "folder of part files")->required();
  show = add_show_command(app, shown);
  rerun = app.add_subcommand("rerun", "repeat a result from what is stored in it and compare");
  rerun->add_option("file", file, "result file")->required();
  rerun->add_option("--inputs", inputs,
                    "folder of the config, where input files are that were too large to be stored (this folder)");
  thread_option(rerun);
  texts = add_text_commands(app, text_arguments);
}

}  // namespace surveymc
