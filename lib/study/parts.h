#pragma once
/// A run in parts: one sweep point, or one shard of the trials (a slice of whole blocks), or both. Merged they give the
/// result of the whole run, bit for bit.
#include <optional>
#include <string>
#include <vector>

#include "checkpoint/part_file.h"
#include "study/experiment.h"

namespace surveymc::study {

struct PartChoice {
  std::optional<std::uint64_t> point;  ///< all points otherwise
  std::uint64_t shard = 0, shards = 1;
};

/// "point-00003", "shard-2-of-5", "point-00003-shard-2-of-5".
std::string part_name(const PartChoice& choice);

/// Throws InputError if the run has no such part: a number is out of range, or there are shards where a point has no
/// trials or a [stop] rule, which looks at all trials so far.
void check_choice(const RunPlan& run, const PartChoice& choice);

/// The pieces of a part without their tallies.
std::vector<checkpoint::PartPiece> part_pieces(const RunPlan& run, const PartChoice& choice);

/// Computes a part and fills in all members but key.program, command and run.
checkpoint::Part run_part(const RunPlan& run, const PartChoice& choice, const montecarlo::RunOptions& options,
                          const Checkpoint& checkpoint);

/// Blocks of each point that no piece has, rising. `whole` is every point of a run, as part_pieces() gives it.
std::vector<std::vector<montecarlo::BlockRange>> missing_blocks(
    const std::vector<checkpoint::PartPiece>& whole, const std::vector<const checkpoint::PartPiece*>& pieces);

/// True if all blocks of `choice` are there.
bool is_covered(const std::vector<checkpoint::PartPiece>& choice,
                const std::vector<std::vector<montecarlo::BlockRange>>& missing);

/// "0-3,7", as Slurm's --array wants it.
std::string array_list(const std::vector<std::uint64_t>& rising);

/// Config and files of a part, read again.
config::Config config_of(const checkpoint::Part& part, const std::string& label, const std::string& folder = {});

/// The result of the whole run, whatever the order, number and overlap of the parts. Throws InputError that names what
/// is missing. All parts must have the run's key (not checked here).
store::Result merge_parts(const RunPlan& run, const std::vector<checkpoint::Part>& parts,
                          const montecarlo::RunOptions& options);

}  // namespace surveymc::study
