#pragma once
/// The log of all keys that a config's readers were asked for. `surveymc keys` is made of it, so that no key is listed
/// by hand. A config with a log may also be read as if keys had other values, stood there or were gone, which shows the
/// keys of branches that no example takes.
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.h"

namespace surveymc::config {

/// All that getters have said of one key.
struct KeyUse {
  std::vector<std::string> types;     ///< "number", "integer", "text", "CSV file", ...; none: only has() was asked
  std::vector<std::string> rules;     ///< "in [0, 90]"
  std::vector<std::string> defaults;  ///< as TOML; "" stands for a key that may be absent
  std::vector<std::string> choices;   ///< words that are allowed
  std::vector<Range> ranges;          ///< of its numbers; one without ends where every number is right
  std::vector<std::string> meanings;  ///< what the key is, in words; several where it depends on other keys
  bool may_be_absent = false;         ///< has() was asked
  bool has_other_words = false;       ///< a getter of text takes words besides the choices
  std::string example;                ///< the first value that was seen, as TOML
  std::string sample;                 ///< a value that its own getter takes, as TOML; "" where none is known
  bool is_needed = false;             ///< a getter without a default has asked
};

/// What a getter asks for.
struct KeyQuestion {
  std::string type, rule = {};            ///< rule: "must be in [0, 90]"; "" if every value of the type is right
  std::string sample = {};                ///< a value that the getter takes, as TOML
  std::vector<std::string> choices = {};  ///< words that are allowed
  std::optional<Range> range = {};        ///< of the numbers, where it asks for any
};

struct KeyLog {
  /// By key; elements of arrays of tables are alike: "leg[].from_md_m".
  std::map<std::string, KeyUse> keys;

  // Suppositions for the next reader of a point, by full key ("leg[0].from_md_m").
  std::map<std::string, std::string> supposed;  ///< values as TOML
  std::set<std::string> gone;                   ///< keys that are left out
  std::set<std::string> said;                   ///< keys of which has() says yes

  // What the last reader showed, by full key.
  std::set<std::string> asked, denied;  ///< asked for at all; has() has said no
  std::string with_default;             ///< the last key that a getter with a default asks for
  std::string missing, refused;         ///< the key that ended the reading: it is not there, or the study refuses it

  /// A getter asks for a key. `example`: its value as TOML, "" if it has none. `fallback`: as TOML; "" if the rule
  /// would refuse it, nothing if the getter has none.
  void note(const std::string& full_key, std::string_view meaning, const KeyQuestion& question,
            const std::string& example, const std::optional<std::string>& fallback);
  KeyUse& use(const std::string& full_key) { return keys[without_indices(full_key)]; }
  static std::string without_indices(const std::string& full_key);
};

/// A config that comes with the program, with everything that configs name: configs/ as it was at the build.
const std::vector<InputText>& shipped_config_files();

// config_with_log() (config.h): a config among shipped_config_files(), read with a log. It reads the files among those
// that it names, and no others.

/// The keys that Config itself reads, of an experiment whose readers ask for `asked`.
std::map<std::string, KeyUse> keys_of_every_file(const std::map<std::string, KeyUse>& asked);

/// The unit in which a key ends; "" if it has none.
std::string unit_of_key(const std::string& key);

}  // namespace surveymc::config
