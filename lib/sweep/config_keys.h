#pragma once
/// Every key that configs of an experiment may have, as its own reader asks for them (config/key_log.h).
#include <string>
#include <vector>

#include "config/key_log.h"
#include "store/table.h"
#include "study/experiment.h"

namespace surveymc::sweep {

/// A key and all that its getters have said.
struct ListedKey {
  std::string key;    ///< with the names of its tables; [] in an array of tables
  std::string usual;  ///< the column `default` of config_keys()
  config::KeyUse use;
  bool is_required = false;  ///< in every config, or in every table of its array, that comes with the program
};

/// The rows of config_keys().
std::vector<ListedKey> listed_keys(const study::Experiment& experiment,
                                   config::KeysOf which = config::KeysOf::all_branches);

/// One row a key, in alphabetical order behind those that every file has: `key, type, unit, default, rule, example,
/// meaning`, all text. default: "must be given", "needed in [TABLE]" where the table is, "needed by other keys", "-"
/// (may be absent), a value as TOML, or "by other keys".
///
/// The reader reads all points of the configs that come with the program; then each config again with one supposition
/// after the other (another word of a choice, a switch, a table that is not there), and, where that makes it miss keys,
/// with these. So it also shows the keys of branches that no config takes. Takes some seconds
/// at most; without suppositions, for the keys of shipped configs alone, a twentieth of that.
store::Table config_keys(const study::Experiment& experiment, config::KeysOf which = config::KeysOf::all_branches);

}  // namespace surveymc::sweep
