#pragma once
/// What a document with a log does otherwise. Internal to the module.
#include <filesystem>
#include <optional>
#include <string>

#include "config/key_log.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// Gives a point's config the values that the log supposes.
void apply_suppositions(const KeyLog& log, TomlNode& root);

/// The file of this path, "configs/thesis/traj1.csv", as it came with the program.
std::optional<std::string> shipped_text(const std::filesystem::path& path);

}  // namespace surveymc::config
