#pragma once
/// Part files: the tallies of a sweep point or of a shard of the trials, with the config that they belong to, until
/// all parts are merged. One record (record.h), written whole or not at all (docs/results-format.md).
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "checkpoint/record.h"
#include "config/input_file.h"
#include "config/input_table.h"
#include "montecarlo/run_blocks.h"
#include "store/result_file.h"

namespace surveymc::checkpoint {

/// Blocks of one sweep point.
struct PartPiece {
  std::uint64_t point = 0;
  montecarlo::BlockRange blocks;    ///< first .. end - 1
  std::uint64_t blocks_in_all = 0;  ///< of the point, at most; 0: a point without trials
  bool whole = false;               ///< all of the point, even if a stopping rule ended it before blocks_in_all
  std::vector<montecarlo::Subtree> subtrees = {};
  std::string result = {};  ///< of a point without trials: its tables and maps (study/point_result_bytes.h)
};

struct Part {
  RunKey key;
  std::string title, experiment;
  std::string config;                      ///< resolved TOML
  std::vector<config::InputTable> inputs;  ///< files that it names
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references = {};  ///< files that were too large for that
  std::string folder = {};                              ///< of the config, absolute: where those files are
  std::uint64_t points = 0;                             ///< of the whole run
  std::string command;
  store::RunInfo run;
  std::vector<PartPiece> pieces;
};

/// Throws IoError.
void write_part(const std::filesystem::path& path, const Part& part);

/// Throws IoError if it is missing, no part file, or damaged.
Part read_part(const std::filesystem::path& path);

/// Whether there is a part file, whole or damaged.
enum class PartState { missing, whole, damaged, foreign };
PartState part_state(const std::filesystem::path& path);

}  // namespace surveymc::checkpoint
