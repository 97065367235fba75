#pragma once
/// Surveys and readings in the forms of other programs, read by `surveymc import` (docs/results-format.md).
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/input_table.h"

namespace surveymc::config {

enum class ForeignKind { survey, readings };

/// Options of the script beside the file: name without dashes and value ("depth-unit", "ft").
using ImportOptions = std::vector<std::pair<std::string, std::string>>;

struct ReadTable {
  InputTable table;
  std::string told;                   ///< what was read and how, in one line; "" for a CSV of our own form
  std::vector<std::string> warnings;  ///< what is doubtful in a file of another form
};

/// The file at `place`, in our own form or, by the script, in another one: text with any separator or fixed columns,
/// LAS, WITSML, Excel. `path`: its name for messages and in the table. The azimuth column of a survey in another form
/// has the north that the file names in its name: `azimuth_grid_deg`; `azimuth_unreferenced_deg` if the file names
/// none.
///
/// Throws IoError if the file or the script cannot be read, InputError "path:line: ...: rule: way out" for the rest;
/// ways out are the keys of `options`, with `key_prefix` before them, and the command that makes a CSV.
ReadTable read_any_form(const std::filesystem::path& place, const std::string& path, ForeignKind kind,
                        const ImportOptions& options, const std::string& key_prefix = "survey.");

}  // namespace surveymc::config
