#pragma once
/// Commands for runs in parts: run --point/--shard/--array, plan, merge, status (docs/cluster.md).
#include <optional>
#include <string>
#include <vector>

#include "cli/run_setup.h"
#include "study/parts.h"

namespace surveymc::cli {

struct PlanArguments {
  bool count = false;
  std::string folder;
  std::optional<std::string> groups;  // as typed
};

/// True if the arguments ask for a part of a run.
bool is_part(const RunArguments& a);

/// The part that the arguments or Slurm's environment ask for. Throws InputError.
std::optional<study::PartChoice> part_choice(const RunArguments& a, const study::RunPlan& run);

int run_one_part(const RunArguments& a, const study::RunPlan& run, const study::PartChoice& choice,
                 const std::string& command);
int plan_parts(const RunArguments& a, const PlanArguments& plan);
/// `part`: to a larger part, not to a result.
int merge_files(const RunArguments& a, const std::vector<std::string>& names, const std::string& inputs, bool part);
int status_of(const std::string& folder);

}  // namespace surveymc::cli
